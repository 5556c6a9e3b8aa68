"""Tests of a filter's innovations: are they as large as it says, and white?"""

from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2

from ur5lib.timeseries.arrays import Array, Labels, Mask

LAGS = 10  # of the portmanteau test


@dataclass(frozen=True)
class InnovationTest:
    """Tests of normalised innovations: variance one, and whiteness.

    variance: (M,), mean squares; variance_limits: (M, 2), their 95 % interval; portmanteau: (M,),
    Ljung-Box statistic; portmanteau_limit: its 95 % point; consistent, white: (M,), whether the
    variance and the whiteness pass; colour: (M,), how many times larger the variance of a mean of
    successive innovations is than that of white ones, 1 + 2 Σ ρ over LAGS lags: at least 1, and 1
    for those that pass as white.
    """

    variance: Array
    variance_limits: Array
    portmanteau: Array
    portmanteau_limit: float
    consistent: Mask
    white: Mask
    colour: Array


def innovation_test(innovations: Array, segment: Labels) -> InnovationTest:
    """Test normalised innovations (N, M), NaN where nothing was measured.

    The mean square is compared with χ². The autocorrelations ρ over LAGS lags, within segments, are
    compared with those of white noise by the test of Ljung and Box.
    """
    count = np.isfinite(innovations).sum(axis=0)
    # one channel after the other, for the memory of long recordings
    variance = np.array([np.nanmean(channel**2) for channel in innovations.T])
    covariance = np.array([_autocovariance(channel, segment) for channel in innovations.T])
    correlation = covariance / variance[:, None]  # (M, LAGS)
    # Q = n (n + 2) Σ ρ² / (n - lag)
    lags = np.arange(1, LAGS + 1)
    portmanteau = count * (count + 2) * (correlation**2 / (count[:, None] - lags)).sum(axis=1)
    limit = float(chi2.ppf(0.95, LAGS))
    white = portmanteau <= limit
    colour = np.where(white, 1, np.maximum(1 + 2 * correlation.sum(axis=1), 1))
    limits = chi2.ppf([0.025, 0.975], count[:, None]) / count[:, None]
    consistent = (limits[:, 0] <= variance) & (variance <= limits[:, 1])
    return InnovationTest(variance, limits, portmanteau, limit, consistent, white, colour)


def _autocovariance(innovation: Array, segment: Labels) -> list[float]:
    """Return the mean products over 1 to LAGS lags, within segments, of one channel (N,)."""
    means = []
    for lag in range(1, LAGS + 1):
        within = segment[lag:] == segment[:-lag]
        means.append(float(np.nanmean((innovation[lag:] * innovation[:-lag])[within])))
    return means
