"""Answers to single questions about a study, from the tables of its last run."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.errors import InputError
from ur5lib.finished import StudyFiles
from ur5lib.records.codes import Found
from ur5lib.study.address import RESULTS_FOLDER
from ur5lib.study.reading import read_study
from ur5lib.workspace.topics import modules_of_topics

NO_FIT = "no motion, or no contact-free recording of this arm"
MAX_PAYLOAD = 35.0  # kg; above the payload of the maker's largest arm


def payload_answers(study: Path) -> Iterator[str]:
    """Yield the payload of each recording, line by line.

    Raises InputError where the study was not run.
    """
    quality = finished_study(study).table("quality")
    changes = quality[quality["code"] == Found.LOAD_CHANGES].set_index("recording")["detail"]
    signs = stop_signs(study, quality)
    for name, loads, sensed in _payloads(study):
        held = [f"held in it: {changes[name]}"] if name in changes else []
        yield f"{name}: {'; '.join([*_carried(loads, sensed, signs.get(name, NO_FIT)), *held])}"


def stop_signs(study: Path, quality: pd.DataFrame) -> dict[str, str]:
    """Return the stop sign of each recording that has one, else that of a recording to fit on of
    its arm.
    """
    stopped = quality[quality["severity"] == "stop"].drop_duplicates("recording")
    own = dict(zip(stopped["recording"], stopped["detail"], strict=True))
    recordings = read_study(study).recordings
    of_arm = {
        one.arm.known_as: f"{one.name}: {own[one.name]}"
        for one in reversed(recordings)
        if one.role == "fit" and one.name in own
    }
    of_fit = {r.name: of_arm[r.arm.known_as] for r in recordings if r.arm.known_as in of_arm}
    return of_fit | own


def payload_numbers(study: Path) -> list[dict[str, Any]]:
    """Return the mass on each recording's flange [kg] by `currents` and by `sensor`, with its 95 %
    interval from low to high and the configured mass; None if it is not determined.

    Raises InputError if the study was not run.
    """
    return [
        {
            "recording": name,
            "currents": next((_whole(row) for row in loads.itertuples()), None),
            "sensor": next(iter(sensed[["value", "low", "high"]].to_dict("records")), None),
        }
        for name, loads, sensed in _payloads(study)
    ]


def _payloads(study: Path) -> Iterator[tuple[str, pd.DataFrame, pd.DataFrame]]:
    """Yield (recording, its rows of payload.csv, its rows of the masses on a wrist sensor)."""
    results = finished_study(study)
    loads = results.table("payload")
    empty = pd.DataFrame(columns=["recording", "value", "low", "high"])
    sensed = pd.concat(
        [empty, *(topic.masses(results) for topic in modules_of_topics("payload").values())]
    )
    for recording in read_study(study).recordings:
        its = [table[table["recording"] == recording.name] for table in (loads, sensed)]
        yield recording.name, *its


def _whole(row: Any) -> dict[str, float]:
    """Return the whole mass on the flange and the ends of its interval [kg], and the configured
    mass; row: on the undeclared mass.
    """
    whole = {name: row.configured + getattr(row, name) for name in ("mass", "low", "high")}
    return whole | {"configured": row.configured}


def _carried(loads: pd.DataFrame, sensed: pd.DataFrame, why_not: str = NO_FIT) -> Iterator[str]:
    """Yield the mass on the flange by currents and by sensor, from rows of their tables; why_not:
    why there may be no rows.
    """
    if loads.empty:
        yield f"undetermined by currents ({why_not})"
    for row in loads.itertuples():
        whole = _whole(row)
        configured = f"configured {whole.pop('configured'):.2f} kg{_place(row)}"
        yield f"{_mass(**whole)}, {configured}"
    for row in sensed.itertuples():
        yield f"by the wrist sensor {row.value:.3f} kg ({row.low:.3f} to {row.high:.3f})"


def _mass(mass: float, low: float, high: float) -> str:
    """Return a mass and its 95 % interval [kg] in words.

    If the interval contains zero, its end farther from zero is the limit for an undetected load.
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


def finished_study(study: Path) -> StudyFiles:
    """Return the results of the last run of a study."""
    folder = RESULTS_FOLDER / read_study(study).study
    if not (folder / "tables").is_dir():
        raise InputError(f"{folder} has no tables; make them: ur5 run {study}")
    return StudyFiles(folder)
