"""The background: the slowly varying part of the external torque, from friction and model."""

import numpy as np
from scipy.linalg.lapack import dposv

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.rts import Gaussians, rts_pass


def smooth(measured: Array, noise: Array, spread: Array, decay: Array) -> Gaussians:
    """Smooth an Ornstein-Uhlenbeck process by a Kalman filter and Rauch, Tung and Striebel's pass.

    b(t) = A b(t - 1) + w, A = diag(decay), cov w = sqrt(1 - A²) Q sqrt(1 - A²); measured = b + v.
    measured: (N, 6), NaN rows where nothing was measured; noise: cov v (N, 6, 6); spread: Q
    (N, 6, 6), the stationary covariance; decay: (N, 6), over the step towards each sample.
    """
    before, after = _filter(measured, noise, spread, decay)
    # cov(b(t), b(t - 1)) = A P(t - 1)
    cross = decay[1:, :, None] * after.covariance[:-1]  # (N - 1, 6, 6)
    return rts_pass(cross, before.at(slice(1, None)), after.at(slice(-1)), after.at(-1))


def _filter(
    measured: Array, noise: Array, spread: Array, decay: Array
) -> tuple[Gaussians, Gaussians]:
    """Return means and covariances before and after each measurement."""
    known = finite_rows(measured)
    # cov w = sqrt(1 - A²) Q sqrt(1 - A²);  A P A = kept * P
    renewal = np.sqrt(1 - decay**2)
    renewed = renewal[:, :, None] * spread * renewal[:, None, :]  # (N, 6, 6)
    kept = decay[:, :, None] * decay[:, None, :]  # (N, 6, 6)
    before = Gaussians(np.empty_like(decay), np.empty_like(spread))
    after = Gaussians(np.empty_like(decay), np.empty_like(spread))
    mean, covariance = np.zeros(6), spread[0]
    for t in range(len(measured)):
        # prediction: b⁻ = A b, P⁻ = A P A + cov w
        if t:
            mean, covariance = decay[t] * mean, kept[t] * covariance + renewed[t]
        before.mean[t], before.covariance[t] = mean, covariance
        # correction: K = P⁻ (P⁻ + cov v)⁻¹, b = b⁻ + K (measured - b⁻), P = P⁻ - K P⁻
        if known[t]:
            # dposv takes a quarter of the time of np.linalg.solve
            _, transposed_gain, _ = dposv(covariance + noise[t], covariance)
            gain = transposed_gain.T
            mean = mean + gain @ (measured[t] - mean)
            covariance = covariance - gain @ covariance
        after.mean[t], after.covariance[t] = mean, covariance
    return before, after
