"""Acceleration of the end effector: from joints, through Euler angles, and from an IMU."""

from collections.abc import Iterator
from typing import NamedTuple

import pandas as pd

from ur5lib.records.acceleration_errors import AccelerationError, Innovation
from ur5lib.records.accelerations import Accelerations, ImuComparison
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Alignment, FusedMotion, Motion, MotionAccount
from ur5lib.records.opened import Opened
from ur5lib.records.quality import Quality
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.signals.imu_calibration import ImuCalibration, calibration_for
from ur5lib.signals.imu_samples import has_valid_imu
from ur5lib.signals.resampling import by_stamps
from ur5lib.smoothing.beside_imu import beside_imu, fuse_imu, judged
from ur5lib.smoothing.fused_motion import no_fused_motion
from ur5lib.timeseries.lowpass import Butterworth

CHANNELS = [f"q_{joint}" for joint in range(1, 7)] + [f"qd_{joint}" for joint in range(1, 7)]
CHANNELS += [f"imu_{sensor}{axis}" for sensor in "ag" for axis in "xyz"]


class ComparedMotion(NamedTuple):
    """A recording's motion compared with its IMU: errors, and tests of the smoother."""

    fused: FusedMotion
    accelerations: Accelerations
    comparison: ImuComparison
    errors: list[AccelerationError]
    innovations: list[Innovation]


class Inputs(Opened):
    """What is read of a recording."""

    name: str
    gravity: list[float] | None
    quality: Quality
    imu: pd.DataFrame
    kinematics: Kinematics
    signals: Signals
    motion: Motion
    alignment: Alignment


@step(
    "recording",
    "fused=fused_motion.parquet accelerations.parquet comparison=imu_comparison.json "
    "errors=acceleration_mae.csv innovations.csv",
    lowpass="accelerations_lowpass",
)
def compare_accelerations(
    recording: Inputs,
    arm: Robot,
    calibration: dict[str, ImuCalibration],
    calibration_without_each: dict[str, ImuCalibration],
    lowpass: Butterworth,
) -> ComparedMotion:
    """Return the motion from encoders and IMU, and the end effector's acceleration by all methods.

    The methods are joints, Euler angles and IMU; all is empty without an IMU with a valid clock.
    calibration: by all `fit` recordings; calibration_without_each: by the other contact-free
    recordings; lowpass: of the accelerations.
    """
    signals, motion, alignment = recording.signals, recording.motion, recording.alignment
    robot, kinematics = arm.mounted(recording.gravity), recording.kinematics
    fused, account = no_fused_motion(), dict[str, MotionAccount]()
    accelerations = Accelerations(time=signals.time, segment=signals.segment)
    comparison = ImuComparison()
    if has_valid_imu(alignment.clocks):
        known = calibration_for(recording.name, calibration)
        fused, account = fuse_imu(robot, kinematics, signals, motion, alignment, known)
        unseen = calibration_for(recording.name, calibration_without_each)
        start = recording.quality.starts["imu"]
        placed = by_stamps(recording.imu, start, signals.time, "imu")
        motions = {"encoders": motion, "encoders+imu": fused}
        own = beside_imu(robot, kinematics, signals, motions, unseen)
        accelerations, comparison = judged(own, lowpass, placed, motion.qd)
    tests = {"encoders": alignment.encoders} | account
    return ComparedMotion(
        fused,
        accelerations,
        comparison,
        errors=[*acceleration_errors(comparison)],
        innovations=[row for name, own in tests.items() for row in innovation_rows(name, own)],
    )


def acceleration_errors(comparison: ImuComparison) -> Iterator[AccelerationError]:
    """Yield the MAE of the end effector's acceleration against the IMU."""
    for estimate, errors in comparison.errors.items():
        for component, mae in errors.mae.items():
            zero = errors.zero_mae[component]
            yield AccelerationError(estimate=estimate, component=component, mae=mae, zero_mae=zero)


def innovation_rows(estimate: str, account: MotionAccount) -> Iterator[Innovation]:
    """Yield the tests of the smoother's innovations, variance and whiteness, by channel."""
    test = account.innovations
    for k, channel in enumerate(CHANNELS[: len(test.variance)]):
        low, high = test.variance_limits[k]
        yield Innovation(
            estimate=estimate,
            channel=channel,
            variance=float(test.variance[k]),
            variance_low=float(low),
            variance_high=float(high),
            portmanteau=float(test.portmanteau[k]),
            portmanteau_limit=test.portmanteau_limit,
            consistent=bool(test.consistent[k]),
            white=bool(test.white[k]),
            colour=float(test.colour[k]),
        )
