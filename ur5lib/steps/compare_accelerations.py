"""Acceleration of the end effector: from joints, through Euler angles, and from an IMU."""

from typing import NamedTuple

import pandas as pd

from ur5lib.records.accelerations import Accelerations, ImuComparison
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Alignment, FusedMotion, Motion, MotionAccount
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import ImuCalibration, calibration_for
from ur5lib.signals.imu_samples import has_valid_imu
from ur5lib.signals.resampling import by_stamps
from ur5lib.smoothing.beside_imu import beside_imu, fuse_imu, judged
from ur5lib.smoothing.fused_motion import no_fused_motion
from ur5lib.tidy import part
from ur5lib.tidy.accelerations import acceleration_mae, innovations
from ur5lib.timeseries.lowpass import Butterworth


class ComparedMotion(NamedTuple):
    """A recording's motion beside its IMU; errors, innovations: its rows of the tables
    `acceleration_mae` and `innovations`.
    """

    fused: FusedMotion
    accelerations: Accelerations
    comparison: ImuComparison
    errors: pd.DataFrame
    innovations: pd.DataFrame


def compare_accelerations(
    recording: str,
    quality: Quality,
    imu: pd.DataFrame,
    kinematics: Kinematics,
    signals: Signals,
    motion: Motion,
    alignment: Alignment,
    arm: Robot,
    calibration: dict[str, ImuCalibration],
    calibration_without_each: dict[str, ImuCalibration],
    lowpass: Butterworth,
    gravity: list[float] | None = None,
) -> ComparedMotion:
    """Return the motion from encoders and IMU, and the end effector's acceleration from joints,
    through Euler angles and from the IMU; empty without a valid IMU.

    imu: its samples, by its own clock; calibrations: from all `fit` recordings, and from contact-
    free ones without each; lowpass: of the accelerations.
    """
    robot, fused, account = arm.mounted(gravity), no_fused_motion(), dict[str, MotionAccount]()
    accelerations = Accelerations(time=signals.time, segment=signals.segment)
    comparison = ImuComparison()
    if has_valid_imu(alignment.clocks):
        known = calibration_for(recording, calibration)
        fused, account = fuse_imu(robot, kinematics, signals, motion, alignment, known)
        unseen = calibration_for(recording, calibration_without_each)
        placed = by_stamps(imu, quality.starts["imu"], signals.time, "imu")
        motions = {"encoders": motion, "encoders+imu": fused}
        own = beside_imu(robot, kinematics, signals, motions, unseen)
        accelerations, comparison = judged(own, lowpass, placed, motion.qd)
    encoders = {"encoders": alignment.encoders}
    errors = part("acceleration_mae", acceleration_mae(comparison))
    tests = part("innovations", innovations(encoders, account))
    return ComparedMotion(fused, accelerations, comparison, errors, tests)
