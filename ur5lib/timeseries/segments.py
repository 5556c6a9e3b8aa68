"""Parts of a recording: unbroken stretches, blocks of time, and chunks of constant memory."""

from collections.abc import Callable, Iterable
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ur5lib.timeseries.arrays import Array, Labels, Mask

T = TypeVar("T", bound=np.generic)
Span = tuple[int, int]  # first sample, and the one after the last

BLOCK_DURATION = 2.0  # s; several correlation times of residuals (0.3 to 1 s on both arms)
DEAD_ZONE = 0.02  # rad/s (Equation 6.4): below it, a joint rests and friction is stiction
CHUNK_SAMPLES = 1 << 14


def period(time: Array) -> float:
    """Return the period [s] of uniform times (N,) [s]."""
    return round(float(np.median(np.diff(time))), 9)


def starts(segment: Labels) -> Mask:
    """Return the mask (N,) of samples that are the first of their segment."""
    return np.diff(segment, prepend=segment[:1] - 1) != 0


def unbroken(*labels: Labels | Mask) -> list[slice]:
    """Return slices of successive samples in which none of the labels (N,) changes, each as long as
    possible.
    """
    changes = np.any([np.diff(label) != 0 for label in labels], axis=0)
    bounds = [0, *(1 + np.flatnonzero(changes)), len(labels[0])]
    return [slice(start, end) for start, end in pairwise(bounds) if end > start]


def extrapolated_samples(cutoff: float, period: float) -> int:
    """Return the number of samples at each end of an unbroken part that a zero-phase low-pass
    extrapolates.

    It is half a period of the cut-off [Hz]. period: of the samples [s].
    """
    return round(0.5 / cutoff / period)


def without_ends(values: Array, segment: Labels, period: float, cutoff: float) -> Array:
    """Return low-passed values (N, M), NaN at the ends of each unbroken part, where the low-pass
    extrapolates.

    segment: (N,) labels of unbroken parts; period: [s]; cutoff: of the low-pass [Hz].
    """
    result, samples = values.copy(), extrapolated_samples(cutoff, period)
    for stretch in unbroken(segment):
        part = result[stretch]
        part[:samples] = np.nan
        part[max(0, len(part) - samples) :] = np.nan
    return result


def runs(flags: Mask) -> Labels:
    """Return (first, last) rows (n, 2) of each run of True in flags (N,); last is exclusive."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return edges.reshape(-1, 2)


def spans(signal: Array, on: float, off: float) -> list[Span]:
    """Return (first, last) rows of each part of a signal (N,) that stays above `off` and reaches
    `on`; last is exclusive.
    """
    stretches = runs(signal > off).tolist()
    return [(first, last) for first, last in stretches if signal[first:last].max() >= on]


def overlap(first: Span, second: Span) -> int:
    """Return the number of samples that two spans, (first, last) with last exclusive, share."""
    return max(0, min(first[1], second[1]) - max(first[0], second[0]))


def inside_spans(parts: Iterable[Span], count: int) -> Mask:
    """Return the mask (count,) of samples inside any of the parts, (first, last) with last
    exclusive.
    """
    inside = np.zeros(count, bool)
    for part in parts:
        inside[slice(*part)] = True
    return inside


def within(time: Array, parts: Iterable[tuple[float, float]], margin: float) -> Mask:
    """Return the mask (N,) of times [s] inside any of the parts, from and to [s] since the first
    time, or less than a margin [s] away.
    """
    since, inside = time - time[:1], np.zeros(len(time), bool)
    for start, end in parts:
        inside |= (since >= start - margin) & (since <= end + margin)
    return inside


def by_segment(
    function: Callable[..., Array], values: Array, segment: Labels, *settings: float
) -> Array:
    """Apply a function of uniform samples, and of settings, to each unbroken part separately.

    values: (N, M); segment: (N,) labels. A row with NaN stays NaN and ends its part.
    """
    result = np.full_like(values, np.nan)
    finite = np.asarray(np.isfinite(values).all(axis=1))
    for stretch in unbroken(segment, finite):
        if finite[stretch.start]:
            result[stretch] = function(values[stretch], *settings)
    return result


def chunks(count: int, size: int = CHUNK_SAMPLES) -> list[slice]:
    """Return slices of `size` successive samples that cover `count`."""
    return [slice(start, min(start + size, count)) for start in range(0, count, size)]


def in_chunks(function: Callable[..., NDArray[T]], *arrays: Array) -> NDArray[T]:
    """Return function(*arrays), computed chunk by chunk to save memory; samples (N, ...) do not
    affect one another.
    """
    first, *others = chunks(len(arrays[0])) or [slice(0)]
    part = function(*(array[first] for array in arrays))
    if not others:
        return part
    result = np.empty((len(arrays[0]), *part.shape[1:]), part.dtype)
    result[first] = part
    for rows in others:
        result[rows] = function(*(array[rows] for array in arrays))
    return result
