"""What is known of torque constants before any motion: the maker, the motors, the controller."""

from collections.abc import Sequence

import numpy as np

from ur5lib.identification.regression import Normal
from ur5lib.timeseries.arrays import Array

STILL = 1e-3  # rad/s
LOAD = 0.1  # Nm; a joint that carries less tells no ratio


def standstill_ratio(moment: Array, current: Array, qd: Array) -> Array:
    """The controller's own torque constants (6,) [Nm/A], NaN where a joint bears no load at rest.

    moment, current: (N, 6) `target_moment` [Nm] and `target_current` [A]; qd: (N, 6) [rad/s].
    At rest the controller's current has no friction in it, so that the ratio is a constant.
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
    """Prior of 1/k of the six joints [A/Nm], from values (6,) [Nm/A], NaN where there is none.

    maker: at the joint's side of the gear; controller: see `standstill_ratio`; motors: their sizes.
    widths: relative standard deviations of the maker's value, which joints with a motor of the same
    size share; among joints of one size; of the controller's ratio, joint by joint. They are
    combined as normal distributions of log k. Raises ValueError where neither is known of a size.
    """
    shared, spread, ratio = widths
    same = np.array([[one == other for other in motors] for one in motors])
    known = np.isfinite(maker)
    if not all((known | np.isfinite(controller))[row].any() for row in same):
        raise ValueError(
            "the torque constant of a motor size is unknown: neither the robot's description nor "
            "target_moment and target_current at standstill determine it"
        )
    wide = np.where(known, shared, 10.0)  # nothing from the maker: any constant may be
    covariance = same * np.outer(wide, wide) + np.eye(6) * spread**2
    precision = np.linalg.inv(covariance)
    right = precision @ np.log(np.where(known, maker, 1.0))
    told = np.isfinite(controller)
    precision += np.diag(told / ratio**2)
    right += np.log(np.where(told, controller, 1.0)) * told / ratio**2
    inverse = np.exp(-np.linalg.solve(precision, right))
    return Normal(inverse, precision / np.outer(inverse, inverse))
