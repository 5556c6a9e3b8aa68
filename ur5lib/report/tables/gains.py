"""Gains of the closed loop that a recording determines."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["recording", "joint", "gain", "unit", "value", "std_error", "low", "high", "determined"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("gains"):
        yield from gain_rows(name, summary)


def gain_rows(recording: str, gains: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the gains of a recording, from gains.json: a value only if it is determined.

    low and high: of the range that fits equally well, empty where it reaches a search bound.
    """
    for joint, found in enumerate(gains.get("joints", []), start=1):
        for gain, unit in (("position", "1/s2"), ("velocity", "1/s")):
            known = found[gain]["determined"]
            yield {
                "recording": recording,
                "joint": joint,
                "gain": gain,
                "unit": unit,
                "value": found[gain]["best"] if known else None,
                "std_error": found[gain]["std_error"] if known else None,
                "low": _inside(found[gain], "low"),
                "high": _inside(found[gain], "high"),
                "determined": "yes" if known else "no",
            }


def _inside(gain: Mapping[str, Any], end: str) -> float | None:
    return None if gain[end] in (gain["grid"][0], gain["grid"][-1]) else gain[end]
