"""How the dry friction of each joint reverses: what each model predicts of paths left out."""

from collections.abc import Iterator, Mapping
from typing import Any

from ur5lib.identification.friction import KARNOPP, PRESLIDING
from ur5lib.report.study_results import Row, StudyResults

COLUMNS = ["joint", "model", "distance_rad", "rmse", "chosen", "robot"]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    for robot, summary in results.each("friction"):
        yield from reversal_rows(robot, summary)


def reversal_rows(robot: str, friction: Mapping[str, Any]) -> Iterator[Row]:
    """Yield the cross-validated error [A] of Dahl's and Karnopp's friction, from friction.json."""
    joints = friction.get("fit", {}).get("joints", [])
    for number, joint in enumerate(joints, start=1):
        errors = joint["reversal_errors"]
        for distance, error in zip((*PRESLIDING, KARNOPP), errors, strict=bool(errors)):
            yield {
                "joint": number,
                "model": "karnopp" if distance == KARNOPP else "dahl",
                "distance_rad": None if distance == KARNOPP else distance,
                "rmse": error,
                "chosen": "yes" if distance == joint["presliding"] else "no",
                "robot": robot,
            }
