"""The slow part of the external torque: what friction and model leave, drifting along."""

from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dposv

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.rts import rts_pass


class Smoothed(NamedTuple):
    """Mean (N, 6) and covariance (N, 6, 6) of a signal, given all of its measurements."""

    mean: Array
    covariance: Array


def smooth(measured: Array, noise: Array, spread: Array, decay: Array) -> Smoothed:
    """Kalman filter and Rauch-Tung-Striebel smoother of an Ornstein-Uhlenbeck process.

    b(t) = A b(t - 1) + w, A = diag(decay), cov w = sqrt(1 - A²) Q sqrt(1 - A²); measured = b + v.
    measured: (N, 6), NaN rows where nothing was; noise: (N, 6, 6), of v; spread: (N, 6, 6), Q,
    the variance without measurements; decay: (N, 6), of the step towards each sample.
    """
    before, after = _filter(measured, noise, spread, decay)
    cross = decay[1:, :, None] * after.covariance[:-1]
    return Smoothed(*rts_pass(cross, before, after))


def _filter(
    measured: Array, noise: Array, spread: Array, decay: Array
) -> tuple[Smoothed, Smoothed]:
    """Predicted before, and corrected after each measurement."""
    known = finite_rows(measured)
    renewal = np.sqrt(1 - decay**2)
    renewed = renewal[:, :, None] * spread * renewal[:, None, :]
    kept = decay[:, :, None] * decay[:, None, :]
    before = Smoothed(np.empty_like(decay), np.empty_like(spread))
    after = Smoothed(np.empty_like(decay), np.empty_like(spread))
    mean, covariance = np.zeros(6), spread[0]
    for t in range(len(measured)):
        if t:
            mean, covariance = decay[t] * mean, kept[t] * covariance + renewed[t]
        before.mean[t], before.covariance[t] = mean, covariance
        if known[t]:
            _, seen, _ = dposv(covariance + noise[t], covariance)  # a quarter of solve's time
            gain = seen.T
            mean = mean + gain @ (measured[t] - mean)
            covariance = covariance - gain @ covariance
        after.mean[t], after.covariance[t] = mean, covariance
    return before, after
