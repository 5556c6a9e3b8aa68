"""Joint motion by the Kalman smoother, and the test of its innovations."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import takewhile

from ur5lib.records.clocks import SettledClock
from ur5lib.records.table import JOINTS, XYZ, SegmentedTable, channel
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.kalman import InnovationTest


@dataclass(frozen=True, kw_only=True)
class Motion(SegmentedTable):
    """Positions [rad], velocities [rad/s] and accelerations [rad/s²] of the joints on the link's
    side, their standard deviations, and velocities on the motor's side, (N, 6) each.

    Links vibrate against motors; friction acts on the motors' side. What the smoother took to drive
    the joints and to disturb their encoders stands beside it where an IMU is to be added, (N, 6)
    each: jerk, vibration: intensities of white jerks; position_noise, velocity_noise: standard
    deviations; shared: the covariance that it leaves to velocities and accelerations.
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


def motions_before(chain: Sequence[str], motion: Mapping[str, Motion]) -> list[Motion]:
    """Return the motions of a chain of recordings, oldest first, from the last on that is unknown.

    chain: their names, oldest first; motion: of those that can be read.
    """
    known = [*takewhile(motion.__contains__, reversed(chain))]
    return [motion[name] for name in reversed(known)]


@dataclass(frozen=True, kw_only=True)
class FusedMotion(Motion):
    """The same from encoders and IMU, and the IMU's biases, (N, 3) [m/s², rad/s].

    Without any sample where no IMU's clock could be estimated from its motion.
    """

    accelerometer_bias: Array = channel("accelerometer_bias", "m/s2", XYZ)
    gyroscope_bias: Array = channel("gyroscope_bias", "rad/s", XYZ)
    accelerometer_bias_std: Array = channel("accelerometer_bias_std", "m/s2", XYZ)
    gyroscope_bias_std: Array = channel("gyroscope_bias_std", "rad/s", XYZ)


@dataclass(frozen=True)
class MotionAccount:
    """The estimated noise by name, and the test of the innovations.

    noise: what varies with time as its quantiles (3, 6) of 10, 50 and 90 %, what lasts as (6,).
    """

    noise: dict[str, Array]
    innovations: InnovationTest


@dataclass(frozen=True)
class Alignment:
    """alignment.json: the clocks of the devices, by which the signals are aligned, and how well the
    smoother's motion explains the encoders.
    """

    clocks: dict[str, SettledClock]
    encoders: MotionAccount
