"""Prior of the maps from torque to current."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import block_diag

from ur5lib.identification.friction import Term
from ur5lib.identification.regression import Normal
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
    """Prior of the six joints: of 1/k [A/Nm]; torque_max: of the motors (6,) [Nm].

    pinned: joints 0 to 5 whose 1/k keeps the prior's mean, whatever the data say.
    """

    inverse_constant: Normal
    torque_max: Array
    pinned: tuple[int, ...] = ()

    def pinning(self, joints: Iterable[int]) -> "Prior":
        """Return the prior that keeps the torque constants of joints 0 to 5."""
        return replace(self, pinned=tuple(joints))

    def unpinned(self) -> "Prior":
        """Return the prior as it is known, with every width."""
        return replace(self, pinned=())

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
