"""Errors of each estimate in each contact that the sensor saw."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = [
    "recording",
    "estimate",
    "contact",
    "start_s",
    "end_s",
    "component",
    "peak",
    "peak_error",
    "impulse",
    "impulse_error",
    "onset_error_s",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("forces"):
        yield from contact_error_rows(name, summary)


def contact_error_rows(recording: str, summary: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the errors of each estimate in each contact at the sensor, from forces.json."""
    for estimate, contacts in summary.get("contacts", {}).items():
        for row in contacts:
            yield {"recording": recording, "estimate": estimate, **row}
