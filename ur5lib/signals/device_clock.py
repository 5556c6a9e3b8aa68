"""The clock of a recording's device: from its gyroscope if it has one, else from start stamps."""

from collections.abc import Mapping
from functools import partial

import numpy as np

from ur5lib.errors import Remark
from ur5lib.signals.clock import Clock, clock_from_host, clock_from_stamps
from ur5lib.signals.clocks import clock_from_rotation
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.segments import by_segment, period


def device_clock(
    device_time: Array,
    gyroscope: Array | None,
    start: Mapping[str, float],
    robot: tuple[Array, Labels, Array],
    frames: tuple[Array, Array],
) -> tuple[Clock, Remark | None]:
    """Return a device's clock, and why it is from its start stamp alone, if it is.

    device_time: (M,) [s], as read, on its own clock; gyroscope: (M, 3) [rad/s], if it has one;
    start: its stamp's `seconds`, `std` and, where known, `drift_std`; robot: time (N,) [s],
    segment (N,) and q (N, 6) [rad], repaired; frames: R_6 (N, 3, 3) and J_g (N, 6, 6) of the
    robot's samples.
    Where the robot's host stamped each sample, its stamps tell. Otherwise, a gyroscope is compared
    with the angular rate of frame 6; other devices measure no motion that could be distinguished
    from contact, so their start stamps are used.
    """
    if "drift_std" in start:
        return clock_from_host(start["seconds"], start["std"], start["drift_std"]), None
    stamps = clock_from_stamps(start["seconds"], start["std"])
    if gyroscope is None:
        return stamps, None
    (time, segment, q), (rotation, jacobian) = robot, frames
    # not the controller's velocities, which lag the positions by some ms
    qd = by_segment(partial(differentiate, period=period(time)), q, segment)
    omega = np.einsum("nij,nj->ni", jacobian[:, 3:], qd)
    return clock_from_rotation(
        time=time,
        rate=np.einsum("nji,nj->ni", rotation, omega),  # in frame 6
        segment=segment,
        device_time=device_time,
        gyroscope=gyroscope,
        stamps=stamps,
    )
