"""The drift of a force sensor's bias within a run, and standard errors under slow errors.

The mean error of a block of samples is s (√(1-g) white + √g slow), where the slow part is an
autoregression of first order with a correlation of ρᵏ at a distance of k blocks.
"""

import numpy as np

from ur5lib.force.external_torque import finite_rows
from ur5lib.force.sensed_contact import is_free
from ur5lib.timeseries.arrays import Array

SECONDS_PER_MINUTE = 60.0
DRIFT_ROUNDS = 3  # contact-free samples and the drift are found in turn, this many times
MIN_FREE_DURATION = 5.0  # s; with less time without contact, no drift is stated
MAX_DRIFT_SAMPLES = 5_000  # a fit uses at most this many
# Many more blocks than terms, however short the recording: otherwise the error is undetermined.
ERROR_BLOCKS = 100
# Correlations ρ of neighbouring blocks, and shares g of the slow part, all equally likely a priori.
BLOCK_CORRELATIONS = np.exp(-1 / np.geomspace(1, 2 * ERROR_BLOCKS, 7))
SLOW_SHARES = np.array([0.0, 0.25, 0.5, 0.75, 0.9, 0.97, 1.0])
RANK_TOLERANCE = 1e-6  # smaller singular values, relative to the largest, count as zero


def force_drift(residual: Array, pull: Array, time: Array, period: float) -> tuple[Array, Array]:
    """Return the drift d (3,) of a sensor's forces [N/min], and its standard error.

    r = M p + b + d t without contact. residual: r (N, 3) [N], the reading less bias, weight and
    inertia of the tool; pull: p (N, 3) [m/s²], acceleration that acts on the tool, whose mass may
    err; time: (N,) [s]; period: [s]. NaN where there is too little time without contact.
    """
    minutes = (time - time[0]) / SECONDS_PER_MINUTE
    terms = np.column_stack([pull, np.ones(len(pull)), minutes])
    known, solution = finite_rows(residual) & finite_rows(pull), np.zeros((5, 3))
    for _ in range(DRIFT_ROUNDS):
        size = np.linalg.norm(residual - terms @ solution, axis=1)
        free = np.flatnonzero(known & is_free(size, period))
        if len(free) * period < MIN_FREE_DURATION:
            return np.full(3, np.nan), np.full(3, np.nan)
        free = free[:: -(-len(free) // MAX_DRIFT_SAMPLES)]
        solution = np.linalg.lstsq(terms[free], residual[free], rcond=None)[0]
    left = residual[free] - terms[free] @ solution
    covariances = [
        slow_covariance(terms[free], own, time[free], 1.0, np.zeros(5)) for own in left.T
    ]
    return solution[-1], np.sqrt([covariance[-1, -1] for covariance in covariances])


def slow_covariance(
    terms: Array, residual: Array, time: Array, weight: float, prior_precision: Array
) -> Array:
    """Return the covariance (P, P) of θ = (w XᵀX + K)⁻¹ w Xᵀ y under errors that may be slow.

    terms: X (N, P) of one component; residual: (N,), y - X θ; time: (N,) [s], increasing; weight:
    w; prior_precision: K, inverse variances (P,) of a prior about zero. With blocks of n samples, H
    = n w XᵀX + K and V the covariance of block means, it is H⁻¹ (n w)² Xᵀ V X H⁻¹ + H⁻¹ K H⁻¹.
    """
    share = (time - time[0]) / np.ptp(time)
    number = np.minimum(np.floor(ERROR_BLOCKS * share), ERROR_BLOCKS - 1)
    block, place, count = np.unique(number, return_inverse=True, return_counts=True)
    means = np.zeros((len(block), terms.shape[1] + 1))
    np.add.at(means, place, np.column_stack([terms, residual]))
    means /= count[:, None]
    X, block_residual, scale = means[:, :-1], means[:, -1], count * weight
    # H⁻¹ and H⁻¹ n w Xᵀ
    inverse = np.linalg.pinv((X.T * scale) @ X + np.diag(prior_precision), hermitian=True)
    gain = inverse @ (X.T * scale)
    V = _block_covariance(X, block_residual, block)
    return np.asarray(gain @ V @ gain.T + inverse @ np.diag(prior_precision) @ inverse)


def _block_covariance(X: Array, block_residual: Array, block: Array) -> Array:
    """Return the covariance (M, M) of the errors of block means: the mean over ρ and g, weighted by
    likelihood.

    The likelihood is restricted: that of the regression's residuals (Harville 1974). A variance
    with a sum of squares S and ν degrees of freedom is expected as S/(ν-2). A bootstrap of blocks
    contains no error slower than a block: where errors last for 20 s, its intervals covered bias
    and drift in 71 and 78 % of 96 cases at best, these in 96 and 90 %.
    """
    vectors, values, _ = np.linalg.svd(X)
    rank = int((values > RANK_TOLERANCE * values[0]).sum())
    complement = vectors[:, rank:]  # what X does not explain
    freedom = complement.shape[1]
    projected, distance = complement.T @ block_residual, np.abs(block[:, None] - block)
    log_likelihoods, covariances = list[float](), list[Array]()
    for slow in BLOCK_CORRELATIONS:
        for share in SLOW_SHARES:
            V = share * slow**distance + (1 - share) * np.eye(len(block))
            within = complement.T @ V @ complement
            # S = eᵀ V⁻¹ e; p ∝ |V|^(-1/2) S^(-ν/2)
            S = max(float(projected @ np.linalg.solve(within, projected)), np.finfo(float).tiny)
            log_likelihoods.append(-np.linalg.slogdet(within)[1] / 2 - freedom / 2 * np.log(S))
            covariances.append(V * S / max(freedom - 2, 1))
    # Σ p V S / (ν - 2) / Σ p
    odds = np.exp(np.array(log_likelihoods) - max(log_likelihoods))
    return np.asarray(np.tensordot(odds / odds.sum(), np.stack(covariances), axes=1))
