"""Robust linear regression of correlated samples, with a prior."""

from dataclasses import dataclass

import numpy as np

from ur5lib.timeseries.arrays import Array, Labels

HUBER = 1.345  # standard deviations; 95 % efficient where errors are normal (Huber 1964)
ROUNDS = 10


@dataclass(frozen=True)
class Normal:
    """Normal prior of coefficients: mean (P,) and precision (P, P), the inverse covariance."""

    mean: Array
    precision: Array


@dataclass(frozen=True)
class Regression:
    """Result of a regression: coefficients (P,); Huber's weight of each sample (n,); noise, the
    variance of a sample, inflated for the correlation within blocks.
    """

    coefficients: Array
    weight: Array
    noise: float


def regress(columns: Array, target: Array, block: Labels, prior: Normal) -> Regression:
    """Compute Huber's M-estimate with a prior, by reweighted least squares.

    columns: X (n, P); target: y (n,); block: (n,) labels of samples with correlated errors.
    Without samples, the result is the prior's mean.
    """
    weight, noise = np.ones(len(target)), _positive(float(target @ target) / max(1, len(target)))
    coefficients = prior.mean
    for _ in range(ROUNDS if len(target) else 0):
        # (Xᵀ W X / σ² + Λ) β = Xᵀ W y / σ² + Λ β₀
        information = columns.T @ (columns * weight[:, None]) / noise  # (P, P)
        right = columns.T @ (target * weight) / noise  # (P,)
        coefficients = posterior_mean(information, right, prior)
        # W and σ² from the residuals
        residual = target - columns @ coefficients
        weight = huber_weight(residual)
        noise = _positive(noise_of_one(weight * residual, block))
    return Regression(coefficients, weight, noise)


def posterior_mean(information: Array, right: Array, prior: Normal) -> Array:
    """Solve normal equations (..., P, P), (..., P) together with a prior: (..., P).

    The prior's mean may be (..., P) too.
    """
    total = right + prior.mean @ prior.precision
    solution = np.linalg.solve(information + prior.precision, total[..., None])[..., 0]
    return np.asarray(solution, dtype=np.float64)


def huber_weight(residual: Array) -> Array:
    """Return Huber's weights (n,) of residuals (n,), scaled by their median absolute deviation."""
    scale = _positive(1.4826 * float(np.median(np.abs(residual))))
    return np.minimum(1.0, HUBER * scale / np.maximum(np.abs(residual), scale))


def noise_of_one(residual: Array, block: Labels) -> float:
    """Return the variance of independent samples whose block sums vary as much as these do."""
    return float(np.sum(np.bincount(block, residual) ** 2) / len(residual))


def _positive(variance: float) -> float:
    return max(variance, 1e-12)
