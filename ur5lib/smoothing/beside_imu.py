"""The motion from encoders and IMU, and the difference of accelerations by both."""

from collections.abc import Callable, Mapping
from functools import partial
from itertools import product
from typing import NamedTuple

import numpy as np

from ur5lib.records.accelerations import (
    COMPONENTS,
    AccelerationErrors,
    Accelerations,
    ByRange,
    Difference,
    ImuComparison,
)
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Alignment, FusedMotion, Motion, MotionAccount
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.robots.end_effector import felt_acceleration, point_acceleration
from ur5lib.signals.euler_angles import by_euler_angles
from ur5lib.signals.imu_calibration import ImuCalibration, accelerometer_bias
from ur5lib.signals.imu_samples import derivative, imu_samples, lowpassed
from ur5lib.smoothing.fused_motion import fused_record, imu_model
from ur5lib.smoothing.imu_fusion import smooth_with_imu
from ur5lib.smoothing.plain_smoother import PlainMotion, smooth_plainly
from ur5lib.smoothing.smoothed_motion import known_joints, measured, motion_account
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, inner_lowpass
from ur5lib.timeseries.metrics import mean_absolute_error
from ur5lib.timeseries.segments import DEAD_ZONE

RANGE_ORDER = 4  # order of the filters that separate ranges of frequency
FREQUENCY_RANGES = {"below 2 Hz": (None, 2.0), "below 5 Hz": (None, 5.0), "5 to 20 Hz": (5.0, 20.0)}
QUANTILE_LEVELS = np.linspace(0, 1, 101)  # quantiles are stated for these shares

Differences = Callable[[float], Mapping[str, Array]]
"""Returns by motion how far both differ in acceleration (N, 6), low-passed at a cut-off [Hz]."""


def fuse_imu(
    robot: Robot,
    kinematics: Kinematics,
    signals: Signals,
    motion: Motion,
    alignment: Alignment,
    calibration: ImuCalibration,
) -> tuple[FusedMotion, dict[str, MotionAccount]]:
    """Return the joints' motion from encoders and IMU, and by the name of the estimate its noise
    and the tests of its innovations.
    """
    encoders = known_joints(motion, alignment.encoders)
    model = imu_model(robot, kinematics, calibration, motion.qd)
    samples = signals.time, signals.segment, *measured(signals)
    fused = smooth_with_imu(*samples, signals.imu, model, encoders)
    return fused_record(signals, fused), {"encoders+imu": motion_account(fused)}


def beside_imu(
    robot: Robot,
    kinematics: Kinematics,
    signals: Signals,
    motions: Mapping[str, Motion],
    calibration: ImuCalibration,
) -> "BesideImu":
    """Return a recording's comparison with its IMU; the motions include that of filterpy's
    smoother.
    """
    plain = smooth_plainly(signals.segment, *measured(signals), signals.period)
    modelled = at_the_imu(robot, kinematics, {**motions, "filterpy": plain}, calibration)
    return BesideImu(robot, signals, kinematics, modelled, calibration)


def judged(
    own: "BesideImu", lowpass: Butterworth, placed: Array, qd: Array
) -> tuple[Accelerations, ImuComparison]:
    """Return the accelerations, and their errors against the IMU.

    placed: the IMU's samples (N, 6), on the robot's clock by start stamps alone; qd: (N, 6)
    [rad/s].
    """
    accelerations, bias = compared(own, lowpass, placed)
    ranged = {"ranges": own.modelled["encoders"], "plain_ranges": own.modelled["filterpy"]}
    return accelerations, ImuComparison(
        errors=acceleration_errors(accelerations),
        calibrated_on=[*own.calibration.from_],
        accelerometer_bias=bias,
        **by_range(partial(differences, own._replace(modelled=ranged)), qd),
    )


class BesideImu(NamedTuple):
    """A recording with an IMU, and the acceleration at the IMU as its motions predict it.

    robot: under the recording's gravity; modelled: (N, 6) by motion, see `at_the_imu`.
    """

    robot: Robot
    signals: Signals
    kinematics: Kinematics
    modelled: Mapping[str, Array]
    calibration: ImuCalibration


def at_the_imu(
    robot: Robot,
    kinematics: Kinematics,
    motions: Mapping[str, Motion | PlainMotion],
    calibration: ImuCalibration,
) -> dict[str, Array]:
    """Return the acceleration J_g q̈ + J̇_g q̇ (N, 6) [m/s², rad/s²] at the IMU by each motion.

    It is linear, then angular, unfiltered, in the base frame.
    """
    point = np.array(robot.mounting.imu) + calibration.shift()
    frames = kinematics.rotation, kinematics.jacobian
    return {
        name: point_acceleration(*frames, motion.qd, motion.qdd, point)
        for name, motion in motions.items()
    }


def as_calibrated(known: BesideImu, design: Butterworth) -> tuple[Array, dict[str, Array], Array]:
    """Return the calibrated IMU's acceleration, the modelled ones there (N, 6), and a bias (3,)
    [m/s²].

    Accelerations are low-passed without delay; the bias is the accelerometer's in this recording.
    """
    robot, signals, kinematics, modelled, calibration = known
    bias = accelerometer_bias(imu_samples(robot, signals, kinematics, design), calibration)
    accelerometer = signals.imu[:, :3] - bias
    axes, up = kinematics.rotation @ calibration.axes(), calibration.up(np.array(robot.gravity))
    turning = derivative(signals, signals.imu[:, 3:])
    felt = felt_acceleration(axes, accelerometer, turning, up)
    smooth = partial(lowpassed, signals, inner_lowpass, design)
    return smooth(felt), {name: smooth(values) for name, values in modelled.items()}, bias


def compared(
    known: BesideImu, design: Butterworth, by_stamps: Array
) -> tuple[Accelerations, Array]:
    """Return the accelerations by IMU and by joints, low-passed, and the accelerometer's bias (3,)
    [m/s²].

    by_stamps: the IMU's samples (N, 6), on the robot's clock by start stamps alone.
    """
    felt, ours, bias = as_calibrated(known, design)
    causal_felt, causal = by_euler_angles(known.robot, known.signals, known.kinematics, by_stamps)
    accelerations = Accelerations(
        time=known.signals.time,
        segment=known.signals.segment,
        felt=felt,
        acceleration=ours,
        causal_felt=causal_felt,
        causal=causal,
    )
    return accelerations, bias


def differences(known: BesideImu, cutoff: float) -> dict[str, Array]:
    """Return the IMU's acceleration less the modelled ones (N, 6), low-passed at a cut-off [Hz]."""
    felt, estimates, _ = as_calibrated(known, Butterworth(RANGE_ORDER, cutoff))
    return {name: felt - values for name, values in estimates.items()}


def acceleration_errors(accelerations: Accelerations) -> dict[str, AccelerationErrors]:
    """Return the MAE by estimate and component against the IMU, and the MAE of zero."""
    causal, ours = accelerations.causal_felt, accelerations.felt
    if causal is None or ours is None:
        return {}
    return _errors(accelerations.causal, causal) | _errors(accelerations.acceleration, ours)


def _errors(estimates: Mapping[str, Array], felt: Array) -> dict[str, AccelerationErrors]:
    zero = mean_absolute_error(np.zeros_like(felt), felt)
    return {
        name: AccelerationErrors(
            dict(zip(COMPONENTS, mean_absolute_error(values, felt), strict=True)),
            dict(zip(COMPONENTS, zero, strict=True)),
        )
        for name, values in estimates.items()
    }


def by_range(differences: Differences, qd: Array) -> dict[str, ByRange]:
    """Return the statistics of the differences between IMU and motions, by motion and range of
    frequency, for the moving and for the resting arm.

    qd: (N, 6) [rad/s]. A state without any sample is left out.
    """
    moving = np.abs(qd).max(axis=1) > DEAD_ZONE
    low = {cutoff: differences(cutoff) for cutoff in (2.0, 5.0, 20.0)}
    ranges: dict[str, ByRange] = {name: {} for name in low[2.0]}
    for motion, (name, (above, below)) in product(ranges, FREQUENCY_RANGES.items()):
        within = low[below][motion] - (low[above][motion] if above else 0)
        known = np.isfinite(within).all(axis=1)
        states = {"motion": within[known & moving], "rest": within[known & ~moving]}
        ranges[motion][name] = {state: _summed(part) for state, part in states.items() if len(part)}
    return ranges


def _summed(difference: Array) -> Difference:
    quantiles = np.quantile(np.abs(difference), QUANTILE_LEVELS, axis=0)
    return Difference(np.mean(difference**2, axis=0), quantiles)
