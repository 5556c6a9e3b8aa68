"""Devices placed on the robot's clock by their start stamps alone, as in the thesis."""

import pandas as pd

from ur5lib.pipeline.records.signals import SENSOR_COLUMNS
from ur5lib.recordings.quality import StartOffset
from ur5lib.signals.clock import clock_from_stamps
from ur5lib.signals.resampling import resample
from ur5lib.timeseries.arrays import Array


def by_stamps(device: pd.DataFrame, start: StartOffset, time: Array, sensor: str) -> Array:
    """Return a sensor's reading (N, 6) at the robot's times (N,) [s], NaN where it has no column.

    device: on its own clock; start: of its stamp; sensor: "force" or "imu".
    """
    clock = clock_from_stamps(start.seconds, start.std)
    return resample(device, clock, time).reindex(columns=SENSOR_COLUMNS[sensor]).to_numpy()
