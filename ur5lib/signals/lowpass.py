"""Butterworth low-pass filters, designed in Hz as second-order sections."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray
from scipy import signal

Array = NDArray[np.float64]


def zero_phase_lowpass(values: Array, rate: float, order: int, cutoff: float) -> Array:
    """Butterworth low-pass run forwards and backwards: no delay, and -6 dB at the cut-off.

    values: (N, M) without gaps; rate, cutoff: [Hz]. Raises ValueError beyond Nyquist.
    """
    sections = _design(rate, order, cutoff)
    padding = min(len(values) - 1, int(3 * rate / cutoff))
    return signal.sosfiltfilt(sections, values, axis=0, padlen=padding)


def causal_lowpass(values: Array, rate: float, order: int, cutoff: float) -> Array:
    """Butterworth low-pass run forwards from rest, as the thesis's scripts did: it delays.

    values: (N, M) without gaps; rate, cutoff: [Hz]. Raises ValueError beyond Nyquist.
    """
    return signal.sosfilt(_design(rate, order, cutoff), values, axis=0)


def by_segment(
    function: Callable[[Array], Array], values: Array, segment: NDArray[np.int64]
) -> Array:
    """Apply a function of uniform samples to each unbroken stretch on its own.

    values: (N, M); segment: (N,) labels. A row with NaN stays NaN and breaks its segment.
    """
    result = np.full_like(values, np.nan)
    finite = np.asarray(np.isfinite(values).all(axis=1))
    breaks = 1 + np.flatnonzero((np.diff(segment) != 0) | (np.diff(finite) != 0))
    for rows in np.split(np.arange(len(values)), breaks):
        if finite[rows[0]]:
            result[rows] = function(values[rows])
    return result


def _design(rate: float, order: int, cutoff: float) -> Array:
    if not 0 < cutoff < rate / 2:
        raise ValueError(f"a cut-off of {cutoff:g} Hz is not below half the rate of {rate:g} Hz")
    return signal.butter(order, cutoff, fs=rate, output="sos")
