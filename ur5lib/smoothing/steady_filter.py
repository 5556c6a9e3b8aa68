"""The steady state of a time-invariant system's Kalman filter, and its innovations."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from scipy.signal import lfilter

from ur5lib.timeseries.arrays import Array

MAX_DOUBLINGS = 60
CONVERGENCE_TOLERANCE = 1e-12  # at this relative change of P, doublings end


class SteadyFilter(NamedTuple):
    """The transfer function from measurements z to innovations e = z − H x⁻, x⁺ = F x⁻ + K e.

    zeros: (..., M, M, X + 1), the numerators of each innovation (first) by each measurement
    (second); poles: (..., X + 1), their common denominator; S: (..., M, M), covariance of e.
    """

    poles: Array
    zeros: Array
    S: Array

    def each(self) -> Iterator["SteadyFilter"]:
        """Yield the filters of a stack, one after the other."""
        return map(SteadyFilter._make, zip(*self, strict=True))

    def innovations(self, z: Array) -> Array:
        """Return one filter's innovations (N, M) of measurements z (N, M), from a state of zero."""
        channels = [
            sum(lfilter(zeros, self.poles, column) for zeros, column in zip(row, z.T, strict=True))
            for row in self.zeros
        ]
        return np.stack(channels, axis=1)


def steady_filter(F: Array, Q: Array, H: Array, R: Array) -> SteadyFilter:
    """Return the steady filter of x⁺ = F x + w, z = H x + v, or a stack of filters.

    F, Q: (..., X, X); H: (..., M, X); R: (..., M, M).
    """
    P = _prediction_covariance(F, Q, H.mT @ np.linalg.solve(R, H))
    S = H @ P @ H.mT + R
    K = np.linalg.solve(S, H @ P @ F.mT).mT
    # e = (1 − H (z − A)⁻¹ K) z with A = F − K H; one channel of it by the matrix determinant lemma:
    # 1 − h (z − A)⁻¹ k = det(z − A − k h) / det(z − A)
    A = (F - K @ H)[..., None, None, :, :]
    changed = A + K.mT[..., None, :, :, None] * H[..., :, None, None, :]
    poles, zeros = _polynomials(A), _polynomials(changed)
    zeros = zeros - (1 - np.eye(H.shape[-2]))[..., None] * poles
    return SteadyFilter(poles[..., 0, 0, :], zeros, S)


def _prediction_covariance(F: Array, Q: Array, G: Array) -> Array:
    """Solve P = F P (1 + G P)⁻¹ Fᵀ + Q, G = Hᵀ R⁻¹ H.

    By doubling: each round covers twice the time of the previous one (Chu, Fan, Lin and Wang:
    Structure-preserving algorithms for periodic discrete-time algebraic Riccati equations,
    International Journal of Control 77 (2004)).
    """
    A, P, eye = F.mT, Q, np.eye(F.shape[-1])
    for _ in range(MAX_DOUBLINGS):
        W = np.linalg.inv(eye + G @ P)
        AW = A @ W
        gained = A.mT @ (P @ W) @ A
        A, G, P = AW @ A, _symmetric(G + AW @ G @ A.mT), _symmetric(P + gained)
        if (_largest(gained) <= CONVERGENCE_TOLERANCE * _largest(P)).all():
            break
    return P


def _symmetric(matrices: Array) -> Array:
    return (matrices + matrices.mT) / 2


def _largest(matrices: Array) -> Array:
    return np.abs(matrices).max(axis=(-2, -1))


def _polynomials(A: Array) -> Array:
    """Return the characteristic polynomials (..., X + 1) of matrices (..., X, X)."""
    roots = np.linalg.eigvals(A)
    polynomials = np.zeros((*roots.shape[:-1], roots.shape[-1] + 1), roots.dtype)
    polynomials[..., 0] = 1
    for root in np.moveaxis(roots, -1, 0):
        polynomials[..., 1:] -= root[..., None] * polynomials[..., :-1]
    return polynomials.real
