"""An arm as other programs read it, as described or as a study identified it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from ur5lib.errors import InputError
from ur5lib.identification.currents import CurrentFit, torque_constants
from ur5lib.identification.friction import MOVING
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.torques import Torques
from ur5lib.robots.description import Payload, Robot, load_robot, robot_names, robot_path
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.isaac import isaac
from ur5lib.robots.joint_friction import JointFriction
from ur5lib.robots.mjcf import mjcf
from ur5lib.robots.sdf import sdf
from ur5lib.robots.urdf import urdf
from ur5lib.study.check import read_study
from ur5lib.study.known_parameters import described_arm, identified_parameters, provenance
from ur5lib.study.model import Recording
from ur5lib.tables import json_text, read_json
from ur5lib.timeseries.arrays import Array

WRITERS: dict[str, Callable[[Robot, str, JointFriction | None], str]] = {
    "urdf": lambda arm, model, friction: urdf(arm, rigid_bodies(arm, model), friction),
    "mjcf": mjcf,
    "sdf": sdf,
    "isaac": isaac,
}
FORMATS = (*WRITERS, "json")
FEWEST = 100  # samples in motion that tell a joint's friction


def exported(robot: str, model: str | None, to: str, results: Path | None, as_in: str) -> str:
    """Return an arm with one of its link models, by default the chosen or the identified one.

    results: of a study that identified it; as_in: a recording of the study, whose payload the arm
    carries and as in which it is mounted, empty for none. Raises InputError for what is not there.
    """
    if to not in FORMATS:
        raise InputError(f"unknown format {to!r}; available: {', '.join(FORMATS)}")
    arm = described(robot) if results is None else identified(robot, results)
    if as_in and results is None:
        raise InputError("--as-in names a recording of a study; name its folder by --results")
    if as_in and results is not None:
        recording = recorded(results, as_in)
        arm = arm.carrying(payload_of(results, as_in)).mounted(recording.known_gravity())
    model = model or (arm.chosen_model if results is None else arm.fullest_model())
    if model not in arm.models:
        raise InputError(f"{robot} has no link model {model!r}; available: {', '.join(arm.models)}")
    friction = None if results is None else simulator_friction(robot, model, results)
    if to in WRITERS:
        return WRITERS[to](arm, model, friction)
    known = described_arm(arm, model)
    if results is not None:
        known |= identified_parameters(results / "parameters" / robot, friction)
        fitted = known["fitted_on"].values()
        known["files"] = provenance(results, sorted({name for names in fitted for name in names}))
    return json_text(known)


def described(robot: str) -> Robot:
    """Return an arm as described. Raises InputError where it is not."""
    if robot not in robot_names():
        raise InputError(f"no description of `{robot}`; docs/robots.md shows how to add one")
    return load_robot(robot_path(robot))


def identified(robot: str, results: Path) -> Robot:
    """Return an arm with the models that a study identified. Raises InputError without them."""
    return load_robot(_there(results / "parameters" / robot / "arm.yaml"))


def recorded(results: Path, name: str) -> Recording:
    """Return a recording of a study that was run. Raises InputError where there is none."""
    recordings = read_study(_there(results / "configuration.yaml")).recordings
    found = [recording for recording in recordings if recording.name == name]
    if not found:
        known = ", ".join(recording.name for recording in recordings)
        raise InputError(f"no recording {name!r} in {results}; there are {known}")
    return found[0]


def payload_of(results: Path, recording: str) -> Payload | None:
    """Return what an arm carried in a recording."""
    load = read_json(_there(results / "recordings" / recording / "torques.json"))
    return Payload(**load["payload"]) if load["payload"] else None


def simulator_friction(robot: str, model: str, results: Path) -> JointFriction | None:
    """Return the Coulomb and viscous friction nearest to the identified friction, which has more
    terms, on the recordings that it was fitted to. None where none was fitted.
    """
    friction = read_json(_there(results / "parameters" / robot / "friction.json"))
    if not friction["from"]:
        return None
    fit = CurrentFit.from_plain(friction["fit"])
    motions, torques = [], []
    for name in friction["from"]:
        folder = results / "recordings" / name
        motions.append(Motion.read(folder / "motion.parquet").qd)
        torques.append(friction_torque(fit, folder, model))
    qd, torque = np.concatenate(motions), np.concatenate(torques)
    found = [_coulomb_and_viscous(qd[:, j], torque[:, j]) for j in range(6)]
    return JointFriction(*np.array(found).T)


def friction_torque(fit: CurrentFit, folder: Path, model: str) -> Array:
    """Return the predicted torque of friction (N, 6) [Nm] in a recording, k i + b - τ."""
    current = Currents.read(folder / "currents.parquet").predicted_current
    torques = Torques.read(folder / "torques.parquet")
    assert current is not None
    return motor_torque(fit, current) - torques.measured[model] - torques.payload_torque


def motor_torque(fit: CurrentFit, current: Array) -> Array:
    """Return the torque k i + b (N, 6) [Nm] of currents (N, 6) [A]."""
    constant = torque_constants(fit)
    offset = -constant * [joint.estimate.coefficients[1] for joint in fit.joints]
    return np.asarray(current * constant + offset)


def _coulomb_and_viscous(qd: Array, torque: Array) -> Array:
    """Return Coulomb and viscous friction (2,) by least squares, in motion, not negative.

    NaN for a joint with too few samples in motion.
    """
    from scipy.optimize import nnls

    moving = (np.abs(qd) > MOVING) & np.isfinite(torque)
    if np.count_nonzero(moving) < FEWEST:
        return np.full(2, np.nan)
    columns = np.column_stack([np.sign(qd), qd])[moving]
    return np.asarray(nnls(columns, torque[moving])[0])


def _there(path: Path) -> Path:
    if not path.is_file():
        raise InputError(f"{path} does not exist; check the folder, the names, and run snakemake")
    return path
