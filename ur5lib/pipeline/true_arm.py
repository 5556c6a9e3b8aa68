"""The simulated truth of an arm, with which its estimates are compared."""

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TypeVar

import numpy as np

from ur5lib.dynamics.flange import point_acceleration
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.pipeline.records.truth import TrueParameters, Truth
from ur5lib.robots.description import Robot
from ur5lib.tables import json_text
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.lowpass import Butterworth, inner_lowpass
from ur5lib.timeseries.segments import by_segment, period

Truths = Mapping[str, TrueParameters]  # by recording
Part = TypeVar("Part")


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
    point = np.array(robot.mounting.imu)
    exact = point_acceleration(robot, true.q, true.qd, true.qdd, point)
    rate = 1 / period(true.time)
    return by_segment(lambda x: inner_lowpass(x, rate, *design), exact, segment)


def rigid_torques(robot: Robot, truth: TrueParameters, true: Truth) -> dict[str, Array]:
    """Return models' torques (N, n) [Nm] at the true motion, with the arm's payload."""
    carrying = true_robot(robot, truth)
    return {
        name: LinkModel(carrying, name).inverse_dynamics(true.q, true.qd, true.qdd)
        for name in (robot.chosen_model, "identified")
        if name in robot.models
    }
