"""Linear interpolation of several columns at once."""

import numpy as np

from ur5lib.timeseries.arrays import Array, Labels


def interpolated(
    at: Array | Labels, known: Array | Labels, values: Array, outside: float | None = None
) -> Array:
    """Return values (N, M) at ascending places `known` (N,) interpolated linearly at `at` (K,).

    outside: value beyond both ends; None: the values of the ends.
    """
    columns = [np.interp(at, known, column, outside, outside) for column in values.T]
    return np.stack(columns, axis=1)
