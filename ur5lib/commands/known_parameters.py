"""All parameters of an arm that a study identified, with their errors, as plain data."""

from collections.abc import Iterator, Mapping
from dataclasses import asdict
from importlib import metadata
from typing import Any

from ur5lib.finished import FinishedStudy
from ur5lib.report.finding_sentences import in_words
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.joint_friction import JointFriction
from ur5lib.timeseries.metrics import NORMAL95

UNITS = "SI: m, kg, s, rad, N, Nm, A; joints 1 to 6; low and high: the 95 % interval"
FITTED = ("terms", "presliding", "held", "band_moving", "band_rest", "contradicted")


def described_arm(arm: Robot, model: str) -> dict[str, Any]:
    """Return an arm's kinematics and limits, and one of its link models as rigid bodies.

    Centres of mass are in the frames of the links, inertia tensors about them.
    """
    shown = {"name", "gravity", "denavit_hartenberg", "calibration", "joints", "motors"}
    return {
        "units": UNITS,
        "exported_by": f"ur5lib {metadata.version('ur5lib')}",
        "arm": arm.model_dump(mode="json", include=shown, exclude_none=True),
        "link_model": {"name": model, **asdict(rigid_bodies(arm, model))},
    }


def identified_parameters(
    study: FinishedStudy, robot: str, friction: JointFriction | None
) -> dict[str, Any]:
    """Return the identified parameters of an arm with standard errors and intervals.

    friction: in the form of simulators. Lists are empty where nothing could be fitted. Raises
    InputError where a summary is missing.
    """
    rotors, model, currents = (
        study.fitted(robot, name) for name in ("rotor_inertia", "identification", "friction")
    )
    fit = currents.get("fit", {"joints": []})
    return {
        "base_parameters": [_base_parameter(row) for row in model.get("parameters", [])],
        "rotor_inertia": [*_rotor_rows(rotors)],
        "torque_noise": model.get("noise"),
        "currents": [_current_parameter(row) for row in currents.get("parameters", [])],
        "known_constants": currents.get("known_constants"),
        "current_model": [_current_model(joint) for joint in fit["joints"]],
        "simulator_friction": None if friction is None else asdict(friction),
        "fitted_on": {"link_model": model["from"], "currents": currents["from"]},
    }


def _current_model(joint: Mapping[str, Any]) -> dict[str, Any]:
    """Return the fit of a joint, with its remarks in words."""
    return {name: joint[name] for name in FITTED} | {"remarks": [*map(in_words, joint["remarks"])]}


def provenance(study: FinishedStudy, recordings: list[str]) -> dict[str, Any]:
    """Return the files that a study read of some recordings, with their SHA-256."""
    return {name: study.summary(name, "quality").get("read", {}) for name in recordings}


def _base_parameter(row: Mapping[str, Any]) -> dict[str, Any]:
    """Return a base parameter with its interval, without its weights."""
    shown = {key: row[key] for key in ("parameter", "value", "std_error", "determined")}
    return shown | _interval(row["value"], row["std_error"])


def _current_parameter(row: Mapping[str, Any]) -> dict[str, Any]:
    shown = {key: value for key, value in row.items() if key != "interval"}
    return shown | dict(zip(("low", "high"), row["interval"], strict=True))


def _rotor_rows(rotors: Mapping[str, Any]) -> Iterator[dict[str, Any]]:
    if rotors["from"]:
        pairs = zip(rotors["value"]["inertia"], rotors["std_error"]["inertia"], strict=True)
        for joint, (value, error) in enumerate(pairs, 1):
            yield {"joint": joint, "value": value, "std_error": error, **_interval(value, error)}


def _interval(value: float, error: float) -> dict[str, float]:
    return {"low": value - NORMAL95 * error, "high": value + NORMAL95 * error}
