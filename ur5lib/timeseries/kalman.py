"""Kalman smoother of a linear time-varying system."""

from dataclasses import dataclass

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.rts import rts_pass


@dataclass(frozen=True)
class LinearSystem:
    """x_k = F_k x_{k-1} + w, z_k = H_k x_k + v, of all samples at once.

    F, Q: (N, X, X), into each sample from the one before; H: (N, M, X); z: (N, M), NaN where
    nothing was measured; R: (N, M), variances.
    """

    F: Array
    Q: Array
    H: Array
    z: Array
    R: Array


def smooth(system: LinearSystem) -> tuple[Array, Array, Array]:
    """Return states (N, X), covariances (N, X, X) and normalised innovations (N, M).

    States and covariances are those given all measurements. Raises numpy.linalg.LinAlgError if a
    state has no uncertainty.
    """
    prior, posterior, innovations = _filter(system)
    # cov(x_k, x_k-1) = F_k P_k-1
    cross = system.F[1:] @ posterior[1][:-1]
    return *rts_pass(cross, prior, posterior), innovations


def _filter(
    system: LinearSystem,
) -> tuple[tuple[Array, Array], tuple[Array, Array], Array]:
    """Run filterpy's EKF through all samples: return priors, posteriors and innovations.

    Priors and posteriors are each a mean (N, X) and a covariance (N, X, X).
    """
    size = system.F.shape[2]
    ekf = ExtendedKalmanFilter(size, system.z.shape[1])
    ekf.x, ekf.P = np.zeros(size), np.zeros((size, size))
    prior, posterior = ((np.empty(system.F.shape[:2]), np.empty(system.F.shape)) for _ in range(2))
    innovations = np.full_like(system.z, np.nan)
    measured = np.isfinite(system.z)
    for k, seen in enumerate(measured):
        ekf.F, ekf.Q = system.F[k], system.Q[k]
        ekf.predict()  # x = F x, P = F P Fᵀ + Q
        prior[0][k], prior[1][k] = ekf.x, ekf.P
        if seen.any():
            H = system.H[k, seen]
            ekf.update(system.z[k, seen], lambda _, H=H: H, H.dot, R=np.diag(system.R[k, seen]))
            # (z - H x) / sqrt diag(S)
            innovations[k, seen] = ekf.y / np.sqrt(np.diagonal(ekf.S))
        posterior[0][k], posterior[1][k] = ekf.x, ekf.P
    return prior, posterior, innovations
