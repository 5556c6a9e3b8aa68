"""The error in contact with each part of the estimate left out."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["recording", "variant", "component", "mae", "coverage95", "interval_score95"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("ablation"):
        yield from ablation_rows(name, summary)


def ablation_rows(recording: str, ablation: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the error in contact without each part of the estimate, from ablation.json."""
    for variant, figures in ablation.items():
        for i, component in enumerate(("Fx", "Fy", "Fz")):
            yield {
                "recording": recording,
                "variant": variant,
                "component": component,
                **{name: values[i] for name, values in figures.items()},
            }
