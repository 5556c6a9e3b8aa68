"""Findings about the files of every recording."""

from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["recording", "device", "finding", "severity", "count", "detail"]
REMEDY = "if one computer timestamps both this device and an IMU, list both under `hosts`"


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for recording, load in results.each("loads"):
        yield from stop_rows(recording, load["stop_signs"])
    yield from finding_rows(results.all("quality"), results.all("clocks"), results.all("forces"))


def stop_rows(recording: str, signs: Iterable[str]) -> Iterator[Row]:
    """Yield the stop signs of a recording, each a sentence."""
    for sign in signs:
        yield {
            "recording": recording,
            "device": "robot",
            "finding": "contradiction",
            "severity": "stop",
            "count": 1,
            "detail": sign,
        }


def finding_rows(
    qualities: Mapping[str, Any], clocks: Mapping[str, Any], forces: Mapping[str, Any]
) -> Iterator[Row]:
    """Yield the findings of quality.json, clocks.json and forces.json, each by recording."""
    for recording, quality in qualities.items():
        for finding in [
            *quality["findings"],
            *_copies(recording, qualities),
            *_poor_clocks(clocks.get(recording, {})),
            *_doubted_sensor(forces.get(recording, {})),
        ]:
            yield {"recording": recording, **finding}


def _poor_clocks(clocks: Mapping[str, Any]) -> Iterator[Row]:
    """Yield devices whose clock is known from start stamps only."""
    for device, clock in clocks.items():
        row = {"device": device, "severity": "warning", "count": 1}
        errors = clock["offset_std"], clock["end_std"]
        accuracy = "accurate to {:.2g} s at the start and {:.2g} s at the end".format(*errors)
        if clock["warning"]:
            detail = f"{clock['warning']}; {accuracy}"
            yield row | {"finding": "clock by stamps alone", "detail": detail}
        elif clock["drift"] is None:
            detail = f"its clock is known from its start stamp only, {accuracy}; {REMEDY}"
            yield row | {"finding": "unknown drift", "detail": detail}


def _doubted_sensor(forces: Mapping[str, Any]) -> Iterator[Row]:
    """Yield a force sensor that contradicts the motor currents or its tool's weight, or whose bias
    may be a push.
    """
    for doubted in ("mounting", "offset"):
        if forces.get(f"{doubted}_doubt"):
            yield {
                "device": "force",
                "finding": doubted,
                "severity": "warning",
                "count": 1,
                "detail": forces[f"{doubted}_doubt"],
            }


def _copies(recording: str, qualities: Mapping[str, Any]) -> Iterator[Row]:
    """Yield device files that are identical to those of another recording."""
    for device, checksum in qualities[recording]["files"].items():
        others = [
            other
            for other, quality in qualities.items()
            if other != recording and quality["files"].get(device) == checksum
        ]
        if others:
            used = "used" if device in qualities[recording]["devices"] else "not used"
            yield {
                "device": device,
                "finding": "same file",
                "severity": "note",
                "count": len(others),
                "detail": f"identical to the file of {', '.join(others)}; {used} here",
            }
