"""F̂ᵐᵃᵖ: the most probable wrench behind a torque, given how noisy the torque is and a prior."""

from typing import NamedTuple

import numpy as np

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array


class Posterior(NamedTuple):
    """Mean (N, 6), covariance (N, 6, 6), and gain (N, 6, 6) from torque to mean."""

    mean: Array
    covariance: Array
    gain: Array


def regularised_wrench(torque: Array, jacobian: Array, noise: Array, prior: Array) -> Posterior:
    """argmin |tau - J^T F|²_S + |F|²_P = P J (J^T P J + S)^-1 tau, and its covariance.

    torque: external, (N, 6) [Nm]; jacobian: (N, 6, 6); noise: S, (N, 6, 6) [Nm²]; prior: P,
    (6, 6) or (N, 6, 6), zero moments for "force only". Where J^-T explodes, the direction that
    cannot be seen keeps its prior. A row of NaN tells nothing: mean 0, covariance P.
    """
    known = finite_rows(torque)
    lever = prior @ jacobian
    seen = np.asarray(np.linalg.solve(jacobian.mT @ lever + noise, lever.mT), np.float64)
    gain = seen.mT * known[:, None, None]
    mean = (gain @ np.where(known[:, None], torque, 0.0)[..., None])[..., 0]
    return Posterior(mean, prior - gain @ lever.mT, gain)
