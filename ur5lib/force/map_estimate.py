"""F̂ᵐᵃᵖ: the most probable wrench given a torque, its noise and a prior."""

from typing import NamedTuple

import numpy as np

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array


class Posterior(NamedTuple):
    """Mean (N, 6), covariance (N, 6, 6), and gain (N, 6, n) from the torque of n joints to it."""

    mean: Array
    covariance: Array
    gain: Array


def regularised_wrench(torque: Array, jacobian: Array, noise: Array, prior: Array) -> Posterior:
    """Return argmin |tau - J^T F|²_S + |F|²_P = P J (J^T P J + S)^-1 tau, and its covariance.

    torque: external, (N, n) [Nm]; jacobian: (N, 6, n); noise: S, (N, n, n) [Nm²]; prior: P,
    (6, 6) or (N, 6, 6), zero moments for "force only". At a singularity, the unobservable
    direction keeps its prior. For a row of NaN, the mean is 0 and the covariance P.
    """
    known = finite_rows(torque)
    # K = P J (Jᵀ P J + S)⁻¹, F = K τ, cov F = P - K Jᵀ P
    lever = prior @ jacobian  # P J (N, 6, n)
    transposed = np.linalg.solve(jacobian.mT @ lever + noise, lever.mT)
    gain = np.asarray(transposed, np.float64).mT * known[:, None, None]
    mean = (gain @ np.where(known[:, None], torque, 0.0)[..., None])[..., 0]
    return Posterior(mean, prior - gain @ lever.mT, gain)
