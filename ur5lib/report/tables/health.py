"""Each joint's condition on each date: friction, torque constants, offsets, noise, lost frames."""

from collections.abc import Iterator

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["robot", "date", "joint", "quantity", "value", "std_error", "temperature_c"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows; `lost_frames` is of all joints."""
    for robot, health in results.each("health"):
        yield from ({"robot": robot} | row for row in health["dates"])
