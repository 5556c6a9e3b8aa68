"""Signals of a device on the robot's clock."""

import numpy as np
import pandas as pd
from numpy.typing import NDArray

from ur5lib.signals.clocks import Clock

Array = NDArray[np.float64]


def resample(device: pd.DataFrame, clock: Clock, time: Array) -> pd.DataFrame:
    """A device's channels at the robot's times, by linear interpolation.

    device: `time` [s] on its own clock, increasing, and channels; time: (N,) [s].
    Before the device's first sample and after its last the result is NaN: nothing is invented.
    """
    own = clock.offset + (1 + (clock.drift or 0.0)) * device["time"].to_numpy()
    channels = device.drop(columns="time")
    values = {
        name: np.interp(time, own, column, left=np.nan, right=np.nan)
        for name, column in channels.items()
    }
    return pd.DataFrame(values)
