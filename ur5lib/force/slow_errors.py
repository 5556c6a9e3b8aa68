"""Standard errors of a regression whose errors are partly slow.

The mean error of a block of samples is s (√(1-g) white + √g slow), where the slow part is an
autoregression of first order: its correlation at a distance of k blocks is ρᵏ.
"""

import numpy as np

from ur5lib.timeseries.arrays import Array

BLOCKS = 100  # many more than terms, however short the recording: else nothing tells the error
SLOW = np.exp(-1 / np.geomspace(1, 2 * BLOCKS, 7))  # ρ, all equally likely a priori
SHARES = np.array([0.0, 0.25, 0.5, 0.75, 0.9, 0.97, 1.0])  # g, likewise
DEPENDENT = 1e-6  # singular value, relative to the largest, below which terms are no others


def slow_covariance(
    terms: Array, residual: Array, time: Array, weight: float, known: Array
) -> Array:
    """Return the covariance (P, P) of θ = (w XᵀX + K)⁻¹ w Xᵀ y, whose errors may be slow.

    terms: X (N, P) of one component; residual: (N,), y - X θ; time: (N,) [s], increasing; weight:
    w; known: K, inverse variances (P,) of a prior about zero. With blocks of n samples, H = n w XᵀX
    + K and V the covariance of block means, it is H⁻¹ (n w)² Xᵀ V X H⁻¹ + H⁻¹ K H⁻¹.
    """
    share = (time - time[0]) / np.ptp(time)
    number = np.minimum(np.floor(BLOCKS * share), BLOCKS - 1)
    block, place, count = np.unique(number, return_inverse=True, return_counts=True)
    means = np.zeros((len(block), terms.shape[1] + 1))
    np.add.at(means, place, np.column_stack([terms, residual]))
    means /= count[:, None]
    X, left, scale = means[:, :-1], means[:, -1], count * weight
    inverse = np.linalg.pinv((X.T * scale) @ X + np.diag(known), hermitian=True)
    gain = inverse @ (X.T * scale)
    V = _expected(X, left, block)
    return np.asarray(gain @ V @ gain.T + inverse @ np.diag(known) @ inverse)


def _expected(X: Array, left: Array, block: Array) -> Array:
    """Return the covariance (M, M) of block means: the mean over ρ and g, weighted by likelihood.

    The likelihood is that of what the regression leaves (restricted, Harville 1974). A variance S/ν
    of ν degrees of freedom is expected as S/(ν-2).
    """
    vectors, values, _ = np.linalg.svd(X)
    rank = int((values > DEPENDENT * values[0]).sum())
    other = vectors[:, rank:]  # what X does not explain
    freedom = other.shape[1]
    seen, apart = other.T @ left, np.abs(block[:, None] - block)
    log, found = list[float](), list[Array]()
    for slow in SLOW:
        for share in SHARES:
            V = share * slow**apart + (1 - share) * np.eye(len(block))
            within = other.T @ V @ other
            S = max(float(seen @ np.linalg.solve(within, seen)), np.finfo(float).tiny)
            log.append(-np.linalg.slogdet(within)[1] / 2 - freedom / 2 * np.log(S))
            found.append(V * S / max(freedom - 2, 1))
    odds = np.exp(np.array(log) - max(log))
    return np.asarray(np.tensordot(odds / odds.sum(), np.stack(found), axes=1))
