"""Friction of the joints in the form of simulators."""

import math
from dataclasses import dataclass

from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class JointFriction:
    """Friction in the form of simulators, (6,) each: coulomb [Nm], viscous [Nm s/rad].

    NaN for joints that moved too little.
    """

    coulomb: Array
    viscous: Array

    def coefficients(self, joint: int) -> tuple[float, float] | None:
        """Return coulomb and viscous friction of joint 1 to 6, None where it is unknown."""
        pair = float(self.coulomb[joint - 1]), float(self.viscous[joint - 1])
        return None if any(map(math.isnan, pair)) else pair
