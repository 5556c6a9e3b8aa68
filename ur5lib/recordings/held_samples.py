"""Samples of a slow sensor in the rows of a faster recorder, which repeats them until the next."""

from itertools import pairwise

import numpy as np

from ur5lib.timeseries.arrays import Array, Mask

MIN_HELD_VALUES = 10  # this many values show how long a sensor's recorder repeats each
# Most values are repeated for this many rows. Real sensors seldom repeat all components.
MIN_HELD_ROWS = 2.0
# A sensor's rate is even: few values last half as long as most, as chance would have it.
MAX_HOLD_RATIO = 2.0


def fresh_samples(values: Array) -> Mask | None:
    """Return which rows (N,) are new samples, if the recorder repeats a slower sensor's at an even
    rate; None if it does not.

    values: (N, M), in order, without NaN. A value that lasts longer counts as sent again by the
    sensor.
    """
    changes = np.flatnonzero((np.diff(values, axis=0) != 0).any(axis=1)) + 1
    lasting = np.diff(changes)
    if len(lasting) < MIN_HELD_VALUES:
        return None
    soon, usual = np.quantile(lasting, [0.1, 0.5])
    if usual < MIN_HELD_ROWS or usual >= MAX_HOLD_RATIO * soon:
        return None
    fresh = np.zeros(len(values), dtype=bool)
    for first, end in pairwise([0, *changes, len(values)]):
        fresh[first : end - int(usual) // 2 : int(usual)] = True
        fresh[first] = True
    return fresh
