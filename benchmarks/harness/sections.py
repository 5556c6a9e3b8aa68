"""The page's sections that other benchmarks measure, from their tables in results/."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.harness.curve import (
    days_table,
    forces_table,
    learning_findings,
    learning_table,
)
from benchmarks.harness.links import link_table
from benchmarks.harness.prediction import prediction_findings, prediction_table
from benchmarks.harness.pushes import EACH, FORCES, PLACES
from benchmarks.harness.simulated import better_than_ours, refused_on_some, simulated_table
from ur5lib.tables import read_csv

Section = dict[str, Any]


def sections(results: Path) -> dict[str, Section | None]:
    """Return what each section holds, None where its table is missing."""
    made: dict[str, tuple[str, Callable[[pd.DataFrame], Section]]] = {
        "simulated": ("simulated_contacts", simulated),
        "links": ("contact_link", links),
        "currents": ("current_prediction", currents),
        "curve": ("learning_curve", few_recordings),
        "days": ("days_left_out", lambda table: {"table": days_table(table)}),
        "curve_forces": ("learning_curve_forces", lambda table: {"table": forces_table(table)}),
    }
    files = {name: (results / f"{file}.csv", section) for name, (file, section) in made.items()}
    return {
        name: section(read_csv(path)) if path.exists() else None
        for name, (path, section) in files.items()
    }


def simulated(table: pd.DataFrame) -> Section:
    """Return the section on simulated arms."""
    return {
        "title": f"{table['seed'].nunique()} seeds.",
        "arms": ", ".join(table["arm"].unique()),
        "pushes": EACH * len(PLACES),
        "forces": f"{FORCES[0]:g} to {FORCES[1]:g} N",
        "better": [*better_than_ours(table)],
        "refused": "; ".join(refused_on_some(table)),
        "table": simulated_table(table),
    }


def links(table: pd.DataFrame) -> Section:
    """Return the section on the link that was touched."""
    title = (
        f"{len(table)} contacts with a simulated UR5 in motion, {table['seed'].nunique()} seeds."
    )
    return {"title": title, "table": link_table(table)}


def currents(table: pd.DataFrame) -> Section:
    """Return the section on predicted currents."""
    return {"findings": [*prediction_findings(table)], "table": prediction_table(table)}


def few_recordings(table: pd.DataFrame) -> Section:
    """Return the section on currents by few recordings."""
    return {"findings": [*learning_findings(table)], "table": learning_table(table)}
