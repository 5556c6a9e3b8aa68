"""The most probable wrench given a torque, its noise and a prior; F̂ᵐᵃᵖ is one."""

from typing import NamedTuple

import numpy as np

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array, Mask


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


SLOW = 0.05  # rad/s, below which the torques of motion are far below friction
BREAKAWAY = 0.1  # of a motor's largest torque; Coulomb friction of UR5 and UR10e is 0.04 to 0.06
LEAST_ERROR = 0.3  # relative, of a torque constant that nothing was fitted for
FORCE, LEVER = 100.0, 0.1  # N, m: standard deviation of the force, and of its moment over it


def at_rest(qd: Array) -> Mask:
    """Return the samples (N,) at which no joint is faster than `SLOW`; qd: (N, 6) [rad/s]."""
    return np.asarray((np.abs(qd) < SLOW).all(axis=1))


def torque_std(motor_torque: Array, constant_error: Array, torque_max: Array) -> Array:
    """Return the standard deviation (N, 6) [Nm] of the external torque of a resting arm.

    motor_torque: (N, 6) [Nm], by the known constants, whose relative errors are constant_error,
    (6,); torque_max: of the motors (6,) [Nm]. Friction lies anywhere within ± the breakaway torque.
    """
    friction = BREAKAWAY * torque_max / np.sqrt(3)  # of a uniform distribution
    return np.hypot(constant_error * motor_torque, friction)


def static_wrench(torque: Array, std: Array, jacobian: Array) -> tuple[Array, Array]:
    """Return the most probable wrench [F, n] and its standard deviation, (N, 6) [N, Nm].

    torque: external (N, 6) [Nm], J^T F, NaN where unknown; std: of it; jacobian: (N, 6, 6). The
    prior is 0 ± FORCE, with a moment over LEVER.
    """
    prior = np.diag(np.array([FORCE] * 3 + [FORCE * LEVER] * 3) ** 2.0)
    noise = std[:, :, None] ** 2 * np.eye(std.shape[1])
    found = regularised_wrench(torque, jacobian, noise, prior)
    error = np.sqrt(np.diagonal(found.covariance, axis1=1, axis2=2))
    known = finite_rows(torque + error)[:, None]
    return np.where(known, found.mean, np.nan), np.where(known, error, np.nan)
