"""Answers to single questions about a study, from the tables of its last run."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.errors import InputError
from ur5lib.finished import FinishedStudy
from ur5lib.study.address import RESULTS_FOLDER
from ur5lib.study.reading import read_study

MAX_PAYLOAD = 35.0  # kg: more than the maker's largest arm carries


def payload_answers(study: Path) -> Iterator[str]:
    """Yield the payload of each recording, line by line.

    Raises InputError where the study was not run.
    """
    results = finished_study(study)
    loads = results.table("payload")
    sensed = pd.DataFrame(columns=["recording", "quantity"])
    if "audit" in results.tables:  # which its topic makes
        sensed = results.table("audit")
    for recording in read_study(study).recordings:
        rows = [table[table["recording"] == recording.name] for table in (loads, sensed)]
        yield f"{recording.name}: {'; '.join(_carried(*rows))}"


def _carried(loads: pd.DataFrame, sensed: pd.DataFrame) -> Iterator[str]:
    """Yield the mass on the flange by currents and by sensor, from rows of their tables."""
    if loads.empty:
        yield "undetermined by currents (no motion, or no contact-free recording of this arm)"
    for row in loads.itertuples():
        mass, low, high = (row.configured + part for part in (row.mass, row.low, row.high))
        yield f"{_mass(mass, low, high)}, configured {row.configured:.2f} kg{_place(row)}"
    for row in sensed[sensed["quantity"] == "mass"].itertuples():
        yield f"by the wrist sensor {row.value:.3f} kg ({row.low:.3f} to {row.high:.3f})"


def _mass(mass: float, low: float, high: float) -> str:
    """Return a mass and its 95 % interval [kg] in words.

    If the interval reaches below zero, its end farther from zero bounds an undetectable load.
    """
    bound = max(high, -low)
    if bound > MAX_PAYLOAD:
        return f"the currents do not determine the mass (error up to {bound:.0f} kg)"
    if low <= 0:
        return f"by the currents no certain load, at most {bound:.2f} kg"
    return f"by the currents {mass:.2f} kg ({low:.2f} to {high:.2f})"


def _place(row: Any) -> str:
    """Return the centre of mass of the undeclared part of a load, empty where it is uncertain."""
    if np.isnan(row.center_of_mass_x):
        return ""
    center, error = (
        [getattr(row, f"{name}_{axis}") for axis in "xyz"]
        for name in ("center_of_mass", "center_of_mass_std")
    )
    parts = ", ".join(f"{c:.3f} ± {e:.3f}" for c, e in zip(center, error, strict=True))
    return f"; {row.mass:.2f} kg are undeclared, at ({parts}) m in frame 6"


def finished_study(study: Path) -> FinishedStudy:
    """Return the results of the last run of a study."""
    folder = RESULTS_FOLDER / read_study(study).study
    if not (folder / "tables").is_dir():
        raise InputError(f"{folder} has no tables; make them: ur5 run {study}")
    return FinishedStudy(folder)
