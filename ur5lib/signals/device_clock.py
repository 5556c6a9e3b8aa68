"""The clock of a recording's device, by the best that its signals allow."""

from collections.abc import Mapping
from functools import partial

import numpy as np
import pandas as pd

from ur5lib.signals.clocks import Clock, clock_from_rotation, clock_from_stamps
from ur5lib.tables import channel, period
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.segments import by_segment

GYROSCOPE = ["imu_gx", "imu_gy", "imu_gz"]


def device_clock(
    device: pd.DataFrame,
    start: Mapping[str, float],
    robot: pd.DataFrame,
    rotation: Array,
    jacobian: Array,
) -> tuple[Clock, str | None]:
    """How a device's clock runs against the robot's, and why only its stamps could tell, if so.

    device: as read, on its own clock; start: its stamp's `seconds` and `std`; robot: repaired;
    rotation, jacobian: R_6 (N, 3, 3) and J_g (N, 6, 6) of the robot's samples.
    A gyroscope is compared with the turning of frame 6. Other devices feel no motion that could
    be told apart from contact: their stamps stand.
    """
    stamps = clock_from_stamps(start["seconds"], start["std"])
    if not set(GYROSCOPE) <= set(device):
        return stamps, None
    segment = robot["segment"].to_numpy()
    # Not the controller's velocities: they come some ms after the positions.
    qd = by_segment(
        partial(differentiate, period=period(robot)), channel(robot, "actual_q"), segment
    )
    omega = np.einsum("nij,nj->ni", jacobian[:, 3:], qd)
    return clock_from_rotation(
        time=robot["time"].to_numpy(),
        rate=np.einsum("nji,nj->ni", rotation, omega),  # in frame 6
        segment=segment,
        device_time=device["time"].to_numpy(),
        gyroscope=device[GYROSCOPE].to_numpy(),
        stamps=stamps,
    )
