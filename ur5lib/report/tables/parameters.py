"""Base parameters of the identified model."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["robot", "parameter", "value", "std_error", "determined"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("identification"):
        yield from parameter_rows(name, summary)


def parameter_rows(robot: str, identification: Mapping[str, Any]) -> Iterator[Row]:
    """Yield base parameters of the identified model, from identification.json."""
    for row in identification.get("parameters", []):
        determined = "yes" if row["determined"] else "no"
        yield {"robot": robot, **row, "determined": determined}
