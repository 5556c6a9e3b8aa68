"""The background: the slowly varying part of the external torque, from friction and model.

It is u = b + diag(f) s: an Ornstein-Uhlenbeck process b, and an error of this run's friction f by a
factor s of each joint.
"""

import numpy as np
from scipy.linalg import cho_solve_banded, cholesky_banded

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.kalman import Gaussians


def smooth(
    measured: Array, noise: Array, spread: Array, decay: Array, friction: Array, scale_std: float
) -> Gaussians:
    """Return u = b + diag(f) s at N samples, given all measurements.

    b(t) = A b(t - 1) + w, A = diag(decay), cov w = (1 - A²) diag(Q); measured = u + v.
    measured: (N, n), NaN rows where nothing was measured; noise: cov v (N, n, n); spread: Q (N, n),
    the stationary variances; decay: (N, n), over the step towards each sample; friction: f (N, n)
    [Nm]; scale_std: prior standard deviation of each of s. As b is linear in the measurements, they
    and each joint's f are smoothed separately; s is the regression of the first residual on the
    others [de Jong 1991].
    The inverse covariance Λ of b at all samples is block tridiagonal, and its Cholesky factor
    banded: b = Λ⁻¹ R⁻¹ y, R = cov v, y the measurements. LAPACK solves it faster than a loop over
    samples filters them.
    """
    joints = measured.shape[1]
    identity = np.eye(joints)
    measured_rows = finite_rows(measured)[:, None, None]
    inputs = np.concatenate([measured[:, :, None], friction[:, :, None] * identity], axis=2)
    inputs = np.where(measured_rows, inputs, 0.0)  # (N, n, n + 1)
    # R⁻¹, and 0 where nothing was measured
    weight = np.where(measured_rows, np.linalg.inv(noise), 0.0)
    weighted = weight @ inputs
    diagonal, off_diagonal = _precision(weight, spread, decay)
    factor = _factor(diagonal, off_diagonal)
    solution = cho_solve_banded((factor, True), weighted.reshape(-1, joints + 1))
    solution = solution.reshape(inputs.shape)
    # s = (E_f V⁻¹ E_fᵀ + 1 / σ²)⁻¹ E_f V⁻¹ e, of innovations: Y V⁻¹ Yᵀ = Y R⁻¹ (Y - b)
    squares = np.tensordot(weighted, inputs - solution, axes=((0, 1), (0, 1)))
    scale_covariance = np.linalg.inv(squares[1:, 1:] + identity / scale_std**2)
    scale = scale_covariance @ squares[1:, 0]
    # u = b(measured) + (f - b(f)) s, and the covariance likewise
    remaining_friction = friction[:, :, None] * identity - solution[:, :, 1:]  # (N, n, n)
    covariance = _covariance(diagonal, off_diagonal, factor)
    return Gaussians(
        solution[:, :, 0] + remaining_friction @ scale,
        covariance + remaining_friction @ scale_covariance @ remaining_friction.mT,
    )


def _precision(weight: Array, spread: Array, decay: Array) -> tuple[Array, Array]:
    """Return the inverse covariance of b at all samples, as its diagonal blocks Λ(t, t) (N, n, n)
    and the diagonals (N, n) of Λ(t, t - 1), of which the first has no meaning; weight: R⁻¹.
    """
    # V = (cov w)⁻¹;  Λ(t, t) = V(t) + A(t + 1) V(t + 1) A(t + 1) + R⁻¹(t), Λ(t, t - 1) = -V(t) A(t)
    renewal = 1 - decay**2
    renewal[0] = 1.0
    information = 1 / (renewal * spread)
    off_diagonal = -information * decay
    information[:-1] -= decay[1:] * off_diagonal[1:]
    return weight + information[:, :, None] * np.eye(spread.shape[1]), off_diagonal


def _covariance(diagonal: Array, off_diagonal: Array, factor: Array) -> Array:
    """Return the covariances (N, n, n) of b at each sample; factor: by `_factor`.

    The inverse covariance at a sample is the past's information plus the future's, minus Λ(t, t),
    which both contain.
    """
    # from the last sample to the first, the past is the future
    following = np.roll(off_diagonal, -1, axis=0)
    reverse = _factor(diagonal[::-1, ::-1, ::-1], following[::-1, ::-1])
    past, future = (_diagonal_products(half, diagonal.shape[1]) for half in (factor, reverse))
    return np.asarray(np.linalg.inv(past + future[::-1, ::-1, ::-1] - diagonal), np.float64)


def _factor(diagonal: Array, off_diagonal: Array) -> Array:
    """Return the lower bands (n + 1, N n) of a block tridiagonal matrix's Cholesky factor."""
    count, joints, _ = diagonal.shape
    bands = np.zeros((joints + 1, count, joints))
    row, column = np.tril_indices(joints)
    bands[row - column, :, column] = diagonal[:, row, column].T
    bands[joints, :-1] = off_diagonal[1:]
    return np.asarray(cholesky_banded(bands.reshape(joints + 1, -1), True, lower=True))


def _diagonal_products(factor: Array, joints: int) -> Array:
    """Return L(t, t) L(t, t)ᵀ (N, n, n) of a factor's diagonal blocks.

    It is the inverse covariance of b at a sample, given the samples up to it.
    """
    bands = factor.reshape(len(factor), -1, joints)
    lower = np.zeros((bands.shape[1], joints, joints))
    row, column = np.tril_indices(joints)
    lower[:, row, column] = bands[row - column, :, column].T
    return lower @ lower.mT
