"""Estimates from simulated recordings against the truth, which no other step reads."""

from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from operator import attrgetter
from pathlib import Path
from typing import TypeVar

import numpy as np
import pandas as pd
from scipy.stats import norm

from ur5lib.dynamics.flange import point_acceleration
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.records.accelerations import COMPONENTS, Accelerations
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction
from ur5lib.records.models import Identification, Rotors
from ur5lib.records.motion import Alignment, FusedMotion, Motion
from ur5lib.records.opened import Opened
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.stand.truth import TrueParameters, Truth
from ur5lib.tables import json_text, read_record
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, inner_lowpass
from ur5lib.timeseries.metrics import coverage
from ur5lib.timeseries.segments import by_segment
from ur5lib.topics.truth.beside import (
    COLUMNS,
    Row,
    clock_rows,
    errors,
    friction_rows,
    imu_rows,
    joint_numbers,
    rotor_rows,
    rows,
    values,
    wrench_rows,
)

Truths = Mapping[str, TrueParameters]  # by recording
TruthPart = TypeVar("TruthPart")
SHARE_WITHIN_2_STD = float(norm.cdf(2) - norm.cdf(-2))


class Fits(Opened):
    """What is read of an arm."""

    described: Robot
    identified: Robot
    rotors: Rotors
    identification: Identification
    friction: Friction


class Inputs(Opened):
    """What is read of a recording."""

    alignment: Alignment
    motion: Motion
    fused: FusedMotion
    accelerations: Accelerations
    forces: Forces


def compare_with_truth(
    truth: list[Path],
    truth_summary: list[Path],
    simulated: list[str],
    recordings: Mapping[str, Inputs],
    arms: Mapping[str, Fits],
    calibration: Mapping[str, dict[str, ImuCalibration]],
    lowpass: Butterworth,
) -> pd.DataFrame:
    """Return the rows of truth.csv, estimates compared with the truth.

    truth, truth_summary: files of `Truth` and `TrueParameters` of the simulated recordings, of
    which recordings has those that can be read; calibration: of each arm's IMU; lowpass: of the
    accelerations.
    """
    known = [read_record(TrueParameters, path) for path in truth_summary]
    truths = dict(zip(simulated, known, strict=True))
    paths = dict(zip(simulated, truth, strict=True))
    rows = list[Row]()
    for robot, arm in arms.items():
        of_arm = {name: one for name, one in truths.items() if one.robot == robot}
        rows += [{"robot": robot} | row for row in arm_rows(arm, calibration[robot], of_arm)]
    for name, recording in recordings.items():
        parameters, samples = truths[name], Truth.read(paths[name])
        about = {"recording": name, "robot": parameters.robot}
        found = recording_rows(recording, arms[parameters.robot], parameters, samples, lowpass)
        rows += [about | row for row in found]
    return pd.DataFrame(rows, columns=COLUMNS)


def arm_rows(arm: Fits, calibration: Mapping[str, ImuCalibration], truths: Truths) -> Iterator[Row]:
    """Yield the rows that compare the parameters fitted to several recordings with their common
    truth.
    """
    robot = arm.described

    def true_rotors(truth: TrueParameters) -> Sequence[float]:
        return robot.models[truth.model].rotor_inertias or (0.0,) * len(robot.joints)

    def true_parameters(truth: TrueParameters) -> Array:
        return LinkModel(robot, truth.model).parameters  # without a payload: it is given

    rotors, identified, friction = arm.rotors, arm.identification, arm.friction
    if (inertias := shared(truths, rotors.from_, true_rotors)) is not None:
        yield from rotor_rows(rotors, inertias)
    if (true := shared(truths, identified.from_, true_parameters)) is not None:
        for row in identified.parameters:
            if row.determined:
                numbers = [float(row.weights @ true)], [row.value], [row.std_error]
                yield from values("base_parameter", [row.parameter], "", *numbers)
    imu = calibration.get("all")
    if imu and (plan := shared(truths, imu.from_, attrgetter("plan.imu"))):
        yield from imu_rows(imu, plan)
    if truth := shared(truths, friction.from_, attrgetter("drive", "friction")):
        yield from friction_rows(friction, *truth)


def recording_rows(
    recording: Inputs,
    arm: Fits,
    truth: TrueParameters,
    samples: Truth,
    lowpass: Butterworth,
) -> Iterator[Row]:
    """Yield the rows that compare the estimates from one recording with its truth; lowpass: of the
    accelerations.
    """
    motion, fused, robot = recording.motion, recording.fused, arm.described
    true = samples.at(motion.time)
    exact = point_acceleration(robot, true.q, true.qd, true.qdd, np.array(robot.mounting.imu))
    acceleration = by_segment(inner_lowpass, exact, motion.segment, 1 / true.period, *lowpass)
    yield from clock_rows(recording.alignment.clocks, truth)
    yield from joint_acceleration_rows({"encoders": motion, "encoders+imu": fused}, true)
    accelerations = recording.accelerations
    felt = {} if accelerations.felt is None else {"imu": accelerations.felt}
    about = "end_effector_acceleration", [*COMPONENTS], [*COMPONENTS.values()]
    for method, estimate in (felt | accelerations.acceleration).items():
        yield from errors(*about, acceleration, estimate, method)
    yield from torque_rows(arm.identified, truth, true)
    yield from wrench_rows(recording.forces, true)


def torque_rows(robot: Robot, truth: TrueParameters, true: Truth) -> Iterator[Row]:
    """Yield the RMSE of link models' torques against the simulated arm's, all at the true motion
    with the simulated gravity and payload.
    """
    for payload in (truth.plan.payload, truth.plan.undeclared_payload):
        robot = robot.carrying(payload)
    rigid = true.motor_torque - true.friction_torque + true.contact_torque
    for name in (robot.chosen_model, "identified"):
        if name in robot.models:
            model = LinkModel(robot.mounted(truth.gravity), name)
            torque = model.inverse_dynamics(true.q, true.qd, true.qdd)
            yield from errors("torque", joint_numbers(rigid), "Nm", rigid, torque, f"Model {name}")


def shared(
    truths: Truths, recordings: Collection[str], part: Callable[[TrueParameters], TruthPart]
) -> TruthPart | None:
    """Return a part of the truth if it is equal in all recordings, else None."""
    if not recordings or not set(recordings) <= set(truths):
        return None
    parts = [part(truths[name]) for name in recordings]
    return parts[0] if all(json_text(other) == json_text(parts[0]) for other in parts) else None


def joint_acceleration_rows(motions: Mapping[str, Motion], truth: Truth) -> Iterator[Row]:
    """Yield the RMSE of q̈ by method, and the coverage of two standard deviations."""
    for method, motion in motions.items():
        if len(motion.time):
            estimate, true = motion.qdd, truth.qdd
            joints, quantity = joint_numbers(true), "joint_acceleration"
            inside = coverage(estimate, motion.qdd_std, true, SHARE_WITHIN_2_STD)
            yield from errors(quantity, joints, "rad/s2", true, estimate, method)
            quantity += "_inside_2_std"
            yield from rows(quantity, joints, "1", SHARE_WITHIN_2_STD, inside, method=method)
