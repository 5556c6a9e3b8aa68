"""The joints in closed loop."""

from dataclasses import dataclass

from ur5lib.pipeline.records.table import JOINTS, SegmentedTable, channels
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True, kw_only=True)
class ClosedLoop(SegmentedTable):
    """The joints in closed loop, (N, 6) each, by the set of gains: a link model's published ones,
    or "estimated".

    q [rad], qd [rad/s], qdd [rad/s²]; torque: inverse dynamics at that motion [Nm], of the link
    model whose gains they are.
    """

    q: dict[str, Array] = channels("q_{}", "rad", JOINTS)
    qd: dict[str, Array] = channels("qd_{}", "rad/s", JOINTS)
    qdd: dict[str, Array] = channels("qdd_{}", "rad/s2", JOINTS)
    torque: dict[str, Array] = channels("tau_{}", "Nm", JOINTS)
