"""The joints in closed loop."""

from dataclasses import dataclass

from ur5lib.records.table import JOINTS, SegmentedTable, channel
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True, kw_only=True)
class ClosedLoop(SegmentedTable):
    """The joints in closed loop, (N, 6) each, by the set of gains: a link model's published ones,
    or "estimated".

    q [rad], qd [rad/s], qdd [rad/s²]; torque: inverse dynamics at that motion [Nm], of the link
    model whose gains they are.
    """

    q: dict[str, Array] = channel("q_{}", "rad", JOINTS)
    qd: dict[str, Array] = channel("qd_{}", "rad/s", JOINTS)
    qdd: dict[str, Array] = channel("qdd_{}", "rad/s2", JOINTS)
    torque: dict[str, Array] = channel("tau_{}", "Nm", JOINTS)
