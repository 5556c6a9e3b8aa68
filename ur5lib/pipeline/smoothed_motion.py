"""Joint motion by the Kalman smoother, as motion.parquet and fused_motion.parquet."""

from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np

from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.motion import FusedMotion, Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.signals.imu_model import LinearImu, linearise_imu
from ur5lib.signals.smoothing import SmoothedMotion
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.segments import by_segment

STATES = {"q": slice(0, 6), "qd": slice(6, 12), "qdd": slice(12, 18)}
BIASES = {"accelerometer_bias": slice(18, 21), "gyroscope_bias": slice(21, 24)}


def measured(signals: Signals) -> tuple[Array, Array]:
    """Return positions and velocities (N, 6), NaN where interpolated.

    Without recorded velocities, differences of the positions.
    """
    q, qd = signals.actual_q.copy(), signals.actual_qd
    if qd is None:
        qd = by_segment(partial(differentiate, period=signals.period), q, signals.segment)
    qd = qd.copy()
    q[signals.interpolated] = qd[signals.interpolated] = np.nan
    return q, qd


def imu_model(
    robot: Robot, kinematics: Kinematics, calibration: ImuCalibration, qd: Array
) -> LinearImu:
    """Return the IMU's equation about a motion, as other recordings calibrated it.

    robot: under the recording's gravity; qd: (N, 6) [rad/s].
    """
    gravity = np.array(robot.gravity)
    return linearise_imu(
        kinematics.rotation,
        kinematics.jacobian,
        qd,
        np.array(robot.mounting.imu),
        calibration.axes(),
        calibration.up(gravity),
    )


def motion_record(signals: Signals, motion: SmoothedMotion) -> Motion:
    """Return positions, velocities and accelerations with their standard deviations."""
    return Motion(time=signals.time, segment=signals.segment, **_parts(motion, STATES))


def fused_record(signals: Signals, motion: SmoothedMotion) -> FusedMotion:
    """Return the same, and the IMU's biases."""
    parts = _parts(motion, STATES | BIASES)
    return FusedMotion(time=signals.time, segment=signals.segment, **parts)


def no_fused_motion() -> FusedMotion:
    """Return the record of a recording without a valid IMU: it has no samples."""
    states = {name: np.zeros((0, 6)) for name in STATES}
    biases = {name: np.zeros((0, 3)) for name in BIASES}
    parts = states | biases
    parts |= {f"{name}_std": values for name, values in parts.items()}
    return FusedMotion(time=np.zeros(0), segment=np.zeros(0, np.int64), **parts)


def _parts(motion: SmoothedMotion, parts: dict[str, slice]) -> dict[str, Array]:
    values = {name: motion.state[:, part] for name, part in parts.items()}
    return values | {f"{name}_std": motion.std[:, part] for name, part in parts.items()}


def motion_account(motion: SmoothedMotion) -> dict[str, Any]:
    """Return what noise was found, and whether the innovations agree with it."""
    noise = asdict(motion.encoders)
    noise["jerk"] = np.quantile(motion.encoders.jerk, [0.1, 0.5, 0.9], axis=0)
    if motion.imu is not None:
        noise["imu"] = np.nanmedian(motion.imu, axis=0)
    return {"noise": noise, "innovations": asdict(motion.test)}
