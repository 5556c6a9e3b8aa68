"""RMSE of a fit to one recording, tested on another."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["robot", "fitted_on", "tested_on", "joint", "rmse_2hz"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("friction"):
        yield from cross_validation_rows(name, summary)


def cross_validation_rows(robot: str, friction: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the RMSE of a fit to one recording, tested on another, from friction.json."""
    names = friction["from"]
    for fitted, tested_rows in zip(names, friction.get("cross_validation", []), strict=True):
        for tested, rmse in zip(names, tested_rows, strict=True):
            for joint in range(6):
                yield {
                    "robot": robot,
                    "fitted_on": fitted,
                    "tested_on": tested,
                    "joint": joint + 1,
                    "rmse_2hz": rmse[joint],
                }
