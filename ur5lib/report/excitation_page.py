"""The page of a designed trajectory: predicted errors, the motion, and how to record it."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ur5lib.excitation.design import Design
from ur5lib.excitation.objective import Worth
from ur5lib.excitation.problem import Problem
from ur5lib.report.cells import significant
from ur5lib.report.document import (
    Cell,
    Code,
    Document,
    Items,
    Paragraph,
    Picture,
    Reference,
    Section,
    Table,
)

DATA = "excitation.json"
LOAD = "a known load on the flange (--payload) or a longer motion (--seconds) may"


def excitation_page(
    asked: Mapping[str, Any],
    before: Sequence[str],
    command: str,
    found: Design,
    problem: Problem,
    worth: Worth,
    drawing: Path,
) -> Document:
    """Return the page of a trajectory.

    asked: robot, question and seed; before: the steps before recording, one sentence each;
    command: the command that records it; found: the trajectory; worth: predicted standard errors;
    drawing: the figure.
    """
    motion = Picture(
        "Angles, amplitudes of their harmonics, largest shares of the limits, standard errors "
        "after over before, and the arm's sweep from three sides, flange's path in colour.",
        drawing,
        "angles over time, spectra, margins, standard errors and three views of the sweep",
        "motion",
        DATA,
    )
    sections = [
        Section(
            "What it would determine",
            [Paragraph([_worst(problem, worth), Reference("parameters"), " lists all."])],
        ),
        Section("The motion", [motion, Items(found.margins.lines()[len(found.margins.used) :])]),
        Section("How to record it", [Items([*before]), Code(command)]),
        Section("All parameters", [_parameters(problem, worth)]),
    ]
    return Document(
        title=f"What to record next on {asked['robot']}",
        subtitle=f"A motion of {found.path.seconds:g} s designed for the question "
        f"“{asked['question']}”, seed {asked['seed']}",
        sections=sections,
    ).numbered()


def _worst(problem: Problem, worth: Worth) -> str:
    """Return how much the recording would lower the error of the least determined parameter."""
    names, order = problem.names(), worth.least_determined()
    worst, lowered = order[0], order[~worth.hardly_lowered()[order]]
    least = f"Least determined so far is the {names[worst]}"
    if worst in lowered:
        return (
            f"{least}: this recording would lower its standard error, "
            f"{_short(worth.before[worst])} {problem.units()[worst]}, to {_left(worth, worst)}. "
        )
    return f"{least}, whose error this recording would hardly lower: {LOAD}. " + (
        f"The least determined parameter whose error it would lower is the {names[lowered[0]]}: "
        f"to {_left(worth, lowered[0])}. "
        if len(lowered)
        else ""
    )


def _left(worth: Worth, parameter: int) -> str:
    return f"{worth.after[parameter] / worth.before[parameter]:.0%}"


def _parameters(problem: Problem, worth: Worth) -> Table:
    """Return the table of all parameters, the least determined first."""
    names, units, left = problem.names(), problem.units(), 100 / worth.prior
    rows = [
        [
            Cell(names[k]),
            Cell(units[k]),
            Cell(_short(worth.before[k])),
            Cell(_short(worth.after[k])),
            Cell(f"{worth.before[k] * left[k]:.1f} %"),
            Cell(f"{worth.after[k] * left[k]:.1f} %"),
        ]
        for k in worth.least_determined()
    ]
    header = ["parameter", "unit", "before", "after", "before, of prior", "after, of prior"]
    caption = (
        "Predicted standard errors before and after the recording, least determined first. 100 % "
        "of the prior means that no recording determines the parameter."
    )
    return Table(caption, header, rows, "parameters", DATA)


def _short(value: float) -> str:
    return significant(value, 2)
