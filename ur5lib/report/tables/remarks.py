"""Remarks of the fits by joint, and reasons of fits that failed."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["robot", "step", "joint", "remark"]
STOP = "stop sign"  # a step of its own: no forces are stated


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    summaries = {
        "identification": results.all("identification"),
        "friction": results.all("friction"),
        "contact forces": results.all("residuals"),
    }
    for robot in results.paths_of("arm"):
        yield from remark_rows(robot, {step: found[robot] for step, found in summaries.items()})


def remark_rows(robot: str, steps: Mapping[str, Mapping[str, Any]]) -> Iterator[Row]:
    """Yield remarks of the fits by joint, and reasons of failed fits; steps: summaries by name."""
    for step, summary in steps.items():
        for remark in [*summary.get("remarks", []), *filter(None, [summary.get("refused")])]:
            yield {"robot": robot, "step": step, "remark": remark}
        if "stopped" in summary:
            yield {"robot": robot, "step": STOP, "remark": summary["stopped"]}
        for joint, fit in enumerate(summary.get("fit", {}).get("joints", []), start=1):
            for remark in fit["remarks"]:
                yield {"robot": robot, "step": step, "joint": joint, "remark": remark}
