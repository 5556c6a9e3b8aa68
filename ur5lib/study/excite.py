"""`ur5 excite`: a trajectory designed for an arm, its place, a question and what is known."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from pydantic import ValidationError

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.excitation.design import design
from ur5lib.excitation.files import summary_of, write_files
from ur5lib.excitation.limits import Cell
from ur5lib.excitation.objective import Task
from ur5lib.excitation.problem import (
    INDEPENDENT,
    Maps,
    Noise,
    Problem,
    build_problem,
    nominal_maps,
)
from ur5lib.excitation.questions import QUESTIONS
from ur5lib.excitation.worth import Worth
from ur5lib.identification.currents import CurrentFit, JointFit
from ur5lib.pipeline.records.motion import Motion
from ur5lib.report.excitation_figure import excitation_figure
from ur5lib.report.house_style import save
from ur5lib.robots.collisions import Surroundings
from ur5lib.robots.description import Robot
from ur5lib.strict import read_yaml
from ur5lib.study.exported import described, identified
from ur5lib.study.known_parameters import NORMAL95
from ur5lib.tables import read_json
from ur5lib.timeseries.arrays import Array

KEPT = ("torque_constant", "offset", "coulomb", "viscous", "load")  # of a fit's coefficients
MOST_TOLD = 6  # parameters whose standard errors are printed


@dataclass(frozen=True)
class Wish:
    """What `ur5 excite` was asked: see its options."""

    robot: str
    seconds: float
    question: str
    results: Path | None
    table: float | None
    boxes: Path | None
    seed: int


def excite(wish: Wish, folder: Path) -> Iterator[str]:
    """Design a trajectory, write its files into a folder, and yield what it is worth.

    Raises InputError for a wrong option, for results that are not there, and where a limit leaves
    no room.
    """
    if wish.question not in QUESTIONS:
        raise InputError(f"--question {wish.question!r}: give one of {', '.join(QUESTIONS)}")
    if folder.exists() and not folder.is_dir():
        raise InputError(f"--write {folder} is a file; name a folder")
    task = task_of(wish)
    found = design(task, wish.seed)
    worth = Worth.of(task, found.path)
    asked = {"robot": wish.robot, "question": wish.question, "seed": wish.seed}
    summary = asked | summary_of(task, found, worth)
    drawing = excitation_figure(task.cell.robot, found.path, found.margins, task.problem, worth)
    write_files(folder, wish.robot, task, found.path, summary)
    save(drawing, folder / "excitation.svg")
    yield from found.margins.lines()
    yield from _worth_lines(task.problem, worth)
    yield f"{folder} written; next: ur5 record STUDY NAME --move {folder}/trajectory.csv --speed 1"


def task_of(wish: Wish) -> Task:
    """Return what is to be designed."""
    arm = described(wish.robot) if wish.results is None else identified(wish.robot, wish.results)
    cell = Cell.of(arm, surroundings(wish.table, wish.boxes))
    maps = nominal_maps(arm) if wish.results is None else fitted_maps(arm, wish.results)
    problem = build_problem(arm, cell.model, maps, has_payload=wish.question == "payload")
    earlier = problem.prior
    if wish.results is not None:
        earlier = earlier + earlier_information(problem, cell.model, wish.robot, wish.results)
    criterion = QUESTIONS[wish.question](problem, cell.model)
    return Task(cell, problem, criterion, earlier, wish.seconds)


def surroundings(table: float | None, boxes: Path | None) -> Surroundings:
    """Return a table [m] and the boxes of a YAML file. Raises InputError where they are wrong."""
    if table is not None and not math.isfinite(table):
        raise InputError(f"--table {table}: give its height in the base frame [m]")
    try:
        listed = [] if boxes is None else read_yaml(boxes)
        return Surroundings(table=table, boxes=listed)
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise InputError(f"--boxes {boxes} cannot be read: {error}") from error
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise InputError(
            f"{boxes}: {where}: {first['msg']}; list boxes as {{center: [x, y, z], "
            "size: [x, y, z]}} in metres, base frame"
        ) from error


def fitted_maps(arm: Robot, results: Path) -> Maps:
    """Return the maps to currents that a study fitted, with its noise; nominal without a fit."""
    nominal, folder = nominal_maps(arm), results / "parameters" / arm.name
    friction, model = (_summary(folder / f"{n}.json") for n in ("friction", "identification"))
    torque = np.array(model.get("noise") or nominal.noise.torque)
    if not friction["from"]:
        return Maps(nominal.coefficients, Noise(torque, nominal.noise.current))
    fit = CurrentFit.from_plain(friction["fit"])
    bands = np.array([joint.band_moving for joint in fit.joints]) / NORMAL95
    current = np.where(np.isfinite(bands), bands, nominal.noise.current)
    return Maps(np.array([_kept(joint) for joint in fit.joints]), Noise(torque, current))


def _kept(joint: JointFit) -> list[float]:
    """Return a joint's coefficients of KEPT; zero for a term that the fit has not."""
    known = dict(zip(joint.names(), joint.estimate.coefficients.tolist(), strict=True))
    return [known.get(name, 0.0) for name in KEPT]


def earlier_information(problem: Problem, model: LinkModel, robot: str, results: Path) -> Array:
    """Return the information (P, P) of the recordings that a study fitted to."""
    folder = results / "parameters" / robot
    fitted = [
        set(_summary(folder / f"{name}.json")["from"]) for name in ("friction", "identification")
    ]
    total = np.zeros_like(problem.prior)
    for name in sorted(set.union(*fitted)):
        motion = Motion.read(results / "recordings" / name / "motion.parquet")
        every = max(1, round(INDEPENDENT / float(np.median(np.diff(motion.time)))))
        states = np.stack([motion.q, motion.qd, motion.qdd])[:, ::every]
        q, qd, qdd = states[:, np.isfinite(states).all(axis=(0, 2))]
        total += problem.information(model.regressor(q, qd, qdd), qd, INDEPENDENT)
    return total


def _summary(path: Path) -> Any:
    if not path.is_file():
        raise InputError(f"{path} does not exist; check --results and --robot, and run snakemake")
    return read_json(path)


def _worth_lines(problem: Problem, worth: Worth) -> Iterator[str]:
    """Yield what a trajectory is worth, and the parameters that gain least from it."""
    yield (
        f"log det of the information: {worth.log_det:.1f}, {worth.gain:.1f} more than before; "
        f"condition number of the regressor {worth.regressor_condition:.0f}, of the whole problem "
        f"{worth.condition:.0f}"
    )
    ratio = worth.after / worth.before
    yield "predicted standard errors of the parameters that gain least, before and after:"
    names, units = problem.names(), problem.units()
    for k in np.argsort(-ratio, kind="stable")[:MOST_TOLD]:
        yield f"  {names[k]:<34} {worth.before[k]:>9.2g} {worth.after[k]:>9.2g} {units[k]}"
