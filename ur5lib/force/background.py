"""The background: the slowly varying part of the external torque, from friction and model.

It is an Ornstein-Uhlenbeck process b, and friction that is stronger or weaker in this run than in
those of the fit by one factor for each joint: u = b + diag(f) s.
"""

from typing import NamedTuple

import numpy as np
from scipy.linalg.lapack import dposv

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.rts import Gaussians, rts_pass


class Passed(NamedTuple):
    """States of a filter before and after each measurement, and what its innovations say of s.

    Means are (N, 7, 6): of the measured torque, and of each joint's friction f in its place.
    squares: Σ E V⁻¹ Eᵀ (7, 7) over the innovations E (7, 6), with V their covariance.
    """

    before: Gaussians
    after: Gaussians
    squares: Array


def smooth(
    measured: Array, noise: Array, spread: Array, decay: Array, friction: Array, scale_std: float
) -> Gaussians:
    """Smooth u = b + diag(f) s by a Kalman filter and Rauch, Tung and Striebel's pass.

    b(t) = A b(t - 1) + w, A = diag(decay), cov w = sqrt(1 - A²) Q sqrt(1 - A²); measured = u + v.
    measured: (N, 6), NaN rows where nothing was measured; noise: cov v (N, 6, 6); spread: Q
    (N, 6, 6), the stationary covariance; decay: (N, 6), over the step towards each sample;
    friction: f (N, 6) [Nm]; scale_std: prior standard deviation of each of s. Since the filter is
    linear, it passes the measurements and each joint's f on their own, and s is the regression of
    the innovations of the first on those of the others [de Jong 1991].
    """
    before, after, squares = _filter(measured, noise, spread, decay, friction)
    # s = (E_f V⁻¹ E_fᵀ + 1 / σ²)⁻¹ E_f V⁻¹ e
    doubt = np.linalg.inv(squares[1:, 1:] + np.eye(6) / scale_std**2)
    scale = doubt @ squares[1:, 0]
    # cov(b(t), b(t - 1)) = A P(t - 1)
    cross = decay[1:, None, :, None] * after.covariance[:-1]  # (N - 1, 1, 6, 6)
    own = rts_pass(cross, before.at(slice(1, None)), after.at(slice(-1)), after.at(-1))
    # u = b(measured) + (f - b(f)) s, and the covariance likewise
    apart = friction[:, :, None] * np.eye(6) - own.mean[:, 1:].mT  # (N, 6, 6)
    return Gaussians(
        own.mean[:, 0] + apart @ scale, own.covariance[:, 0] + apart @ doubt @ apart.mT
    )


def _filter(measured: Array, noise: Array, spread: Array, decay: Array, friction: Array) -> Passed:
    """Pass the measurements, and each joint's friction; arguments as above."""
    known = finite_rows(measured)
    inputs = np.concatenate([measured[:, None], friction[:, None] * np.eye(6)], axis=1)  # (N, 7, 6)
    # cov w = sqrt(1 - A²) Q sqrt(1 - A²);  A P A = kept * P
    renewal = np.sqrt(1 - decay**2)
    renewed = renewal[:, :, None] * spread * renewal[:, None, :]  # (N, 6, 6)
    kept = decay[:, :, None] * decay[:, None, :]  # (N, 6, 6)
    before, after = (
        Gaussians(np.empty_like(inputs), np.empty_like(spread[:, None])) for _ in range(2)
    )
    mean, covariance, squares = np.zeros((7, 6)), spread[0], np.zeros((7, 7))
    for t in range(len(measured)):
        # prediction: b⁻ = A b, P⁻ = A P A + cov w
        if t:
            mean, covariance = decay[t] * mean, kept[t] * covariance + renewed[t]
        before.mean[t], before.covariance[t] = mean, covariance
        # correction: K = P⁻ V⁻¹, V = P⁻ + cov v, b = b⁻ + K E, E = measured - b⁻, P = P⁻ - K P⁻
        if known[t]:
            innovation = inputs[t] - mean
            # dposv takes a quarter of the time of np.linalg.solve
            both = np.concatenate([covariance, innovation.T], axis=1)
            _, solved, _ = dposv(covariance + noise[t], both)
            squares += innovation @ solved[:, 6:]
            mean = mean + innovation @ solved[:, :6]
            covariance = covariance - solved[:, :6].T @ covariance
        after.mean[t], after.covariance[t] = mean, covariance
    return Passed(before, after, squares)
