"""Calibration of an arm's IMU from all `fit` recordings."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["robot", "quantity", "axis", "unit", "value", "std_error"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("calibration"):
        yield from calibration_rows(name, summary)


def calibration_rows(robot: str, known: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the calibration of an arm's IMU from all `fit` recordings, from imu.json."""
    found = known.get("all", {})
    for quantity, unit in (("mounting", "rad"), ("tilt", "rad"), ("gyroscope_bias", "rad/s")):
        for axis, value, std in zip(
            "xyz", found.get(quantity, []), found.get(f"{quantity}_std", []), strict=False
        ):
            yield {
                "robot": robot,
                "quantity": quantity,
                "axis": axis,
                "unit": unit,
                "value": value,
                "std_error": std,
            }
