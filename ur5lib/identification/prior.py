"""Prior of the maps from torque to current, and of the torque constants."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from ur5lib.errors import RefusalError
from ur5lib.identification.regression import Normal
from ur5lib.robots.friction import Term
from ur5lib.timeseries.arrays import Array

PINNED = 1e-3  # of its standard deviation: what is left of it where a constant is pinned


@dataclass(frozen=True)
class JointPrior:
    """Prior of one joint, regardless of the others.

    inverse, std: mean and standard deviation of 1/k [A/Nm]; torque_max: of the motor [Nm].
    """

    inverse: float
    std: float
    torque_max: float

    def over(self, terms: Sequence[Term]) -> Normal:
        """Return the prior of the coefficients (P,) of the torque [A/Nm], an offset [A] and terms.

        The standard deviation of the offset is the motor's largest torque.
        """
        sizes = [size for term in terms for size in term.expected(self.torque_max)]
        std = np.array([self.std, *(self.inverse * np.array([self.torque_max, *sizes]))])
        mean = np.zeros(len(std))
        mean[0] = self.inverse
        return Normal(mean, np.diag(std**-2.0))


@dataclass(frozen=True)
class Prior:
    """Prior of all joints: of 1/k [A/Nm]; torque_max: of the motors (6,) [Nm].

    pinned: joints 0 to 5 whose 1/k keeps the prior's mean, regardless of the data.
    """

    inverse_constant: Normal
    torque_max: Array
    pinned: tuple[int, ...] = ()

    def of_joint(self, joint: int) -> JointPrior:
        """Return the prior of joint 0 to 5."""
        variance = np.linalg.inv(self.inverse_constant.precision)[joint, joint]
        inverse, std = self.inverse_constant.mean[joint], np.sqrt(variance)
        if joint in self.pinned:
            std *= PINNED
        return JointPrior(float(inverse), float(std), float(self.torque_max[joint]))

    def _precision_among(self, joints: list[int]) -> Array:
        """Return the precision of 1/k of some joints, whatever the constants of the others."""
        if len(joints) == len(self.torque_max):
            return self.inverse_constant.precision
        covariance = np.linalg.inv(self.inverse_constant.precision)
        return np.linalg.inv(covariance[np.ix_(joints, joints)])

    def over(self, terms: Sequence[tuple[Term, ...]]) -> Normal:
        """Return the prior of all joints' coefficients, with correlated torque constants."""
        joints = [self.of_joint(joint).over(own) for joint, own in enumerate(terms)]
        precision = block_diag(*(joint.precision for joint in joints))
        starts = np.cumsum([0, *(len(joint.mean) for joint in joints[:-1])])
        free = [joint for joint in range(len(joints)) if joint not in self.pinned]
        precision[np.ix_(starts[free], starts[free])] = self._precision_among(free)
        return Normal(np.concatenate([joint.mean for joint in joints]), precision)


STILL = 1e-3  # rad/s
LOAD = 0.1  # Nm; least torque for a ratio


def standstill_ratio(moment: Array, current: Array, qd: Array) -> Array:
    """Return the controller's torque constants (6,) [Nm/A], NaN for a joint without load at rest.

    moment, current: (N, 6) `target_moment` [Nm] and `target_current` [A]; qd: (N, 6) [rad/s].
    At rest, the controller's current contains no friction, so the ratio is constant.
    """
    rest = (np.abs(qd) < STILL).all(axis=1) & np.isfinite(moment * current).all(axis=1)
    constants = np.full(moment.shape[1], np.nan)
    for joint in range(len(constants)):
        loaded = rest & (np.abs(moment[:, joint]) > LOAD) & (current[:, joint] != 0)
        if loaded.sum() > rest.sum() / 2:
            constants[joint] = np.median(moment[loaded, joint] / current[loaded, joint])
    return constants


def torque_constant_prior(
    maker: Array, controller: Array, motors: Sequence[str], widths: tuple[float, float, float]
) -> Normal:
    """Return the prior of 1/k [A/Nm] of all joints from values (6,) [Nm/A], NaN if unknown.

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
    covariance = same * np.outer(wide, wide) + np.eye(len(motors)) * spread**2
    precision = np.linalg.inv(covariance)
    right = precision @ np.log(np.where(known, maker, 1.0))
    # the controller's ratio as a measurement of log k
    measured = np.isfinite(controller)
    precision += np.diag(measured / ratio**2)
    right += np.log(np.where(measured, controller, 1.0)) * measured / ratio**2
    # from log k to 1/k
    inverse = np.exp(-np.linalg.solve(precision, right))
    return Normal(inverse, precision / np.outer(inverse, inverse))
