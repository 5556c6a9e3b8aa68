"""One recording as a calibration of its IMU sees it."""

from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.signals.clocks import BY_MOTION
from ur5lib.signals.end_effector import point_velocity
from ur5lib.signals.imu_calibration import ImuRecord
from ur5lib.tables import channel, period
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.lowpass import inner_lowpass
from ur5lib.timeseries.segments import by_segment

ACCELEROMETER = ["imu_ax", "imu_ay", "imu_az"]
GYROSCOPE = ["imu_gx", "imu_gy", "imu_gz"]


def has_valid_imu(clocks: Mapping[str, Any]) -> bool:
    """Whether motion told the IMU's clock (clocks.json): then its readings are of that motion."""
    return bool(clocks.get("imu", {}).get("method") == BY_MOTION)


def imu_record(
    signals: pd.DataFrame,
    kinematics: pd.DataFrame,
    point: Array,
    gravity: Array,
    order: int,
    cutoff: float,
) -> ImuRecord:
    """What the joints predict and the IMU read, both low-passed without delay.

    signals: on the robot's clock, with an IMU; kinematics: of the same samples; point: (3,) [m],
    the IMU in frame 6; gravity: (3,) [m/s²], base frame; cutoff: [Hz]. Rows where either side is
    missing, and ends where the filter guesses, are left out.
    """
    rotation = channel(kinematics, "R6", 9).reshape(-1, 3, 3)
    jacobian = channel(kinematics, "J", 36).reshape(-1, 6, 6)
    segment = signals["segment"].to_numpy()
    step = period(signals)
    lowpass = partial(inner_lowpass, rate=1 / step, order=order, cutoff=cutoff)
    change = partial(differentiate, period=step)
    # The controller's velocities come some ms after the positions that R_6 and J_g are of.
    qd = by_segment(change, channel(signals, "actual_q"), segment)
    velocity = point_velocity(rotation, jacobian, qd, point)
    acceleration = by_segment(change, velocity[:, :3], segment)
    sides = [
        np.einsum("nji,nj->ni", rotation, acceleration - gravity),
        np.einsum("nji,nj->ni", rotation, velocity[:, 3:]),
        signals[[*ACCELEROMETER, *GYROSCOPE]].to_numpy(),
    ]
    smooth = by_segment(lowpass, np.concatenate(sides, axis=1), segment)
    kept = np.isfinite(smooth).all(axis=1)
    time = signals["time"].to_numpy()
    force, rate, accelerometer, gyroscope = np.split(smooth[kept], 4, axis=1)
    return ImuRecord(
        time[kept], rotation[kept], force, rate, accelerometer, gyroscope, gravity=gravity
    )
