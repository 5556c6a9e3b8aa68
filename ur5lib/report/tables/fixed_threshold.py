"""Each estimate against the fixed threshold of the thesis, along each axis."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["recording", "estimate", "component", "force_n", "pushes", "found", "time_above"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("detection"):
        yield from fixed_threshold_rows(name, summary)


def fixed_threshold_rows(recording: str, detection: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the pushes found and the share of the time above, from detection.json."""
    for estimate, found in detection.items():
        for axis, figures in found["axes"].items():
            yield {
                "recording": recording,
                "estimate": estimate,
                "component": f"F{axis}",
                "force_n": figures["force"],
                **{name: figures.get(name) for name in ("pushes", "found", "time_above")},
            }
