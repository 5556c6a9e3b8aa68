"""How well each model predicts a recording's currents."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["model", "recording", "fitted", "joint", "rmse", "rmse_2hz", "mae", "r2", "coverage95"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("currents"):
        yield from current_rows(name, summary)


def current_rows(recording: str, currents: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the errors of each model's prediction of a recording's currents, from currents.json."""
    for model, scores in currents["scores"].items():
        for joint in range(6):
            yield {
                "model": model,
                "recording": recording,
                "fitted": "yes" if currents["fitted"] else "no",
                "joint": joint + 1,
                "rmse": scores["rmse"][joint],
                "rmse_2hz": scores["rmse_lowpassed"][joint],
                "mae": scores["mae"][joint],
                "r2": scores["r2"][joint],
                "coverage95": scores["coverage"][joint],
            }
