"""The background: the slowly varying part of the external torque, from friction and model.

It is an Ornstein-Uhlenbeck process b, and friction that is stronger or weaker in this run than in
those of the fit by one factor for each joint: u = b + diag(f) s.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dposv

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.kalman import Gaussians, rts_pass


class Filtered(NamedTuple):
    """States of a filter before and after each measurement, and the normal equations of s.

    Means are (N, n + 1, n): of the measured torque, and of each joint's friction f in its place.
    squares: Σ E V⁻¹ Eᵀ (n + 1, n + 1) over the innovations E (n + 1, n), with V their covariance.
    """

    before: Gaussians
    after: Gaussians
    squares: Array


def smooth(
    measured: Array, noise: Array, spread: Array, decay: Array, friction: Array, scale_std: float
) -> Gaussians:
    """Smooth u = b + diag(f) s by a Kalman filter and Rauch, Tung and Striebel's pass.

    b(t) = A b(t - 1) + w, A = diag(decay), cov w = sqrt(1 - A²) Q sqrt(1 - A²); measured = u + v.
    measured: (N, n), NaN rows where nothing was measured; noise: cov v (N, n, n); spread: Q
    (N, n, n), the stationary covariance; decay: (N, n), over the step towards each sample;
    friction: f (N, n) [Nm]; scale_std: prior standard deviation of each of s. Since the filter is
    linear, it passes the measurements and each joint's f on their own, and s is the regression of
    the innovations of the first on those of the others [de Jong 1991].
    """
    before, after, squares = _filter(measured, noise, spread, decay, friction)
    # s = (E_f V⁻¹ E_fᵀ + 1 / σ²)⁻¹ E_f V⁻¹ e
    every = np.eye(measured.shape[1])
    doubt = np.linalg.inv(squares[1:, 1:] + every / scale_std**2)
    scale = doubt @ squares[1:, 0]
    # cov(b(t), b(t - 1)) = A P(t - 1)
    cross = decay[1:, None, :, None] * after.covariance[:-1]  # (N - 1, 1, n, n)
    own = rts_pass(cross, before.at(slice(1, None)), after.at(slice(-1)), after.at(-1))
    # u = b(measured) + (f - b(f)) s, and the covariance likewise
    apart = friction[:, :, None] * every - own.mean[:, 1:].mT  # (N, n, n)
    return Gaussians(
        own.mean[:, 0] + apart @ scale, own.covariance[:, 0] + apart @ doubt @ apart.mT
    )


def _filter(
    measured: Array, noise: Array, spread: Array, decay: Array, friction: Array
) -> Filtered:
    """Pass the measurements, and each joint's friction; arguments as above."""
    known, joints = finite_rows(measured), measured.shape[1]
    frictions = friction[:, None] * np.eye(joints)
    inputs = np.concatenate([measured[:, None], frictions], axis=1)  # (N, n + 1, n)
    # covariance and means are rows of one state (2 n + 1, n), so that a step is one product
    given = np.concatenate([np.zeros_like(spread), inputs], axis=1)  # (N, 2 n + 1, n)
    # prediction: P⁻ = A P A + cov w, cov w = sqrt(1 - A²) Q sqrt(1 - A²);  b⁻ = A b
    renewal = np.sqrt(1 - decay**2)
    decays = np.repeat(decay[:, None], joints + 1, axis=1)
    kept = np.concatenate([decay[:, :, None] * decay[:, None, :], decays], axis=1)
    renewed = np.zeros_like(given)
    renewed[:, :joints] = renewal[:, :, None] * spread * renewal[:, None, :]
    kept[0], renewed[0, :joints] = 0.0, spread[0]
    before, after = np.empty_like(given), np.empty_like(given)
    state, squares = np.zeros(given.shape[1:]), np.zeros((joints + 1, joints + 1))
    for t in range(len(measured)):
        state = before[t] = kept[t] * state + renewed[t]
        # correction: V = P⁻ + cov v, E = measured - b⁻, b = b⁻ + E V⁻¹ P⁻, P = P⁻ - P⁻ V⁻¹ P⁻
        if known[t]:
            lead = state - given[t]  # P⁻ and -E
            # dposv takes a quarter of the time of np.linalg.solve
            _, solved, _ = dposv(lead[:joints] + noise[t], lead.T)  # V⁻¹ P⁻ and -V⁻¹ Eᵀ
            squares += lead[joints:] @ solved[:, joints:]
            state = state - lead @ solved[:, :joints]
        after[t] = state
    return Filtered(_gaussians(before), _gaussians(after), squares)


def _gaussians(state: Array) -> Gaussians:
    """Return means (N, n + 1, n) and covariances (N, 1, n, n) of states (N, 2 n + 1, n)."""
    joints = state.shape[2]
    return Gaussians(state[:, joints:], state[:, None, :joints])
