"""Signals of a device on the robot's clock."""

import numpy as np
import pandas as pd
import scipy  # loads scipy.signal at its first use
from scipy.interpolate import CubicSpline

from ur5lib.records.clocks import ClockRelation
from ur5lib.records.quality import StartOffset
from ur5lib.records.signals import SENSOR_COLUMNS
from ur5lib.signals.clock import clock_from_stamps
from ur5lib.signals.device_clock import even_samples, interpolate
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import by_segment

PASSBAND_SHARE = 0.8  # passband over the robot's Nyquist frequency
STOPBAND_ATTENUATION = 60.0  # dB, from the Nyquist frequency on


def resample(device: pd.DataFrame, clock: ClockRelation, time: Array) -> pd.DataFrame:
    """Resample a device's channels at the robot's times without aliasing.

    device: `time` [s] on its own clock, increasing, and channels; time: (N,) [s].
    A device that samples faster than the robot is low-passed without delay below the robot's
    Nyquist frequency; a slower one is interpolated linearly. In the device's gaps, before its
    first sample and after its last, the result is NaN.
    """
    device_time, at = device["time"].to_numpy(), clock.device_time(time)
    channels = device.drop(columns="time")
    values = channels.to_numpy(np.float64)
    result = interpolate(at, device_time, values)
    rate = 1 / float(np.median(np.diff(time)))
    if len(device_time) > 1 and 1 / np.diff(device_time).mean() > rate:
        grid, even = even_samples(device_time, values)
        smooth = _below_nyquist(grid, even, rate)
        finite = np.isfinite(smooth).all(axis=1)
        # a cubic, because linear interpolation would damp 30 Hz by 5 %
        cubic = CubicSpline(grid[finite], smooth[finite])(at)
        result = np.where(np.isnan(result), np.nan, cubic)
    return pd.DataFrame(result, columns=channels.columns)


def _below_nyquist(grid: Array, even: Array, rate: float) -> Array:
    """Low-pass a device's even samples (K, C) below the Nyquist frequency of `rate` [Hz].

    The filter is a symmetric window of finite length: no phase, almost no ringing at a push, and
    straight lines remain unchanged, up to the ends.
    """
    own_rate = 1 / (grid[1] - grid[0])
    # a Kaiser window with a transition that ends at the robot's Nyquist frequency
    count, beta = scipy.signal.kaiserord(
        STOPBAND_ATTENUATION, (1 - PASSBAND_SHARE) * rate / own_rate
    )
    half = count // 2
    window = scipy.signal.firwin(
        2 * half + 1, (1 + PASSBAND_SHARE) / 4 * rate, window=("kaiser", beta), fs=own_rate
    )[:, None]

    def smooth(stretch: Array) -> Array:
        padded = np.pad(stretch, ((half, half), (0, 0)), mode="reflect", reflect_type="odd")
        return scipy.signal.oaconvolve(padded, window, mode="valid", axes=0)

    return by_segment(smooth, even, np.zeros(len(grid), dtype=np.int64))


def by_stamps(device: pd.DataFrame, start: StartOffset, time: Array, sensor: str) -> Array:
    """Return a sensor's reading (N, 6) at the robot's times (N,) [s], by its start stamp alone.

    NaN for components that it did not log. device: samples on its own clock; start: offset of this
    clock, and its error; sensor: "force" or "imu".
    """
    clock = clock_from_stamps(start.seconds, start.std)
    return resample(device, clock, time).reindex(columns=SENSOR_COLUMNS[sensor]).to_numpy()
