"""Samples of a recording's IMU and joints for the calibration."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ur5lib.records.clocks import ClockRelation
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.robots.end_effector import point_velocity
from ur5lib.signals.clock import HOST_METHOD, MOTION_METHOD, SHARED_METHOD
from ur5lib.signals.imu_calibration import ImuRecord
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, inner_lowpass
from ur5lib.timeseries.sampling import differentiate
from ur5lib.timeseries.segments import by_segment


def has_valid_imu(clocks: Mapping[str, ClockRelation]) -> bool:
    """Return whether a recording has an IMU with a clock that is better than its start stamp's."""
    return "imu" in clocks and clocks["imu"].method in (MOTION_METHOD, HOST_METHOD, SHARED_METHOD)


def imu_samples(
    robot: Robot, signals: Signals, kinematics: Kinematics, design: Butterworth
) -> ImuRecord:
    """Return the joints' predictions and the IMU's readings, both low-passed without delay.

    robot: under the recording's gravity. Rows where either side is missing, and ends where the
    filter extrapolates, are left out.
    """
    rotation, segment, step = kinematics.rotation, signals.segment, signals.period
    point, gravity = np.array(robot.mounting.imu), np.array(robot.gravity)
    # not the controller's velocities, which lag the positions, R_6 and J_g by some ms
    qd = by_segment(differentiate, signals.actual_q, segment, step)
    velocity = point_velocity(rotation, kinematics.jacobian, qd, point)
    # velocities of frame 6's unit points about its origin, ω × R_6 e, side by side (N, 9)
    turned = np.cross(velocity[:, None, 3:], rotation.swapaxes(1, 2)).reshape(-1, 9)
    moved = np.concatenate([velocity[:, :3], turned], axis=1)
    change_of = by_segment(differentiate, moved, segment, step)
    acceleration, turning = change_of[:, :3], change_of[:, 3:].reshape(-1, 3, 3)
    # f = R_6ᵀ (a - g0) and ω = R_6ᵀ J_w q̇ in frame 6, both readings, and ∂f/∂r
    sides = [
        np.einsum("nji,nj->ni", rotation, acceleration - gravity),
        np.einsum("nji,nj->ni", rotation, velocity[:, 3:]),
        signals.imu,
        np.einsum("nji,nkj->nik", rotation, turning).reshape(-1, 9),
    ]
    smooth = by_segment(inner_lowpass, np.concatenate(sides, axis=1), segment, 1 / step, *design)
    kept = np.isfinite(smooth).all(axis=1)
    force, rate, accelerometer, gyroscope, *by_place = np.split(smooth[kept], 7, axis=1)
    return ImuRecord(
        time=signals.time[kept],
        rotation=rotation[kept],
        specific_force=force,
        angular_rate=rate,
        by_place=np.concatenate(by_place, axis=1).reshape(-1, 3, 3),
        accelerometer=accelerometer,
        gyroscope=gyroscope,
        place=point,
        gravity=gravity,
    )


def derivative(signals: Signals, values: Array) -> Array:
    """Return the time derivative of values (N, M) within the segments."""
    return by_segment(differentiate, values, signals.segment, signals.period)


def lowpassed(signals: Signals, function: Any, design: Butterworth, values: Array) -> Array:
    """Return values (N, M), low-passed within the segments by `function` with the order and cut-off
    of `design`.
    """
    return by_segment(function, values, signals.segment, 1 / signals.period, *design)
