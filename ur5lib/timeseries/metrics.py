"""Error measures of an estimate against its reference."""

import numpy as np
import scipy  # loads scipy.special at its first use

from ur5lib.timeseries.arrays import Array

BAND_COVERAGE = 0.95  # nominal coverage of a band
NORMAL95 = 1.96  # this many standard deviations to either side of the mean contain 95 %
STD_PER_MAD = 1.4826  # a normal value's standard deviation over its median absolute deviation


def mean_absolute_error(estimate: Array, reference: Array) -> Array:
    """Return the MAE of each column, over the rows where both are finite (Equations 5.1, 6.12)."""
    return np.nanmean(np.abs(reference - estimate), axis=0)


def largest_error(estimate: Array, reference: Array) -> Array:
    """Return the largest absolute error of each column (Equation 6.13)."""
    return np.nanmax(np.abs(reference - estimate), axis=0)


def correlation(estimate: Array, reference: Array) -> Array:
    """Return the Pearson correlation of each column, NaN if either is constant."""
    finite = np.isfinite(estimate) & np.isfinite(reference)
    x = np.where(finite, estimate, np.nan)
    y = np.where(finite, reference, np.nan)
    x, y = x - np.nanmean(x, axis=0), y - np.nanmean(y, axis=0)
    scale = np.sqrt(np.nansum(x**2, axis=0) * np.nansum(y**2, axis=0))
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.nansum(x * y, axis=0) / scale


def skill(estimate: Array, reference: Array) -> Array:
    """Return 1 - MAE / MAE of zero of each column: 0 is no better than zero, 1 is perfect."""
    zero = mean_absolute_error(
        np.zeros_like(reference), np.where(np.isfinite(estimate), reference, np.nan)
    )
    with np.errstate(invalid="ignore", divide="ignore"):
        return 1 - mean_absolute_error(estimate, reference) / zero


def slope(estimate: Array, reference: Array) -> Array:
    """Return the slope Σ x y / Σ x² of each column of the estimate y over its reference x.

    An estimate of 0.8 times every force has a slope of 0.8.
    """
    x = np.where(np.isfinite(estimate), reference, np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        return np.nansum(x * estimate, axis=0) / np.nansum(x**2, axis=0)


def coverage(estimate: Array, std: Array, reference: Array, stated: float = 0.95) -> Array:
    """Return the share of each column's references in the interval of nominal coverage `stated`."""
    band = scipy.special.ndtri(0.5 + stated / 2) * std
    finite = np.isfinite(estimate) & np.isfinite(std) & np.isfinite(reference)
    inside = finite & (np.abs(reference - estimate) <= band)
    return inside.sum(axis=0) / finite.sum(axis=0)


def band_factor(estimate: Array, std: Array, reference: Array) -> Array:
    """Return the factor on each column's 95 % interval with which it would contain 95 % of
    references.

    Below 1, the interval is too wide.
    """
    band = NORMAL95 * np.where(std > 0, std, np.nan)
    return finite_quantile(np.abs(reference - estimate) / band, BAND_COVERAGE)


def finite_quantile(values: Array, share: float) -> Array:
    """Return the quantile of each column's finite values, NaN where it has none."""
    columns = [column[np.isfinite(column)] for column in values.T]
    return np.array([np.quantile(own, share) if len(own) else np.nan for own in columns])


def interval_scores(estimate: Array, std: Array, reference: Array) -> Array:
    """Return the Winkler score (N, K) of each value's 95 % band: width + 2 / 0.05 times misses.

    Lower is better; a band that is too wide or too narrow scores worse (Gneiting and
    Raftery 2007, Equation 43).
    """
    half = NORMAL95 * std
    # width + 2 / α times what lies outside, α = 0.05
    missed = np.maximum(np.abs(reference - estimate) - half, 0.0)
    return 2 * half + 2 / 0.05 * missed


def interval_score(estimate: Array, std: Array, reference: Array) -> Array:
    """Return the mean of `interval_scores` of each column."""
    return np.nanmean(interval_scores(estimate, std, reference), axis=0)


def zero_interval_score(reference: Array) -> Array:
    """Return the interval score of the interval about zero that contains 95 % of the references."""
    half = np.nanquantile(np.abs(reference), 0.95, axis=0)
    return interval_score(np.zeros_like(reference), half / NORMAL95, reference)
