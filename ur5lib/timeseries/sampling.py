"""Derivative and linear interpolation of several columns at once."""

import numpy as np

from ur5lib.timeseries.arrays import Array, Labels

# Samples this many periods of the cut-off apart contain all of a low-passed signal.
STEP_IN_PERIODS = 0.064


def thinning(period: float, cutoff: float) -> int:
    """Return the stride at which samples of low-passed values are used.

    period: [s]; cutoff: of the low-pass [Hz].
    """
    return max(1, round(STEP_IN_PERIODS / cutoff / period))


def differentiate(values: Array, period: float) -> Array:
    """Return the derivative of uniform samples by central differences, one-sided at the ends.

    values: (N, M); period: [s]. Returns (N, M); NaN where there are fewer than two samples.
    """
    if len(values) < 2:
        return np.full_like(values, np.nan)
    return np.gradient(values, period, axis=0)


def interpolated(
    at: Array | Labels, places: Array | Labels, values: Array, outside: float | None = None
) -> Array:
    """Return values (N, M) at ascending `places` (N,) interpolated linearly at `at` (K,).

    outside: value beyond both ends; None: the values of the ends.
    """
    columns = [np.interp(at, places, column, outside, outside) for column in values.T]
    return np.stack(columns, axis=1)
