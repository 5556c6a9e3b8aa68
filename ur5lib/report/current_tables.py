"""Tables of results on currents: friction, prediction, payload, cross-validation."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ur5lib.robots.description import Robot

Row = dict[str, object]


def friction_rows(robot: str, arm: Robot, friction: Mapping[str, Any]) -> Iterator[Row]:
    """Torque constants, offsets and friction beside the thesis's, from friction.json."""
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
            "thesis": published[name][joint - 1] if name in published else None,
            "low": low,
            "high": high,
            "determined": "yes" if row["determined"] else "no",
            "robot": robot,
        }


def _published(arm: Robot) -> dict[str, Sequence[float]]:
    values: dict[str, Sequence[float]] = {}
    if arm.current_to_torque is not None:
        values["torque_constant"] = arm.current_to_torque.torque_constant
        values["offset"] = arm.current_to_torque.offset
    if arm.friction is not None:
        values |= {"coulomb": arm.friction.coulomb, "viscous": arm.friction.viscous}
    return values


def current_rows(recording: str, currents: Mapping[str, Any]) -> Iterator[Row]:
    """How well each model predicts a recording's currents, from currents.json."""
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


def remark_rows(robot: str, steps: Mapping[str, Mapping[str, Any]]) -> Iterator[Row]:
    """What fits say of themselves, by joint, and why one made nothing; steps: summaries by name."""
    for step, summary in steps.items():
        for remark in [*summary.get("remarks", []), *filter(None, [summary.get("refused")])]:
            yield {"robot": robot, "step": step, "remark": remark}
        for joint, fit in enumerate(summary.get("fit", {}).get("joints", []), start=1):
            for remark in fit["remarks"]:
                yield {"robot": robot, "step": step, "joint": joint, "remark": remark}


def cross_validation_rows(robot: str, friction: Mapping[str, Any]) -> Iterator[Row]:
    """RMSE of a fit on one recording alone, tested on each, from friction.json."""
    names = friction["from"]
    for fitted, tested_rows in zip(names, friction.get("cross_validation", []), strict=True):
        for tested, rmse in zip(names, tested_rows, strict=True):
            for joint in range(6):
                yield {
                    "robot": robot,
                    "fitted_on": fitted,
                    "tested_on": tested,
                    "joint": joint + 1,
                    "rmse_2hz": rmse[joint],
                }


def payload_rows(recording: str, currents: Mapping[str, Any]) -> Iterator[Row]:
    """What the flange carries beyond the known payload, from currents.json; none at rest."""
    if load := currents.get("load"):
        low, high = load["interval"]
        center = zip("xyz", load["center_of_mass"], strict=True)
        yield {
            "recording": recording,
            "mass": load["mass"],
            "std_error": load["std_error"],
            "low": low,
            "high": high,
            **{f"center_of_mass_{axis}": value for axis, value in center},
            "configured": load["configured"],
            "taken": "yes" if load["taken"] else "no",
        }


def ablation_rows(recording: str, ablation: Mapping[str, Any]) -> Iterator[Row]:
    """The error in contact with each part of the estimate left out, from ablation.json."""
    for variant, figures in ablation.items():
        for i, component in enumerate(("Fx", "Fy", "Fz")):
            yield {
                "recording": recording,
                "variant": variant,
                "component": component,
                **{name: values[i] for name, values in figures.items()},
            }


def detection_rows(recording: str, detection: Mapping[str, Any]) -> Iterator[Row]:
    """Contacts by each estimate and by the force they reach, from detection.json.

    Without a force sensor, one row an estimate and no force.
    """
    for estimate, found in detection.items():
        smallest = found.get("smallest_force_95", {})
        pushes = {
            f"smallest_force_95_{axis}": figures["force"] for axis, figures in smallest.items()
        }
        for i, part in enumerate(found.get("classes", [{}])):
            yield {
                "recording": recording,
                "estimate": estimate,
                "force_class_n": part.get("force"),
                **{name: part.get(name) for name in ("contacts", "found", "recall")},
                "false_alarms_per_min": found.get("false_per_min"),
                "extra_alarms": found.get("extra"),
                **{name: found.get(name) for name in ("time_in_alarm", "free_time_in_alarm")},
                "median_delay_s": part.get("median_delay"),
                "causal_delay_s": part.get("causal_delay"),
                **(pushes if i == 0 else {}),
                "precision": found.get("precision"),
                "alarms": len(found["raised"]),
                "alarms_per_min": found["alarms_per_min"],
                "roc_area": found.get("roc_area"),
            }


def contact_rows(recording: str, detection: Mapping[str, Any]) -> Iterator[Row]:
    """Each alarm: when, the largest force in it, and the mass of a load, from detection.json."""
    for estimate, found in detection.items():
        for alarm in found["raised"]:
            values = zip("xyz", alarm["force"], alarm["force_std"], strict=True)
            yield {
                "recording": recording,
                "estimate": estimate,
                "kind": alarm.get("kind", "contact"),
                "load_mass": alarm.get("load_mass"),
                "load_mass_std": alarm.get("load_mass_std"),
                "start_s": alarm["start"],
                "end_s": alarm["end"],
                "peak_s": alarm["peak"],
                **{
                    name: number
                    for axis, force, std in values
                    for name, number in ((f"F{axis}", force), (f"F{axis}_std", std))
                },
            }
