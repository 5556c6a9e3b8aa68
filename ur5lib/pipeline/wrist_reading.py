"""The reading of the arm's own force sensor, with its tool's inertia."""

import numpy as np

from ur5lib.force.sensor import fit_offset
from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.sensor_reference import SensorReading, in_frame_6
from ur5lib.robots.description import Robot
from ur5lib.signals.end_effector import point_acceleration
from ur5lib.timeseries.arrays import Array

FURTHEST = 0.3  # m, of a tool's centre of mass


def wrist_reading(
    robot: Robot, signals: Signals, kinematics: Kinematics, motion: Motion
) -> SensorReading:
    """Return the reading of the arm's own sensor; a first fit places its tool.

    robot: under the recording's gravity.
    """
    assert signals.force_sensor is not None
    values, center = in_frame_6(signals.force_sensor, robot), np.zeros(3)
    for _ in range(2):
        pull, _ = pull_and_spin(robot, kinematics, motion, center)
        offset = fit_offset(values, pull, signals.period)
        center = within_reach(offset.center())
    return SensorReading(values, None, pull, offset)


def within_reach(center: Array) -> Array:
    """Return a tool's centre of mass (3,) [m], bounded; the flange where it is unknown."""
    return np.nan_to_num(center).clip(-FURTHEST, FURTHEST)


def pull_and_spin(
    robot: Robot, kinematics: Kinematics, motion: Motion, point: Array
) -> tuple[Array, Array]:
    """Return R_6ᵀ (g - a) [m/s²], what pulls on each kilogram at a point (3,) [m] of frame 6, and
    its angular acceleration R_6ᵀ α [rad/s²], (N, 3) each.
    """
    rotation = kinematics.rotation
    moved = point_acceleration(rotation, kinematics.jacobian, motion.qd, motion.qdd, point)
    felt = np.array(robot.gravity) - moved[:, :3], moved[:, 3:]
    pull, spin = (np.einsum("nji,nj->ni", rotation, part) for part in felt)
    return pull, spin
