"""Whether published gains fit a recording as well as the best ones."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["recording", "model", "joint", "cost", "least_cost", "limit", "fits"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for name, summary in results.each("gains"):
        yield from published_gain_rows(name, summary)


def published_gain_rows(recording: str, gains: Mapping[str, Any]) -> Iterator[Row]:
    """Yield whether published gains fit as well as the best ones, from gains.json.

    Only of joints whose target moves.
    """
    for model, costs in gains.get("published", {}).items():
        for joint, (cost, found) in enumerate(zip(costs, gains["joints"], strict=True), start=1):
            if found["excited"]:
                yield {
                    "recording": recording,
                    "model": model,
                    "joint": joint,
                    "cost": cost,
                    "least_cost": found["cost"],
                    "limit": found["limit"],
                    "fits": "yes" if cost <= found["limit"] else "no",
                }
