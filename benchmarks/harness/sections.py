"""The page's sections that other benchmarks measure, from their tables in results/."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

from benchmarks.harness.curve import (
    days_table,
    forces_table,
    learning_findings,
    learning_table,
)
from benchmarks.harness.prediction import prediction_findings, prediction_table
from benchmarks.harness.pushes import EACH, FORCES, PLACES
from benchmarks.harness.simulated import better_than_ours, refused_on_some, simulated_table
from ur5lib.leaderboard.tables import markdown
from ur5lib.report.page.compose import shown_table
from ur5lib.report.results import Results
from ur5lib.tables import read_csv

Section = dict[str, Any]


def sections(results: Path) -> dict[str, Section | None]:
    """Return what each section holds, None where its table is missing."""
    made: dict[str, tuple[str, Callable[[pd.DataFrame], Section]]] = {
        "simulated": ("simulated_contacts", simulated),
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


def currents(table: pd.DataFrame) -> Section:
    """Return the section on predicted currents."""
    return {"findings": [*prediction_findings(table)], "table": prediction_table(table)}


def few_recordings(table: pd.DataFrame) -> Section:
    """Return the section on currents by few recordings."""
    return {"findings": [*learning_findings(table)], "table": learning_table(table)}


def detection_tables(folders: Sequence[Path]) -> str:
    """Return, for each study, its contacts at a force sensor, and its alarms where none is."""
    tables = ("forces.detections", "forces.alarms")
    bodies = [shown_table(table, judged(folder)) for folder in folders for table in tables]
    texts = [(body.header, [[cell.text for cell in row] for row in body.rows]) for body in bodies]
    return "\n\n".join(markdown(header, rows) for header, rows in texts if rows)


def judged(folder: Path) -> Results:
    """Return the detections of a study on recordings with a sensor, or of the role `validate`."""
    study = yaml.safe_load((folder / "configuration.yaml").read_text())
    table = read_csv(folder / "tables" / "detection.csv")
    untouched = table["recording"].isin(Results(study, {}, folder).with_role("validate"))
    known = table["force_class_n"].notna() | untouched
    return Results(study, {"detection": table[known]}, folder)
