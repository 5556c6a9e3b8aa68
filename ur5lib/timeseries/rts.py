"""The backward pass of a Kalman smoother."""

import numpy as np

from ur5lib.timeseries.arrays import Array


def rts_pass(
    cross: Array, prior: tuple[Array, Array], posterior: tuple[Array, Array]
) -> tuple[Array, Array]:
    """Return means (N, X) and covariances (N, X, X) given all measurements.

    Rauch, Tung and Striebel's recursion from the last sample to the first. cross: (N - 1, X, X),
    F_k P_{k-1}, the covariance of each state with the one before; prior, posterior: means and
    covariances of a filter before and after each measurement.
    """
    mean, covariance = posterior[0].copy(), posterior[1].copy()
    gain = np.linalg.solve(prior[1][1:], cross).swapaxes(1, 2)
    for k in range(len(mean) - 2, -1, -1):
        mean[k] += gain[k] @ (mean[k + 1] - prior[0][k + 1])
        covariance[k] += gain[k] @ (covariance[k + 1] - prior[1][k + 1]) @ gain[k].T
    return mean, covariance
