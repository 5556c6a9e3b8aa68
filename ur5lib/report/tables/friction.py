"""Rows of tables about friction, currents and torque constants, and how they changed."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ur5lib.report.tables.source import Row, Source, by_joint
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import KARNOPP, PRESLIDING

AS_PRINTED = "torque_on_current"


def friction(source: Source) -> Iterator[Row]:
    """Yield torque constants, offsets and friction, beside the thesis's."""
    published = _published(source["arm"])
    for row in source["friction"].get("parameters", []):
        name, joint = row["name"], row["joint"]
        low, high = row["interval"]
        yield {
            "parameter": name,
            "thesis": published[name][joint - 1] if name in published else None,
            "low": low,
            "high": high,
            **{
                column: row[column]
                for column in ("joint", "value", "std_error", "prior_share", "determined")
            },
            **_known(source["friction"], row),
        }


def _known(friction: Mapping[str, Any], row: Mapping[str, Any]) -> Row:
    """Return the prior torque constant, and the fitted one where that contradicts it."""
    if row["name"] != "torque_constant":
        return {}
    joint, constants = row["joint"] - 1, friction["known_constants"]
    return {
        "known": constants["value"][joint],
        "known_std": constants["std_error"][joint],
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


def friction_reversal(source: Source) -> Iterator[Row]:
    """Yield the cross-validated error [A] of Dahl's and Karnopp's friction at reversals."""
    joints = source["friction"].get("fit", {}).get("joints", [])
    for number, joint in enumerate(joints, start=1):
        errors = joint["reversal_errors"]
        for distance, error in zip((*PRESLIDING, KARNOPP), errors, strict=bool(errors)):
            yield {
                "joint": number,
                "model": "karnopp" if distance == KARNOPP else "dahl",
                "distance_rad": None if distance == KARNOPP else distance,
                "rmse": error,
                "chosen": distance == joint["presliding"],
            }


def cross_validation(source: Source) -> Iterator[Row]:
    """Yield the RMSE of a fit to one recording, tested on another."""
    names, tested = source["friction"]["from"], source["friction"].get("cross_validation", [])
    for fitted_on, errors in zip(names, tested, strict=True):
        for tested_on, rmse in zip(names, errors, strict=True):
            about = {"fitted_on": fitted_on, "tested_on": tested_on}
            yield from (about | row for row in by_joint({"rmse_2hz": rmse}))


def current_rmse(source: Source) -> Iterator[Row]:
    """Yield the errors of each model's prediction of a recording's currents."""
    for model, scores in source["currents"]["scores"].items():
        columns = {name: scores[name] for name in ("rmse", "mae", "r2")}
        columns |= {"rmse_2hz": scores["rmse_lowpassed"], "coverage95": scores["coverage"]}
        about = {"model": model, "fitted": source["currents"]["fitted"]}
        yield from (about | row for row in by_joint(columns))


def payload(source: Source) -> Iterator[Row]:
    """Yield the undeclared payload on the flange; none at rest."""
    if load := source["currents"].get("load"):
        low, high = load["interval"]
        yield (
            {
                f"{name}_{axis}": value
                for name in ("center_of_mass", "center_of_mass_std")
                for axis, value in zip("xyz", load[name], strict=True)
            }
            | {name: load[name] for name in ("mass", "std_error", "configured", "taken")}
            | {"low": low, "high": high}
        )


def torque_constants(source: Source) -> Iterator[Row]:
    """Yield torque constants and offsets of moving joints by the thesis's regression and by its
    reverse, and the printed ones; none without published constants.
    """
    compared = source.printed.current_torque is not None
    constants, printed = source["constants"], source.published("current_torque")
    for regression, line in constants.get("lines", {}).items() if compared else ():
        columns = {name: line[name] for name in ("torque_constant", "offset")}
        columns |= {f"{name}_std_error": line[f"{name}_std"] for name in columns}
        columns |= {
            name: constants[name]
            for name in ("mean_torque", "correlation", "correlation_without_friction")
        }
        if printed and regression == AS_PRINTED:
            columns |= {"printed_torque_constant": printed["k"], "printed_offset": printed["b"]}
        for row in by_joint(columns):
            if row["torque_constant"] is not None:
                yield {"regression": regression} | row


def health(source: Source) -> Iterator[Row]:
    """Yield each joint's condition on each date; `lost_frames` is of all joints."""
    yield from source["health"]["dates"]


def health_changes(source: Source) -> Iterator[Row]:
    """Yield drifts and jumps of each joint's condition between dates."""
    for change in source["health"]["changes"]:
        yield change | {"by_temperature": change["explained"]}
