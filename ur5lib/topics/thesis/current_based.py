"""The thesis's torque constants (Equation 6.5) and wrenches (Chapter 6) from motor currents."""

from dataclasses import dataclass

import numpy as np

from ur5lib.robots.description import CurrentToTorque, DeadZoneFriction
from ur5lib.timeseries.arrays import Array, Labels

# The published script delays the Jacobian by 20 samples of 4 ms against the torques. Found by
# matching Table 6.2: with this lag, its maxima of F are met within 0.6 %.
PUBLISHED_JACOBIAN_LAG = 0.08  # s


@dataclass(frozen=True)
class TorqueLine:
    """The line torque = k i + b of each joint, (6,) each, NaN for joints that do not determine it.

    torque_constant: k [Nm/A], offset: b [Nm], and their standard errors.
    """

    torque_constant: Array
    offset: Array
    torque_constant_std: Array
    offset_std: Array


def torque_on_current(current: Array, torque: Array, block: Labels) -> TorqueLine:
    """Return the least-squares lines of the torque (N, 6) [Nm] on the current (N, 6) [A].

    block: (N,) ascending labels from 0 of blocks with correlated errors. Standard errors by a
    jackknife over the blocks.
    """
    slope, offset = _leave_one_out(current, torque, block)
    return TorqueLine(slope[-1], offset[-1], _jackknife(slope[:-1]), _jackknife(offset[:-1]))


def current_on_torque(current: Array, torque: Array, block: Labels) -> TorqueLine:
    """Return the least-squares lines of the current on the torque, solved for the torque."""
    slope, intercept = _leave_one_out(torque, current, block)
    constant, offset = 1 / slope, -intercept / slope
    return TorqueLine(constant[-1], offset[-1], _jackknife(constant[:-1]), _jackknife(offset[:-1]))


def _leave_one_out(x: Array, y: Array, block: Labels) -> tuple[Array, Array]:
    """Return slopes and intercepts (K + 1, 6): without each of K blocks, last of all samples."""
    moments = np.stack([np.ones_like(x), x, y, x * x, x * y])  # (5, N, 6)
    firsts = np.flatnonzero(np.diff(block, prepend=-1))
    sums = np.add.reduceat(moments, firsts, axis=1)  # (5, K, 6)
    total = sums.sum(axis=1, keepdims=True)
    n, sx, sy, sxx, sxy = np.concatenate([total - sums, total], axis=1)
    slope = (n * sxy - sx * sy) / (n * sxx - sx**2)
    return slope, (sy - slope * sx) / n


def _jackknife(values: Array) -> Array:
    """Return the jackknife standard error (6,) from the estimates (K, 6) without each block."""
    count = len(values)
    return np.sqrt((count - 1) / count * np.sum((values - values.mean(axis=0)) ** 2, axis=0))


def motor_torque(current: Array, constants: CurrentToTorque) -> Array:
    """Return tau = k i + b (Equation 6.6). current: (N, 6) [A]; returns (N, 6) [Nm]."""
    return current * constants.torque_constant + constants.offset


def motor_torque_as_published(current: Array, constants: CurrentToTorque) -> Array:
    """Return Equation 6.6 as in the published script: for joint 6, k i times b (erratum 6)."""
    torque = motor_torque(current, constants)
    torque[:, 5] = constants.torque_constant[5] * current[:, 5] * constants.offset[5]
    return torque


def friction_torque(qd: Array, friction: DeadZoneFriction) -> Array:
    """Return Coulomb friction with a dead zone plus viscous friction (Equations 3.12, 3.14, 6.4).

    qd: (N, 6) [rad/s]; returns (N, 6) [Nm].
    """
    direction = np.where(np.abs(qd) > friction.dead_zone, np.sign(qd), 0.0)
    return direction * friction.coulomb + qd * friction.viscous


def wrench_from_torque(jacobian: Array, torque: Array, min_singular_value: float) -> Array:
    """Return F = J^-T tau (Equation 3.3), base axes, at the reference point of the Jacobian.

    jacobian: (N, 6, 6); torque: (N, 6) [Nm]. Returns (N, 6) [N, Nm], NaN where the Jacobian's
    smallest singular value is below `min_singular_value`: there the torques determine no wrench.
    """
    wrench = np.full_like(torque, np.nan)
    finite = np.isfinite(torque).all(axis=1)
    # near a singularity, small torque errors become large forces
    regular = np.linalg.svd(jacobian, compute_uv=False)[:, -1] >= min_singular_value
    rows = finite & regular
    wrench[rows] = np.linalg.solve(jacobian[rows].mT, torque[rows, :, None])[..., 0]
    return wrench


def delay(values: Array, samples: int) -> Array:
    """Return values delayed by some samples; the first row is repeated at the start."""
    return values[np.maximum(np.arange(len(values)) - samples, 0)]
