"""Linear interpolation of several columns at once."""

import numpy as np

from ur5lib.timeseries.arrays import Array, Labels


def interpolated(
    at: Array | Labels, known: Array | Labels, values: Array, outside: float | None = None
) -> Array:
    """Return values (N, M), known at ascending places (N,), interpolated linearly at others (K,).

    outside: what stands beyond both ends; the values of the ends, if None.
    """
    columns = [np.interp(at, known, column, outside, outside) for column in values.T]
    return np.stack(columns, axis=1)
