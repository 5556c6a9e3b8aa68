"""Regression of a force sensor's readings in the samples without contact, which it finds.

The model is reading (N, 6) = terms (N, 6, P) times parameters (P,), plus noise, but in contact.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import minimum_filter1d

from ur5lib.force.consensus import agreement, drawn
from ur5lib.timeseries.arrays import Array, Mask

Fit = tuple[Array, Mask, Array]  # parameters (P,), free samples (N,), their noise (6,)

ROUNDS = 20  # of fitting and excluding contacts; fewer suffice
OUTSIDE = 4.0  # standard deviations of a free reading: beyond, a sample is in contact
REPEATS = np.array([0.1] * 3 + [0.01] * 3)  # N, Nm: repeatability after a push
CLEAR = 0.25  # s, distance of a free sample from any contact
JUDGED = 2_000  # samples for the comparison of parameters


@dataclass(frozen=True)
class Record:
    """Readings (N, 6), their terms (N, 6, P), which are complete (N,), and their period [s].

    known: inverse variances (P,) of a prior about zero, 0 for none.
    """

    reading: Array
    terms: Array
    measured: Mask
    period: float
    known: Array | float = 0.0

    def agreement(self, parameters: Array, tolerance: Array) -> Mask:
        """Return which of J samples, drawn once, agree with each of the offsets (K, P): (K, J)."""
        rows = drawn(np.flatnonzero(self.measured), JUDGED)
        return agreement(parameters, self.terms[rows], self.reading[rows], tolerance)


def settle(record: Record, free: Mask, weight: Array) -> Fit:
    """Alternate the fit and the selection of free samples until the selection stays the same.

    Returns the parameters (P,), the free samples (N,), and their noise (6,), at least REPEATS.
    """
    for _ in range(ROUNDS):
        parameters, residual = fit(record, free, weight)
        # standard deviation by the median absolute deviation
        noise = np.maximum(1.4826 * np.median(np.abs(residual[free]), axis=0), REPEATS)
        quiet = free_samples(residual, noise, record.measured, record.period)
        if (quiet == free).all() or not quiet.any():
            break
        free, weight = quiet, np.ones(len(quiet))
    return parameters, free, noise


def free_samples(residual: Array, noise: Array, measured: Mask, period: float) -> Mask:
    """Return samples (N,) within 4 standard deviations and away from any that is not."""
    inside = (np.abs(residual) <= OUTSIDE * noise).all(axis=1) | ~measured
    reach = 2 * round(CLEAR / period) + 1
    return minimum_filter1d(inside, reach, mode="constant", cval=1) & measured


def least_deviations(record: Record) -> Array:
    """Return weights (N,) of least squares that minimise absolute deviations (Schlossmacher 1973).

    The fit is robust to contacts that fill less than half of the time.
    """
    weight = np.ones(len(record.reading))
    for _ in range(ROUNDS):
        _, residual = fit(record, record.measured, weight)
        weight = 1 / np.sqrt(np.maximum(np.linalg.norm(residual / REPEATS, axis=1), 1.0))
    return weight


def fit(record: Record, free: Mask, weight: Array) -> tuple[Array, Array]:
    """Fit the free samples by weighted least squares, forces and moments in units of REPEATS.

    Returns the parameters (P,) and the residuals of all readings (N, 6).
    """
    scale = weight[free, None] / REPEATS
    scaled = record.terms[free] * scale[..., None]
    rows = scaled.reshape(-1, scaled.shape[2])
    values = (record.reading[free] * scale).ravel()
    normal = rows.T @ rows + record.known * np.eye(rows.shape[1])
    parameters = np.linalg.pinv(normal, hermitian=True) @ (rows.T @ values)
    return parameters, record.reading - record.terms @ parameters


def covariance(terms: Array, residual: Array, noise: Array, known: Array | float = 0.0) -> Array:
    """Return the covariance (P, P) of the parameters: (Xᵀ X (1 - ρ) / (1 + ρ) + K)⁻¹.

    ρ is the correlation of neighbouring residuals, taken as a first-order autoregression; known: K,
    the inverse variances (P,) of a prior.
    """
    scale = np.maximum(noise, 1e-12)
    whitened = (terms / scale[:, None]).reshape(-1, terms.shape[2])
    correlation = 0.0
    if len(residual) > 1:
        correlation = (residual[1:] * residual[:-1]).mean() / (residual**2).mean()
    inflated = (1 + correlation) / max(1 - correlation, 1e-9)
    prior = inflated * known * np.eye(whitened.shape[1])
    return np.asarray(np.linalg.pinv(whitened.T @ whitened + prior) * inflated, np.float64)
