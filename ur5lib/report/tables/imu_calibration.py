"""Calibration of an arm's IMU from all `fit` recordings."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["robot", "quantity", "axis", "unit", "value", "std_error", "described", "held_out"]
UNITS = {"mounting": "rad", "tilt": "rad", "gyroscope_bias": "rad/s", "place": "m"}


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("calibration"):
        yield from calibration_rows(name, summary)


def calibration_rows(robot: str, known: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the calibration of an arm's IMU from all `fit` recordings, from imu.json.

    `described` is the place in the arm's description; `held_out` the error on recordings left out
    with the estimated place by that with the described one: below 1, the estimated place is used.
    """
    found = known.get("all", {})
    for quantity, unit in UNITS.items() if found else ():
        values, errors = found[quantity], found[f"{quantity}_std"]
        for axis, value, std in zip("xyz", values, errors, strict=False):
            row: Row = {"robot": robot, "quantity": quantity, "axis": axis, "unit": unit}
            yield row | {"value": value, "std_error": std} | _beside(found, quantity, axis)


def _beside(found: Mapping[str, Any], quantity: str, axis: str) -> Row:
    """Return what stands beside an axis of the place."""
    if quantity != "place":
        return {}
    described = found["described"]["xyz".index(axis)]
    return {"described": described, "held_out": found["held_out"]}
