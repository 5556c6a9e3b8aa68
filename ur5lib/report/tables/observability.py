"""What an arm's recordings let one observe: smallest pushes, and speeds of predicted friction."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "robot",
    "quantity",
    "joint",
    "speed_low",
    "speed_high",
    "speed_unit",
    "value",
    "std_error",
    "unit",
    "samples",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for robot, summary in results.each("observability"):
        yield from ({"robot": robot} | row for row in observability_rows(summary))


def observability_rows(summary: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the rows of one arm, from observability.json; an empty speed_high: any faster one.

    smallest_push_95: by speed of the flange; friction_in_band: share of the samples, by speed of
    the joint; least_velocity: from which on, up to speed_high, that share suffices.
    """
    for push in summary["pushes"]:
        yield {
            "quantity": "smallest_push_95",
            "speed_low": push["speed_low"],
            "speed_high": push["speed_high"],
            "speed_unit": "m/s",
            "value": push["force"],
            "std_error": push["std"],
            "unit": "N",
            "samples": push["tried"],
        }
    joints = {"speed_unit": "rad/s"}
    for own in summary["shares"]:
        part = {name: own[name] for name in ("joint", "speed_low", "speed_high", "samples")}
        yield joints | part | {"quantity": "friction_in_band", "value": own["share"], "unit": "1"}
    for own in summary["predicted"]:
        found = {"quantity": "least_velocity", "value": own["speed_low"], "unit": "rad/s"}
        yield joints | own | found
