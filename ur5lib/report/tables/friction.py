"""Torque constants, offsets and friction beside the thesis's."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ur5lib.report.study_results import Row, StudyResults
from ur5lib.robots.description import Robot, load_robot

COLUMNS = [
    "joint",
    "parameter",
    "value",
    "std_error",
    "prior_share",
    "known",
    "known_std",
    "contradicted",
    "thesis",
    "low",
    "high",
    "determined",
    "robot",
]


def rows(results: StudyResults) -> Iterator[Row]:
    """Yield the table's rows."""
    arms = results.paths_of("arm")
    for name, summary in results.each("friction"):
        yield from friction_rows(name, load_robot(arms[name]), summary)


def friction_rows(robot: str, arm: Robot, friction: Mapping[str, Any]) -> Iterator[Row]:
    """Yield torque constants, offsets and friction, and the thesis's values, from friction.json."""
    published = _published(arm)
    for row in friction.get("parameters", []):
        name, joint = row["name"], row["joint"]
        low, high = row["interval"]
        yield {
            "joint": joint,
            "parameter": name,
            "value": row["value"],
            "std_error": row["std_error"],
            "prior_share": row["prior_share"],
            **_known(friction, row),
            "thesis": published[name][joint - 1] if name in published else None,
            "low": low,
            "high": high,
            "determined": "yes" if row["determined"] else "no",
            "robot": robot,
        }


def _known(friction: Mapping[str, Any], row: Mapping[str, Any]) -> Row:
    """Return what was known of a torque constant, and a fitted one that contradicted this."""
    if row["name"] != "torque_constant":
        return {}
    joint, known = row["joint"] - 1, friction["known_constants"]
    return {
        "known": known["value"][joint],
        "known_std": known["std_error"][joint],
        "contradicted": friction["fit"]["joints"][joint]["contradicted"],
    }


def _published(arm: Robot) -> dict[str, Sequence[float]]:
    values: dict[str, Sequence[float]] = {}
    if arm.current_to_torque is not None:
        values["torque_constant"] = arm.current_to_torque.torque_constant
        values["offset"] = arm.current_to_torque.offset
    if arm.friction is not None:
        values |= {"coulomb": arm.friction.coulomb, "viscous": arm.friction.viscous}
    return values
