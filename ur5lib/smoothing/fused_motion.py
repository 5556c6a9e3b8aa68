"""Joint motion from encoders and IMU, as fused_motion.parquet."""

import numpy as np

from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import FusedMotion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import ImuCalibration
from ur5lib.smoothing.encoders import SmoothedMotion
from ur5lib.smoothing.imu_fusion import LinearImu, Model, linearise_imu
from ur5lib.smoothing.smoothed_motion import STATES, state_parts
from ur5lib.timeseries.arrays import Array

BIASES = ("accelerometer_bias", "gyroscope_bias")


def imu_model(
    robot: Robot, kinematics: Kinematics, calibration: ImuCalibration, qd: Array
) -> Model:
    """Return the IMU's equation linearised about a motion; calibration: by other recordings.

    robot: under the recording's gravity; qd: (N, 6) [rad/s].
    """
    point, axes = np.array(robot.mounting.imu) + calibration.shift(), calibration.axes()
    up = calibration.up(np.array(robot.gravity))

    def at(rows: slice) -> LinearImu:
        return linearise_imu(
            kinematics.rotation[rows], kinematics.jacobian[rows], qd[rows], point, axes, up
        )

    return at


def fused_record(signals: Signals, motion: SmoothedMotion) -> FusedMotion:
    """Return a motion with its standard deviations, and the IMU's biases."""
    parts = state_parts(motion, (*STATES, *BIASES))
    return FusedMotion(time=signals.time, segment=signals.segment, **parts)


def no_fused_motion() -> FusedMotion:
    """Return the record of a recording without a valid IMU: it has no samples."""
    parts = dict.fromkeys(STATES, np.zeros((0, 6))) | dict.fromkeys(BIASES, np.zeros((0, 3)))
    parts |= {f"{name}_std": values for name, values in parts.items()}
    parts["motor_qd"] = np.zeros((0, 6))
    return FusedMotion(time=np.zeros(0), segment=np.zeros(0, np.int64), **parts)
