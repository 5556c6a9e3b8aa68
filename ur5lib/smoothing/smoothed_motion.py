"""Joint motion by the Kalman smoother, as motion.parquet."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ur5lib.records.motion import Motion, MotionAccount
from ur5lib.records.signals import Signals
from ur5lib.smoothing.encoders import KnownJoints, SmoothedJoints, SmoothedMotion
from ur5lib.smoothing.noise import EncoderNoise
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.sampling import differentiate
from ur5lib.timeseries.segments import by_segment

LOCAL_NOISE = ("jerk", "vibration", "position", "velocity")
STATES = ("q", "qd", "qdd")


def measured(signals: Signals) -> tuple[Array, Array]:
    """Return positions and velocities (N, 6), NaN where interpolated.

    Differences of the positions replace velocities that were not recorded.
    """
    q, qd = signals.actual_q.copy(), signals.actual_qd
    if qd is None:
        qd = by_segment(differentiate, q, signals.segment, signals.period)
    qd = qd.copy()
    q[signals.interpolated] = qd[signals.interpolated] = np.nan
    return q, qd


def motion_record(signals: Signals, motion: SmoothedJoints) -> Motion:
    """Return positions, velocities, accelerations and their standard deviations as a record.

    It includes the noise of the encoders if an IMU was recorded.
    """
    record = Motion(time=signals.time, segment=signals.segment, **state_parts(motion))
    if signals.accelerometer is None:
        return record
    noise = motion.encoders
    return replace(
        record,
        jerk=noise.jerk,
        vibration=noise.vibration,
        position_noise=noise.position,
        velocity_noise=noise.velocity,
        shared=motion.shared,
    )


def known_joints(motion: Motion, account: MotionAccount) -> KnownJoints:
    """Return the motion by encoders that `smooth_encoders` found; account: of this motion, from
    `motion_account`.

    Raises ValueError if the motion lacks the noise of its encoders.
    """
    jerk, vibration, shared = motion.jerk, motion.vibration, motion.shared
    position, velocity = motion.position_noise, motion.velocity_noise
    if jerk is None or vibration is None or shared is None or position is None or velocity is None:
        raise ValueError("the motion was smoothed without an IMU to add")
    state, std = (
        np.hstack([getattr(motion, name + kind) for name in STATES]) for kind in ("", "_std")
    )
    lasting = {name: account.noise[name] for name in ("frequency", "damping", "lag")}
    noise = EncoderNoise(jerk, vibration, position=position, velocity=velocity, **lasting)
    return KnownJoints(state, std, shared, noise)


def state_parts(motion: SmoothedMotion, names: Sequence[str] = STATES) -> dict[str, Array]:
    """Return parts of the state, their standard deviations and the motors' velocities by name.

    names: of q, q̇ and q̈ of the joints, then of parts of three columns each.
    """
    joints = motion.motor_qd.shape[1]
    ends = [joints, 2 * joints, 3 * joints, 3 * joints + 3]
    parts = {"motor_qd": motion.motor_qd}
    for kind, values in (("", motion.state), ("_std", motion.std)):
        split = zip(names, np.split(values, ends, axis=1), strict=False)
        parts |= {name + kind: part for name, part in split}
    return parts


def motion_account(motion: SmoothedMotion) -> MotionAccount:
    """Return the estimated noise and the tests of the innovations."""
    noise = dict(vars(motion.encoders))
    for name in LOCAL_NOISE:
        noise[name] = np.quantile(noise[name], [0.1, 0.5, 0.9], axis=0)
    if motion.imu is not None:
        noise["imu"] = np.nanmedian(motion.imu, axis=0)
    return MotionAccount(noise, motion.test)
