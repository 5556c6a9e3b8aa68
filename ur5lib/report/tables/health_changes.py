"""Drifts and jumps of each joint's condition between dates."""

from collections.abc import Iterator

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "robot",
    "joint",
    "quantity",
    "kind",
    "first",
    "last",
    "before",
    "size",
    "std_error",
    "low",
    "high",
    "by_temperature",
    "chance",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for robot, health in results.each("health"):
        for change in health["changes"]:
            row = {"robot": robot, "by_temperature": change["explained"]} | change
            yield {name: row[name] for name in COLUMNS}
