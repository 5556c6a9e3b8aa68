"""Friction of the joints as simulators know it."""

from dataclasses import dataclass

from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class JointFriction:
    """Friction as simulators know it, (6,) each: coulomb [Nm], viscous [Nm s/rad]."""

    coulomb: Array
    viscous: Array
