"""The backward pass of a Kalman smoother."""

from typing import NamedTuple

import numpy as np

from ur5lib.timeseries.arrays import Array


class Gaussians(NamedTuple):
    """Means (N, ..., X) and covariances (N, ..., X, X) of the states at N samples."""

    mean: Array
    covariance: Array

    def at(self, rows: slice | int) -> "Gaussians":
        """Return the states of some samples."""
        return Gaussians(self.mean[rows], self.covariance[rows])

    def copy(self) -> "Gaussians":
        """Return a copy, which does not keep the arrays of other samples alive."""
        return Gaussians(self.mean.copy(), self.covariance.copy())

    def followed_by(self, last: "Gaussians") -> "Gaussians":
        """Return the states with that of one more sample appended."""
        pairs = zip(self, last, strict=True)
        return Gaussians(*(np.concatenate([arrays, more[None]]) for arrays, more in pairs))


def rts_pass(cross: Array, prior: Gaussians, posterior: Gaussians, end: Gaussians) -> Gaussians:
    """Return the states at samples 0 to N given all measurements.

    Rauch, Tung and Striebel's recursion from the last sample to the first. cross: (N, ..., X, X),
    F_k+1 P_k, the covariance of each state with its predecessor; prior: of a filter before the
    measurements of samples 1 to N; posterior: after those of samples 0 to N - 1; end: of sample N,
    given all measurements.
    """
    mean, covariance = posterior.followed_by(end)
    # G_k = P_k F_k+1ᵀ (P⁻_k+1)⁻¹
    gain = np.linalg.solve(prior.covariance, cross).mT
    # x̂_k = x_k + G_k (x̂_k+1 - x⁻_k+1), P̂_k = P_k + G_k (P̂_k+1 - P⁻_k+1) G_kᵀ
    for k in range(len(gain) - 1, -1, -1):
        mean[k] += np.matvec(gain[k], mean[k + 1] - prior.mean[k])
        covariance[k] += gain[k] @ (covariance[k + 1] - prior.covariance[k]) @ gain[k].mT
    return Gaussians(mean, covariance)
