"""Robust linear regression of correlated samples with a prior, and its bootstrap.

Samples of a recording share its temperature and posture, so the bootstrap draws whole recordings
with replacement. A few recordings determine a spread badly, so blocks within them are drawn too,
and the larger of both spreads counts.
"""

from dataclasses import dataclass

import numpy as np
from scipy.special import ndtr, stdtrit

from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.metrics import NORMAL95, STD_PER_MAD

HUBER_LIMIT = 1.345  # standard deviations; 95 % efficient where errors are normal (Huber 1964)
REWEIGHTING_ROUNDS = 10
USUAL_NOISE_BLOCKS = 3.0  # the expected noise counts as this many blocks of the data
REPLICATE_COUNT = 500  # replicates of the bootstrap


@dataclass(frozen=True)
class Normal:
    """A normal distribution of coefficients, as a prior: mean (P,) and precision (P, P), the
    inverse covariance.
    """

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


def regress(
    columns: Array, target: Array, block: Labels, prior: Normal, expected_noise: float = np.nan
) -> Regression:
    """Return Huber's M-estimate with a prior, by reweighted least squares.

    columns: X (n, P); target: y (n,); block: (n,) labels of samples with correlated errors;
    expected_noise: see `noise_of_one`. Without samples, the result is the prior's mean.
    """
    weight, noise = np.ones(len(target)), _positive(float(target @ target) / max(1, len(target)))
    coefficients, blocks = prior.mean, int(np.count_nonzero(np.bincount(block)))
    joined = np.column_stack([columns, target])
    alike = columns.T @ joined  # Xᵀ X, Xᵀ y of all samples, of which outliers count less
    for _ in range(REWEIGHTING_ROUNDS if len(target) else 0):
        outlier = np.flatnonzero(weight < 1.0)
        far = joined.take(outlier, axis=0)
        sums = (alike - (far[:, :-1].T * (1 - weight[outlier])) @ far) / noise
        # (Xᵀ W X / σ² + Λ) β = Xᵀ W y / σ² + Λ β₀
        coefficients = posterior_mean(sums[:, :-1], sums[:, -1], prior)
        # W and σ² from the residuals
        residual = target - columns @ coefficients
        weight = huber_weight(residual)
        noise = _positive(noise_of_one(weight * residual, block, blocks, expected_noise))
    return Regression(coefficients, weight, noise)


def posterior_mean(information: Array, right: Array, prior: Normal) -> Array:
    """Return the solution (..., P) of normal equations together with a prior.

    information: (..., P, P); right: (..., P); the prior's mean may be (..., P), too.
    """
    total = right + prior.mean @ prior.precision
    solution = np.linalg.solve(information + prior.precision, total[..., None])[..., 0]
    return np.asarray(solution, dtype=np.float64)


def huber_weight(residual: Array) -> Array:
    """Return Huber's weights (n,) of residuals (n,), scaled by their median absolute deviation."""
    size = np.abs(residual)
    scale = _positive(STD_PER_MAD * _median(size))
    return np.minimum(1.0, HUBER_LIMIT * scale / np.maximum(size, scale))


def _median(values: Array) -> float:
    """Return the median of values (n,) without NaN; np.median takes up to six times as long."""
    middle = len(values) // 2
    upper = np.partition(values, middle)
    lower = upper[middle] if len(values) % 2 else upper[:middle].max()
    return float(lower + upper[middle]) / 2


def noise_of_one(residual: Array, block: Labels, blocks: int, expected: float = np.nan) -> float:
    """Return the variance that samples would have if independent, so that sums over blocks vary as
    they do.

    σ² = Σ (block sum)² / n. As a fit of P coefficients leaves P blocks without residual, an
    expected variance counts as USUAL_NOISE_BLOCKS further blocks of mean length; NaN for none.
    """
    squares, count = float(np.sum(np.bincount(block, residual) ** 2)), float(len(residual))
    if np.isfinite(expected):
        further = USUAL_NOISE_BLOCKS * count / max(1, blocks)
        squares, count = squares + further * expected, count + further
    return squares / count


def _positive(variance: float) -> float:
    return max(variance, 1e-12)


def block_sums(columns: Array, curvature: Array, pull: Array, block: Labels, count: int) -> Array:
    """Return the normal equations of each block, (count, P, P + 1): matrix, then right side.

    columns: x (n, P); curvature, pull: c, p (n,), so that a sample adds c x xᵀ and p x; block: (n,)
    labels 0 to count - 1.
    """
    sides = np.column_stack([columns * curvature[:, None], pull])
    sums = [np.bincount(block, x * side, count) for x in columns.T for side in sides.T]
    entries = np.stack(sums, axis=1, dtype=np.float64)
    return entries.reshape(count, columns.shape[1], sides.shape[1])


def draw_units(unit_of_block: Labels, generator: np.random.Generator) -> Array:
    """Return how often each block occurs in draws of whole units with replacement,
    (REPLICATE_COUNT, n).

    unit_of_block: (n,) labels of recordings, or of longer parts of one; negative: never drawn.
    """
    units, place = np.unique(unit_of_block, return_inverse=True)
    is_unit = units >= 0
    counts = np.zeros((REPLICATE_COUNT, len(units)))
    counts[:, is_unit] = _draw(int(is_unit.sum()), generator)
    return counts[:, place]


def draw_blocks(unit_of_block: Labels, generator: np.random.Generator) -> Array:
    """Return how often each block occurs in draws of blocks within each unit with replacement,
    (REPLICATE_COUNT, n).
    """
    counts = np.zeros((REPLICATE_COUNT, len(unit_of_block)))
    for unit in np.unique(unit_of_block[unit_of_block >= 0]):
        in_unit = unit_of_block == unit
        counts[:, in_unit] = _draw(int(in_unit.sum()), generator)
    return counts


def standard_error(by_unit: Array, by_block: Array, units: int) -> Array:
    """Return the standard errors (P,): the larger spread of replicates (B, P) by unit and by block.

    The factor sqrt(n / (n - 1)) corrects the bias of a bootstrap over n units, if they are few.
    """
    return np.maximum(spread(by_unit) * np.sqrt(units / max(1, units - 1)), spread(by_block))


def _draw(count: int, generator: np.random.Generator) -> Array:
    """Return how often each of `count` items occurs in draws with replacement, (REPLICATE_COUNT,
    count).
    """
    if not count:
        return np.zeros((REPLICATE_COUNT, 0))
    return generator.multinomial(count, np.full(count, 1 / count), size=REPLICATE_COUNT).astype(
        float
    )


def spread(replicates: Array) -> Array:
    """Return half the width of the central 68 % of replicates (B, ...): a standard deviation that
    ignores the tails.
    """
    low, high = np.quantile(replicates, ndtr([-1.0, 1.0]), axis=0)
    return (high - low) / 2


def half_width(error: Array, units: int, prior_share: Array | float = 0.0) -> Array:
    """Return the half-width (P,) of the 95 % interval, by Student's t with units - 1 degrees of
    freedom.

    prior_share: (P,), share of the variance from the prior, which has a normal quantile.
    """
    estimated = stdtrit(max(1, units - 1), 0.975)
    share = np.clip(prior_share, 0.0, 1.0)
    half: Array = error * np.sqrt(share * NORMAL95**2 + (1 - share) * estimated**2)
    return half
