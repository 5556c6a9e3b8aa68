"""All rows of the table of estimates beside the truth."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from functools import partial
from operator import attrgetter
from typing import TypeVar

import numpy as np

from ur5lib.dynamics.flange import point_acceleration
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.pipeline.records.accelerations import Accelerations
from ur5lib.pipeline.records.forces import Forces
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.models import Identification, Rotors
from ur5lib.pipeline.records.motion import FusedMotion, Motion
from ur5lib.pipeline.records.truth import TrueParameters, Truth
from ur5lib.report import truth_table
from ur5lib.report.truth_table import Row, joint_numbers
from ur5lib.robots.description import Robot, load_robot
from ur5lib.signals.clock import SettledClock
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.tables import json_text, read_record
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.lowpass import Butterworth, inner_lowpass
from ur5lib.timeseries.segments import by_segment

Files = Mapping[str, str]  # paths of one arm's or one recording's results
Truths = Mapping[str, TrueParameters]  # by recording
Part = TypeVar("Part")


def arm_rows(files: Files, truths: Truths) -> Iterator[Row]:
    """Yield rows about parameters fitted to several recordings with a common truth.

    files: paths of the arm's results: described, rotors, identification, calibration, friction.
    """
    robot = load_robot(files["described"])
    rotors = read_record(Rotors, files["rotors"])
    if (inertias := shared(truths, rotors.from_, partial(true_rotors, robot))) is not None:
        yield from truth_table.rotor_rows(rotors, inertias)
    identified = read_record(Identification, files["identification"])
    true = shared(truths, identified.from_, partial(true_parameters, robot))
    if true is not None:
        yield from truth_table.parameter_rows(identified, true)
    imu = read_record(dict[str, ImuCalibration], files["calibration"]).get("all")
    if imu and (plan := shared(truths, imu.from_, attrgetter("plan.imu"))):
        yield from truth_table.imu_rows(imu, plan)
    friction = read_record(Friction, files["friction"])
    if truth := shared(truths, friction.from_, attrgetter("drive", "friction")):
        yield from truth_table.friction_rows(friction, *truth)


def recording_rows(files: Files, truth: TrueParameters, design: Butterworth) -> list[Row]:
    """Return rows about one recording; design: low-pass of the accelerations.

    files: paths of its clocks, motion, fused, accelerations, forces and truth, and of the described
    and the fitted arm.
    """
    motion, fused = Motion.read(files["motion"]), FusedMotion.read(files["fused"])
    true = Truth.read(files["truth"]).at(motion.time)
    robot = load_robot(files["described"])
    acceleration = true_acceleration(robot, true, motion.segment, design)
    motions = {"encoders": motion, "encoders+imu": fused}
    return [
        *truth_table.clock_rows(read_record(dict[str, SettledClock], files["clocks"]), truth),
        *truth_table.joint_acceleration_rows(motions, true),
        *truth_table.end_effector_rows(Accelerations.read(files["accelerations"]), acceleration),
        *torque_rows(load_robot(files["fitted"]), truth, true),
        *truth_table.wrench_rows(Forces.read(files["forces"]), true),
    ]


def torque_rows(robot: Robot, truth: TrueParameters, true: Truth) -> Iterator[Row]:
    """Yield the RMSE of models' torques at the true motion, against those of the simulated arm."""
    rigid = true.motor_torque - true.friction_torque + true.contact_torque
    joints = joint_numbers(rigid)
    for model, torque in rigid_torques(robot, truth, true).items():
        yield from truth_table.errors("torque", joints, "Nm", rigid, torque, f"Model {model}")


def shared(
    truths: Truths, recordings: Collection[str], part: Callable[[TrueParameters], Part]
) -> Part | None:
    """Return a part of the truth that recordings have in common, None where they have not."""
    if not recordings or not set(recordings) <= set(truths):
        return None
    parts = [part(truths[name]) for name in recordings]
    return parts[0] if all(json_text(one) == json_text(parts[0]) for one in parts) else None


def true_robot(robot: Robot, truth: TrueParameters) -> Robot:
    """Return the arm as simulated: with its gravity and its payload."""
    for payload in (truth.plan.payload, truth.plan.undeclared_payload):
        robot = robot.carrying(payload)
    return robot.mounted(truth.gravity)


def true_rotors(robot: Robot, truth: TrueParameters) -> Sequence[float]:
    """Return the simulated rotor inertias (n,) [kg m²]."""
    return robot.models[truth.model].rotor_inertias or (0.0,) * len(robot.joints)


def true_parameters(robot: Robot, truth: TrueParameters) -> Array:
    """Return π (11 n,) of the simulated model, without a payload: the controller's is known."""
    return LinkModel(robot, truth.model).parameters


def true_acceleration(robot: Robot, true: Truth, segment: Labels, design: Butterworth) -> Array:
    """Return the end effector's at the IMU's place (N, 6), low-passed as its estimates are."""
    exact = point_acceleration(robot, true.q, true.qd, true.qdd, np.array(robot.mounting.imu))
    return by_segment(inner_lowpass, exact, segment, 1 / true.period, *design)


def rigid_torques(robot: Robot, truth: TrueParameters, true: Truth) -> dict[str, Array]:
    """Return models' torques (N, n) [Nm] at the true motion, with the arm's payload."""
    carrying = true_robot(robot, truth)
    return {
        name: LinkModel(carrying, name).inverse_dynamics(true.q, true.qd, true.qdd)
        for name in (robot.chosen_model, "identified")
        if name in robot.models
    }
