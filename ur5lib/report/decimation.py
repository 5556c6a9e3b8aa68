"""Long recordings made short enough to draw, without losing a peak or a gap."""

from itertools import pairwise

import numpy as np

from ur5lib.timeseries.arrays import Array

POINTS = 1400  # about two for each dot across a printed page


def decimate(time: Array, values: Array, points: int = POINTS) -> tuple[Array, Array]:
    """Return time (N,) and values (N, M) with the same envelope in about `points` rows, at most.

    Rows are grouped in buckets. Each bucket keeps the lowest and the highest value of every column,
    in their order, at the times of its first and middle row. Rows with time NaN mark gaps; they are
    kept, and no bucket reaches across them.
    """
    size = int(np.ceil(2 * len(time) / points))
    if size <= 2:
        return time, values
    breaks = np.flatnonzero(np.isnan(time))
    edges = np.unique([0, *breaks, *(breaks + 1), len(time)])
    parts = [_envelope(time[start:end], values[start:end], size) for start, end in pairwise(edges)]
    times, envelopes = zip(*parts, strict=True)
    return np.concatenate(times), np.concatenate(envelopes)


def _envelope(time: Array, values: Array, size: int) -> tuple[Array, Array]:
    """Decimate one stretch; the last bucket is filled with its last row."""
    if np.isnan(time[0]):
        return time, values
    missing = -len(time) % size
    time = np.pad(time, (0, missing), mode="edge").reshape(-1, size)
    buckets = np.pad(values, ((0, missing), (0, 0)), mode="edge").reshape(len(time), size, -1)
    low, high = np.fmin.reduce(buckets, axis=1), np.fmax.reduce(buckets, axis=1)
    place = np.arange(size)[None, :, None]
    first_low = np.min(np.where(buckets == low[:, None], place, size), axis=1)
    first_high = np.min(np.where(buckets == high[:, None], place, size), axis=1)
    rising = first_low <= first_high
    both: Array = np.stack([np.where(rising, low, high), np.where(rising, high, low)], axis=1)
    return time[:, [0, size // 2]].reshape(-1), both.reshape(2 * len(time), -1)
