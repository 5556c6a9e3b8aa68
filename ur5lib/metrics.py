"""How far an estimate is from its reference."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def mean_absolute_error(estimate: Array, reference: Array) -> Array:
    """MAE of each column, over the rows where both are finite (Equations 5.1, 6.12)."""
    return np.nanmean(np.abs(reference - estimate), axis=0)


def largest_error(estimate: Array, reference: Array) -> Array:
    """Largest absolute error of each column (Equation 6.13)."""
    return np.nanmax(np.abs(reference - estimate), axis=0)


def correlation(estimate: Array, reference: Array) -> Array:
    """Pearson correlation of each column, NaN where one of both is constant."""
    both = np.isfinite(estimate) & np.isfinite(reference)
    x = np.where(both, estimate, np.nan)
    y = np.where(both, reference, np.nan)
    x, y = x - np.nanmean(x, axis=0), y - np.nanmean(y, axis=0)
    scale = np.sqrt(np.nansum(x**2, axis=0) * np.nansum(y**2, axis=0))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.nansum(x * y, axis=0) / scale
