"""Unbroken stretches of a recording, divided by gaps, blocks of time, and rest."""

from collections.abc import Callable, Iterable
from itertools import pairwise

import numpy as np

from ur5lib.timeseries.arrays import Array, Labels, Mask

BLOCK = 2.0  # s, several correlation times of residuals (0.3 to 1 s on both arms)
DEAD_ZONE = 0.02  # rad/s (Equation 6.4): below it, a joint rests and friction is stiction


def period(time: Array) -> float:
    """Return the cycle [s] of uniform times (N,) [s]."""
    return round(float(np.median(np.diff(time))), 9)


def starts(segment: Labels) -> Mask:
    """Return whether each sample (N,) is the first of its segment."""
    return np.diff(segment, prepend=segment[:1] - 1) != 0


def unbroken(*labels: Labels | Mask) -> list[slice]:
    """Return the longest stretches of samples in which none of the labels (N,) changes."""
    changes = np.any([np.diff(label) != 0 for label in labels], axis=0)
    bounds = [0, *(1 + np.flatnonzero(changes)), len(labels[0])]
    return [slice(start, end) for start, end in pairwise(bounds) if end > start]


def marked(spans: Iterable[tuple[int, int]], count: int) -> Mask:
    """Return which of `count` samples lie inside any of the spans, (first, end) each."""
    inside = np.zeros(count, bool)
    for span in spans:
        inside[slice(*span)] = True
    return inside


def by_segment(function: Callable[[Array], Array], values: Array, segment: Labels) -> Array:
    """Apply a function of uniform samples to each unbroken stretch on its own.

    values: (N, M); segment: (N,) labels. A row with NaN stays NaN and breaks its segment.
    """
    result = np.full_like(values, np.nan)
    finite = np.asarray(np.isfinite(values).all(axis=1))
    for stretch in unbroken(segment, finite):
        if finite[stretch.start]:
            result[stretch] = function(values[stretch])
    return result
