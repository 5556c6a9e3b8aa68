"""Noise whose neighbours are alike, as the errors of real arms are."""

import numpy as np
from scipy.signal import lfilter

from ur5lib.timeseries.arrays import Array


def slow_noise(seed: int, shape: tuple[int, int], correlation: float) -> Array:
    """Normal noise of variance 1, an autoregression of first order along its rows.

    correlation: of neighbours.
    """
    noise = np.random.default_rng(seed).standard_normal(shape)
    noise[:, 1:] *= np.sqrt(1 - correlation**2)
    return np.asarray(lfilter([1.0], [1.0, -correlation], noise, axis=1))
