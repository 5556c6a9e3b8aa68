"""Robust linear regression of correlated samples, with a prior."""

from dataclasses import dataclass

import numpy as np

from ur5lib.timeseries.arrays import Array, Labels

HUBER = 1.345  # standard deviations; 95 % as efficient as least squares on Gaussian noise
ROUNDS = 10


@dataclass(frozen=True)
class Normal:
    """What is known of coefficients beforehand: mean (P,), and precision (P, P), its covariance's
    inverse.
    """

    mean: Array
    precision: Array


@dataclass(frozen=True)
class Regression:
    """Coefficients (P,); Huber's weight of each sample (n,); and a sample's variance, in which the
    correlation of its neighbours is counted.
    """

    coefficients: Array
    weight: Array
    noise: float


def regress(columns: Array, target: Array, block: Labels, prior: Normal) -> Regression:
    """Huber's M-estimate with a prior, by reweighted least squares.

    columns: (n, P); target: (n,); block: (n,) labels of samples that belong together.
    Where there are no samples, the prior stands.
    """
    weight, noise = np.ones(len(target)), _positive(float(target @ target) / max(1, len(target)))
    coefficients = prior.mean
    for _ in range(ROUNDS if len(target) else 0):
        information = columns.T @ (columns * weight[:, None]) / noise
        right = columns.T @ (target * weight) / noise
        coefficients = posterior_mean(information, right, prior)
        residual = target - columns @ coefficients
        weight = huber_weight(residual)
        noise = _positive(noise_of_one(weight * residual, block))
    return Regression(coefficients, weight, noise)


def posterior_mean(information: Array, right: Array, prior: Normal) -> Array:
    """Solution (..., P) of normal equations (..., P, P), (..., P) and a prior together.

    The prior's mean may be (..., P) too.
    """
    total = right + prior.mean @ prior.precision
    solution = np.linalg.solve(information + prior.precision, total[..., None])[..., 0]
    return np.asarray(solution, dtype=np.float64)


def huber_weight(residual: Array) -> Array:
    """Weights (n,) of residuals (n,), by their median absolute deviation."""
    scale = _positive(1.4826 * float(np.median(np.abs(residual))))
    return np.minimum(1.0, HUBER * scale / np.maximum(np.abs(residual), scale))


def noise_of_one(residual: Array, block: Labels) -> float:
    """Variance that independent samples would need to sum up as those of a block do."""
    return float(np.sum(np.bincount(block, residual) ** 2) / len(residual))


def _positive(variance: float) -> float:
    return max(variance, 1e-12)
