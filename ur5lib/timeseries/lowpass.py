"""Butterworth low-pass filters, designed in Hz as second-order sections.

A cut-off at or above the Nyquist frequency, half a record's rate, changes nothing. Records of
different rates can thus share a cut-off.
"""

from functools import cache, partial
from typing import NamedTuple

import numpy as np
import scipy  # scipy.signal takes long to load, and does at its first use

from ur5lib.timeseries.arrays import Array

MAX_NUMBERS_TOGETHER = 1_000_000  # up to this many numbers are filtered at once: faster
IDENTITY_SECTION = np.array([[1.0, 0.0, 0.0, 1.0, 0.0, 0.0]])  # a second-order section


class Butterworth(NamedTuple):
    """The order and the cut-off [Hz] of a Butterworth filter, to be passed as
    `zero_phase_lowpass(values, rate, *design)`.
    """

    order: int
    cutoff: float


def zero_phase_lowpass(values: Array, rate: float, order: int, cutoff: float) -> Array:
    """Apply a Butterworth low-pass forwards and backwards: no delay, and -6 dB at the cut-off.

    values: (N, M) without gaps; rate, cutoff: [Hz]. Raises ValueError for a cut-off not above zero.
    Both ends are continued by their reflection in the end point, so that lines stay lines.
    """
    sections = _design(rate, order, cutoff)
    padding = min(len(values) - 1, int(3 * rate / cutoff))
    both_ways = partial(scipy.signal.sosfiltfilt, sections, axis=0, padlen=padding)
    if 0 < values.size <= MAX_NUMBERS_TOGETHER:
        return np.asarray(both_ways(values))
    result = np.empty(values.shape)
    for column, smooth in zip(values.T, result.T, strict=True):  # one at a time takes less memory
        smooth[:] = both_ways(column)
    return result


def causal_lowpass(values: Array, rate: float, order: int, cutoff: float) -> Array:
    """Apply a Butterworth low-pass forwards from rest, with delay.

    values: (N, M) without gaps; rate, cutoff: [Hz]. Raises ValueError for a cut-off not above zero.
    """
    return scipy.signal.sosfilt(_design(rate, order, cutoff), values, axis=0)


def inner_lowpass(values: Array, rate: float, order: int, cutoff: float) -> Array:
    """Apply `zero_phase_lowpass`; NaN within 1/cutoff of the ends, where it extrapolates."""
    edge = round(rate / cutoff)
    result = np.full_like(values, np.nan)
    if len(values) > 2 * edge:
        inside = slice(edge, -edge)
        result[inside] = zero_phase_lowpass(values, rate, order, cutoff)[inside]
    return result


def slow_delay(design: Butterworth) -> float:
    """Return the delay [s] of slow signals in one pass: 1/(2π f_c sin(π/2n))."""
    return 1 / (2 * np.pi * design.cutoff * np.sin(np.pi / (2 * design.order)))


def frequency_response(frequency: Array, rate: float, order: int, cutoff: float) -> Array:
    """Return the gain (K,) of one pass at frequencies (K,) [Hz] (5.12); two passes have its square.

    rate, cutoff: [Hz]. Raises ValueError for a cut-off not above zero.
    """
    return np.abs(scipy.signal.freqz_sos(_design(rate, order, cutoff), frequency, fs=rate)[1])


@cache
def _design(rate: float, order: int, cutoff: float) -> Array:
    if not cutoff > 0:
        raise ValueError(f"a cut-off of {cutoff:g} Hz is not above zero")
    if cutoff >= rate / 2:
        return IDENTITY_SECTION
    return scipy.signal.butter(order, cutoff, fs=rate, output="sos")
