"""Signals of all devices."""

from dataclasses import dataclass

import numpy as np

from ur5lib.pipeline.records.table import JOINTS, XYZ, SegmentedTable, channel
from ur5lib.timeseries.arrays import Array, Mask

FORCE_SENSOR = ("fx", "fy", "fz", "tx", "ty", "tz")
ACCELEROMETER, GYROSCOPE = ("ax", "ay", "az"), ("gx", "gy", "gz")
SENSOR_COLUMNS = {  # of force [N] and torque [Nm], of acceleration [m/s²] and rate [rad/s]
    "force": [f"ft_{axis}" for axis in FORCE_SENSOR],
    "imu": [f"imu_{axis}" for axis in ACCELEROMETER + GYROSCOPE],
}


@dataclass(frozen=True, kw_only=True)
class Signals(SegmentedTable):
    """All devices on the robot's clock, under RTDE's names; None where not recorded.

    interpolated: (N,), whether a frame was lost and filled in. Joint channels are (N, 6);
    actual_TCP_force: (N, 6), the controller's estimate, base frame; ft_raw_wrench: (N, 6), of a
    wrist sensor, axes of frame 6, with its bias and its tool; joint_temperatures: (N, 6) [°C], of
    the motors; payload: (N,), payload_cog:
    (N, 3), frame 6, and payload_inertia: (N, 6), of xx, yy, zz, xy, xz, yz, that the controller was
    given; tcp_offset: (N, 6), its tool centre point in frame 6, position and rotation vector;
    force_sensor: (N, 6), force and torque in the sensor's frame; accelerometer and
    gyroscope: (N, 3), of the IMU, in its frame.
    """

    interpolated: Mask = channel("interpolated", "1", dtype=np.bool_)
    actual_q: Array = channel("actual_q", "rad", JOINTS)
    actual_qd: Array | None = channel("actual_qd", "rad/s", JOINTS, optional=True)
    actual_current: Array | None = channel("actual_current", "A", JOINTS, optional=True)
    target_q: Array | None = channel("target_q", "rad", JOINTS, optional=True)
    target_qd: Array | None = channel("target_qd", "rad/s", JOINTS, optional=True)
    target_qdd: Array | None = channel("target_qdd", "rad/s2", JOINTS, optional=True)
    target_current: Array | None = channel("target_current", "A", JOINTS, optional=True)
    target_moment: Array | None = channel("target_moment", "Nm", JOINTS, optional=True)
    actual_TCP_force: Array | None = channel(  # noqa: N815 - RTDE's name
        "actual_TCP_force", "N, Nm", JOINTS, optional=True
    )
    ft_raw_wrench: Array | None = channel("ft_raw_wrench", "N, Nm", JOINTS, optional=True)
    joint_temperatures: Array | None = channel("joint_temperatures", "degC", JOINTS, optional=True)
    payload: Array | None = channel("payload", "kg", optional=True)
    payload_cog: Array | None = channel("payload_cog", "m", XYZ, optional=True)
    payload_inertia: Array | None = channel("payload_inertia", "kg m2", JOINTS, optional=True)
    tcp_offset: Array | None = channel("tcp_offset", "m, rad", JOINTS, optional=True)
    force_sensor: Array | None = channel("ft", "N, Nm", FORCE_SENSOR, optional=True)
    accelerometer: Array | None = channel("imu", "m/s2", ACCELEROMETER, optional=True)
    gyroscope: Array | None = channel("imu", "rad/s", GYROSCOPE, optional=True)

    @property
    def imu(self) -> Array:
        """Return accelerometer and gyroscope (N, 6); ValueError without an IMU."""
        if self.accelerometer is None or self.gyroscope is None:
            raise ValueError("the recording has no IMU")
        return np.concatenate([self.accelerometer, self.gyroscope], axis=1)
