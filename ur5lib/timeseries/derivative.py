"""Numerical derivatives."""

import numpy as np

from ur5lib.timeseries.arrays import Array


def differentiate(values: Array, period: float) -> Array:
    """Return the derivative of uniform samples by central differences, one-sided at the ends.

    values: (N, M); period: [s]. Returns (N, M); NaN where there are fewer than two samples.
    """
    if len(values) < 2:
        return np.full_like(values, np.nan)
    return np.gradient(values, period, axis=0)
