"""Friction of the joints as simulators know it."""

import math
from dataclasses import dataclass

from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class JointFriction:
    """Friction as simulators know it, (6,) each: coulomb [Nm], viscous [Nm s/rad].

    NaN of a joint that moved too little to tell.
    """

    coulomb: Array
    viscous: Array

    def coefficients(self, joint: int) -> tuple[float, float] | None:
        """Return coulomb and viscous friction of joint 1 to 6, None where it is unknown."""
        known = float(self.coulomb[joint - 1]), float(self.viscous[joint - 1])
        return None if any(map(math.isnan, known)) else known
