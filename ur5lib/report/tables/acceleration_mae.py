"""MAE of the end effector's acceleration against the IMU."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.reference import PrintedTable, published
from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["recording", "estimate", "component", "mae", "printed", "zero_mae"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("accelerations"):
        yield from acceleration_errors(name, summary, results.printed.acceleration_mae)


def acceleration_errors(
    recording: str, summary: Mapping[str, Any], printed: PrintedTable | None
) -> Iterator[Row]:
    """Yield the MAE of the end effector's acceleration against the IMU, from accelerations.json."""
    values = published(printed, recording)
    for estimate, errors in summary["errors"].items():
        for index, (component, mae) in enumerate(errors["mae"].items()):
            yield {
                "recording": recording,
                "estimate": estimate,
                "component": component,
                "mae": mae,
                "printed": values[estimate][index] if estimate in values else None,
                "zero_mae": errors["zero_mae"][component],
            }
