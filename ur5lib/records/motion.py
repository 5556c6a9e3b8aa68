"""Joint motion by the Kalman smoother, and the test of its innovations."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ur5lib.records.clocks import SettledClock
from ur5lib.records.table import JOINTS, XYZ, SegmentedTable, channel
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.kalman import InnovationTest

# rad; repeated readings of an arm at rest agree within this, over which friction reverses, too.
SAME_POSTURE = 1e-4


@dataclass(frozen=True, kw_only=True)
class Motion(SegmentedTable):
    """Positions [rad], velocities [rad/s] and accelerations [rad/s²] of the joints on the link's
    side, their standard deviations, and velocities on the motor's side, (N, 6) each.

    Links vibrate against motors; friction acts on the motors' side. For the fusion with an IMU, it
    also has the smoother's process and encoder noise, (N, 6) each: jerk, vibration: intensities of
    white jerks; position_noise, velocity_noise: standard deviations; shared: posterior covariance
    of velocity and acceleration.
    """

    q: Array = channel("q", "rad", JOINTS)
    qd: Array = channel("qd", "rad/s", JOINTS)
    qdd: Array = channel("qdd", "rad/s2", JOINTS)
    q_std: Array = channel("q_std", "rad", JOINTS)
    qd_std: Array = channel("qd_std", "rad/s", JOINTS)
    qdd_std: Array = channel("qdd_std", "rad/s2", JOINTS)
    motor_qd: Array = channel("motor_qd", "rad/s", JOINTS)
    jerk: Array | None = channel("jerk", "rad/s3/sqrt(Hz)", JOINTS, optional=True)
    vibration: Array | None = channel("vibration", "rad/s3/sqrt(Hz)", JOINTS, optional=True)
    position_noise: Array | None = channel("position", "rad", JOINTS, optional=True)
    velocity_noise: Array | None = channel("velocity", "rad/s", JOINTS, optional=True)
    shared: Array | None = channel("shared", "rad2/s3", JOINTS, optional=True)


def posture_change(before: Motion, own: Motion) -> Array:
    """Return the change (n,) [rad] of the joints' angles from the end of one recording to the start
    of another.
    """
    return own.q[0] - before.q[-1]


def motions_before(own: Motion, chain: Sequence[str], motion: Mapping[str, Motion]) -> list[Motion]:
    """Return the motions before a recording, oldest first, each beginning where the last one ended.

    chain: names of the earlier recordings, oldest first; motion: of readable recordings. Motions
    before an unreadable recording, or before the arm was moved in between, are left out.
    """
    known = [own]
    for name in reversed(chain):
        if name not in motion:
            break
        earlier = motion[name]
        if not np.abs(posture_change(earlier, known[-1])).max() <= SAME_POSTURE:
            break
        known.append(earlier)
    return known[:0:-1]


@dataclass(frozen=True, kw_only=True)
class FusedMotion(Motion):
    """The motion from encoders and IMU, and the IMU's biases, (N, 3) [m/s², rad/s].

    Without samples if no IMU's clock could be estimated from its motion.
    """

    accelerometer_bias: Array = channel("accelerometer_bias", "m/s2", XYZ)
    gyroscope_bias: Array = channel("gyroscope_bias", "rad/s", XYZ)
    accelerometer_bias_std: Array = channel("accelerometer_bias_std", "m/s2", XYZ)
    gyroscope_bias_std: Array = channel("gyroscope_bias_std", "rad/s", XYZ)


@dataclass(frozen=True)
class MotionAccount:
    """The estimated noise by name, and the test of the innovations.

    noise: time-varying ones as quantiles (3, 6) of 10, 50 and 90 %, constant ones as (6,).
    """

    noise: dict[str, Array]
    innovations: InnovationTest


@dataclass(frozen=True)
class Alignment:
    """alignment.json: the clocks that align the devices' signals, and the smoother's noise and test
    of innovations on the encoders.
    """

    clocks: dict[str, SettledClock]
    encoders: MotionAccount
