"""Signals of all devices."""

from dataclasses import dataclass
from typing import Any

import numpy as np

from ur5lib.channels import CHANNELS, columns
from ur5lib.records.table import JOINTS, SegmentedTable, channel
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment

# Above this cut-off, measured accelerations are mostly noise, unlike the controller's.
ACCELERATION_ORDER, ACCELERATION_CUTOFF = 4, 2.0  # Hz

# A target that moves, and a joint that is led, travel at least this far.
MIN_TARGET_TRAVEL, MIN_LED_TRAVEL = 0.01, 0.1  # rad

SENSOR_COLUMNS = {  # force [N] and torque [Nm]; acceleration [m/s²] and rate [rad/s]
    "force": columns("ft"),
    "imu": [*columns("imu_a"), *columns("imu_g")],
}


def recorded(name: str, optional: bool = True) -> Any:
    """Declare a field of `Signals` for a channel of recordings; optional: whether it may be
    absent.
    """
    unit, named = CHANNELS[name].unit, columns(name)
    if CHANNELS[name].of_joints:
        return channel(name, unit, JOINTS, optional=optional)
    if named == [name]:
        return channel(name, unit, optional=optional)
    stem, labels = named[0].rpartition("_")[0], (own.rpartition("_")[2] for own in named)
    return channel(stem, unit, tuple(labels), optional=optional)


@dataclass(frozen=True, kw_only=True)
class Signals(SegmentedTable):
    """All devices on the robot's clock, under RTDE's names; None where not recorded.

    actual_torque: (N, n) [Nm], where torques are measured, with actual_current None; interpolated:
    (N,), whether a frame was lost and filled in. Joint channels are (N, 6); actual_TCP_force: (N,
    6), the controller's estimate, base frame; ft_raw_wrench: (N, 6), of a wrist sensor, axes of
    frame 6, with bias and tool; wrench_calc_from_currents: (N, 6), the controller's estimate in
    addition to a wrist sensor, base frame; joint_temperatures: (N, 6) [°C], of the motors; payload:
    (N,), payload_cog: (N, 3), frame 6, and payload_inertia: (N, 6), of xx, yy, zz, xy, xz, yz, that
    the controller was given; tcp_offset: (N, 6), its tool centre point in frame 6, position and
    rotation vector; force_sensor: (N, 6), force and torque in the sensor's frame; accelerometer and
    gyroscope: (N, 3), of the IMU, in its frame.
    """

    interpolated: Mask = channel("interpolated", "1", dtype=np.bool_)
    actual_q: Array = recorded("actual_q", optional=False)
    actual_qd: Array | None = recorded("actual_qd")
    actual_current: Array | None = recorded("actual_current")
    actual_torque: Array | None = recorded("actual_torque")
    target_q: Array | None = recorded("target_q")
    target_qd: Array | None = recorded("target_qd")
    target_qdd: Array | None = recorded("target_qdd")
    target_current: Array | None = recorded("target_current")
    target_moment: Array | None = recorded("target_moment")
    actual_TCP_force: Array | None = recorded("actual_TCP_force")  # noqa: N815 - RTDE's name
    ft_raw_wrench: Array | None = recorded("ft_raw_wrench")
    wrench_calc_from_currents: Array | None = recorded("wrench_calc_from_currents")
    joint_temperatures: Array | None = recorded("joint_temperatures")
    payload: Array | None = recorded("payload")
    payload_cog: Array | None = recorded("payload_cog")
    payload_inertia: Array | None = recorded("payload_inertia")
    tcp_offset: Array | None = recorded("tcp_offset")
    force_sensor: Array | None = recorded("ft")
    accelerometer: Array | None = recorded("imu_a")
    gyroscope: Array | None = recorded("imu_g")

    @property
    def effort(self) -> Array | None:
        """Return the measured efforts (N, n), torques [Nm] or currents [A]."""
        return self.actual_current if self.actual_torque is None else self.actual_torque

    @property
    def imu(self) -> Array:
        """Return accelerometer and gyroscope (N, 6); ValueError without an IMU."""
        if self.accelerometer is None or self.gyroscope is None:
            raise ValueError("the recording has no IMU")
        return np.concatenate([self.accelerometer, self.gyroscope], axis=1)


def slowly(
    values: Array,
    signals: Signals,
    lowpass: tuple[int, float] = (ACCELERATION_ORDER, ACCELERATION_CUTOFF),
) -> Array:
    """Return torques or currents (N, n), low-passed without delay within the unbroken parts of a
    recording.

    signals: with the labels of these parts; lowpass: order and cut-off [Hz].
    """
    return by_segment(zero_phase_lowpass, values, signals.segment, 1 / signals.period, *lowpass)


def is_led(signals: Signals) -> bool:
    """Return whether a joint moves while its target rests: a hand guides the arm, so that the
    target's torque does not belong to the motion.
    """
    if signals.target_q is None:
        return False
    rests = np.ptp(signals.target_q, axis=0) < MIN_TARGET_TRAVEL
    moves = np.ptp(signals.actual_q, axis=0) > MIN_LED_TRAVEL
    return bool((rests & moves).any())
