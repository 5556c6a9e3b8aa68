"""Prior of the torque constants: manufacturer, motor sizes, and the controller's ratio."""

from collections.abc import Sequence

import numpy as np

from ur5lib.errors import RefusalError
from ur5lib.identification.regression import Normal
from ur5lib.timeseries.arrays import Array

STILL = 1e-3  # rad/s
LOAD = 0.1  # Nm; least torque for a ratio


def standstill_ratio(moment: Array, current: Array, qd: Array) -> Array:
    """Return the controller's torque constants (6,) [Nm/A], NaN for a joint without load at rest.

    moment, current: (N, 6) `target_moment` [Nm] and `target_current` [A]; qd: (N, 6) [rad/s].
    At rest, the controller's current contains no friction, so the ratio is constant.
    """
    rest = (np.abs(qd) < STILL).all(axis=1) & np.isfinite(moment * current).all(axis=1)
    constants = np.full(6, np.nan)
    for joint in range(6):
        loaded = rest & (np.abs(moment[:, joint]) > LOAD) & (current[:, joint] != 0)
        if loaded.sum() > rest.sum() / 2:
            constants[joint] = np.median(moment[loaded, joint] / current[loaded, joint])
    return constants


def torque_constant_prior(
    maker: Array, controller: Array, motors: Sequence[str], widths: tuple[float, float, float]
) -> Normal:
    """Return the prior of 1/k [A/Nm] of the six joints from values (6,) [Nm/A], NaN if unknown.

    maker: at the joint's side of the gear; controller: see `standstill_ratio`; motors: their sizes.
    widths: relative standard deviations of the manufacturer's value, common to joints of one motor
    size; of joints of one size from each other; of the controller's ratio, joint by joint. They
    are combined as normal distributions of log k. Raises RefusalError if a size has neither value.
    """
    shared, spread, ratio = widths
    same = np.array([[one == other for other in motors] for one in motors])
    known = np.isfinite(maker)
    if not all((known | np.isfinite(controller))[row].any() for row in same):
        raise RefusalError("unknown constant")
    # covariance of log k: common to a motor size, and of each joint
    wide = np.where(known, shared, 10.0)  # without a manufacturer's value, any constant
    covariance = same * np.outer(wide, wide) + np.eye(6) * spread**2
    precision = np.linalg.inv(covariance)
    right = precision @ np.log(np.where(known, maker, 1.0))
    # the controller's ratio as a measurement of log k
    measured = np.isfinite(controller)
    precision += np.diag(measured / ratio**2)
    right += np.log(np.where(measured, controller, 1.0)) * measured / ratio**2
    # from log k to 1/k
    inverse = np.exp(-np.linalg.solve(precision, right))
    return Normal(inverse, precision / np.outer(inverse, inverse))
