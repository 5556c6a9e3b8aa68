"""Joint motion from filtered encoders."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def differentiate(values: Array, period: float) -> Array:
    """Derivative of uniform samples by central differences, one-sided at the ends.

    values: (N, M); period: [s]. Returns (N, M); NaN where there are fewer than two samples.
    """
    if len(values) < 2:
        return np.full_like(values, np.nan)
    return np.gradient(values, period, axis=0)
