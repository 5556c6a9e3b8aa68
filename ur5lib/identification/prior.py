"""What is known of the maps from torque to current before any motion."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from ur5lib.identification.friction import Term
from ur5lib.identification.regression import Normal
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class JointPrior:
    """Of one joint, regardless of the others.

    inverse: 1/k [A/Nm], its mean, std: and standard deviation; torque_max: of the motor [Nm].
    """

    inverse: float
    std: float
    torque_max: float

    def over(self, terms: Sequence[Term]) -> Normal:
        """Of the coefficients (P,) of the torque [A/Nm], an offset [A] and these terms.

        The motor's largest torque bounds an offset: it is its standard deviation.
        """
        sizes = [size for term in terms for size in term.expected(self.torque_max)]
        std = np.array([self.std, *(self.inverse * np.array([self.torque_max, *sizes]))])
        mean = np.zeros(len(std))
        mean[0] = self.inverse
        return Normal(mean, np.diag(std**-2.0))


@dataclass(frozen=True)
class Prior:
    """inverse_constant: of 1/k of the six joints [A/Nm]; torque_max: of their motors (6,) [Nm]."""

    inverse_constant: Normal
    torque_max: Array

    def of_joint(self, joint: int) -> JointPrior:
        """Of joint 0 to 5."""
        variance = np.linalg.inv(self.inverse_constant.precision)[joint, joint]
        inverse = self.inverse_constant.mean[joint]
        return JointPrior(float(inverse), float(np.sqrt(variance)), float(self.torque_max[joint]))

    def over(self, terms: Sequence[tuple[Term, ...]]) -> Normal:
        """Of all joints' coefficients one after the other, their torque constants related."""
        joints = [self.of_joint(joint).over(own) for joint, own in enumerate(terms)]
        precision = block_diag(*(joint.precision for joint in joints))
        starts = np.cumsum([0, *(len(joint.mean) for joint in joints[:-1])])
        precision[np.ix_(starts, starts)] = self.inverse_constant.precision
        return Normal(np.concatenate([joint.mean for joint in joints]), precision)
