"""The joints in closed loop, and their gains."""

from dataclasses import dataclass, field

from ur5lib.identification.closed_loop import JointGains
from ur5lib.pipeline.records.table import JOINTS, SegmentedTable, channel
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


@dataclass(frozen=True)
class GainSummary:
    """gains.json: the estimated gains of each joint in closed loop, and the costs (6,) of published
    ones by their name; empty where targets were not recorded.
    """

    joints: list[JointGains] = field(default_factory=list)
    published: dict[str, Array] = field(default_factory=dict)
