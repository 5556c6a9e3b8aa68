"""The thesis's estimates of a contact wrench from motor currents (Chapter 6)."""

import numpy as np

from ur5lib.robots.description import CurrentToTorque, Friction
from ur5lib.timeseries.arrays import Array

# The published script takes the Jacobian by an index that starts 20 samples of 4 ms earlier
# than the torques': found by matching Table 6.2, whose maxima for F are then met within 0.6 %.
PUBLISHED_JACOBIAN_LAG = 0.08  # s


def motor_torque(current: Array, constants: CurrentToTorque) -> Array:
    """tau = k i + b (Equation 6.6). current: (N, 6) [A]; returns (N, 6) [Nm]."""
    return current * constants.torque_constant + constants.offset


def motor_torque_as_published(current: Array, constants: CurrentToTorque) -> Array:
    """Equation 6.6 as the published script has it: joint 6 is k i times b (erratum 6)."""
    torque = motor_torque(current, constants)
    torque[:, 5] = constants.torque_constant[5] * current[:, 5] * constants.offset[5]
    return torque


def friction_torque(qd: Array, friction: Friction) -> Array:
    """Coulomb with dead zone, and viscous friction (Equations 3.12, 3.14, 6.4).

    qd: (N, 6) [rad/s]; returns (N, 6) [Nm].
    """
    direction = np.where(np.abs(qd) > friction.dead_zone, np.sign(qd), 0.0)
    return direction * friction.coulomb + qd * friction.viscous


def wrench_from_torque(jacobian: Array, torque: Array, min_singular_value: float) -> Array:
    """F = J^-T tau (Equation 3.3), base axes, at the origin the Jacobian belongs to.

    jacobian: (N, 6, 6); torque: (N, 6) [Nm]. Returns (N, 6) [N, Nm], NaN where the Jacobian's
    smallest singular value is below `min_singular_value`: there the torques tell no wrench.
    """
    wrench = np.full_like(torque, np.nan)
    finite = np.isfinite(torque).all(axis=1)
    regular = np.linalg.svd(jacobian, compute_uv=False)[:, -1] >= min_singular_value
    rows = finite & regular
    wrench[rows] = np.linalg.solve(jacobian[rows].mT, torque[rows, :, None])[..., 0]
    return wrench


def environment_on_arm(published: Array) -> Array:
    """A wrench (N, 6) of the thesis, or the controller's F^u, with the sign of all others here.

    Both are J^-T (tau_motor - tau_model): what the arm does to its environment. This is the one
    place where that is turned round.
    """
    return -published


def delay(values: Array, samples: int) -> Array:
    """The value of `samples` rows before, and the first row until there is one."""
    return values[np.maximum(np.arange(len(values)) - samples, 0)]
