"""The joints in closed loop, and gains estimated from their motion."""

from dataclasses import dataclass, field

from ur5lib.records.table import JOINTS, SegmentedTable, channel
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True, kw_only=True)
class ClosedLoop(SegmentedTable):
    """The joints in closed loop, (N, 6) each, by set of gains: the name of a link model with
    published gains, or "estimated".

    q [rad], qd [rad/s], qdd [rad/s²]; torque: inverse dynamics at that motion [Nm], of the link
    model with these gains.
    """

    q: dict[str, Array] = channel("q_{}", "rad", JOINTS)
    qd: dict[str, Array] = channel("qd_{}", "rad/s", JOINTS)
    qdd: dict[str, Array] = channel("qdd_{}", "rad/s2", JOINTS)
    torque: dict[str, Array] = channel("tau_{}", "Nm", JOINTS)


@dataclass(frozen=True)
class Gain:
    """One gain, K0 [1/s²] or K1 [1/s], with its confidence range.

    best: the minimum of the cost; std_error: from the Jacobian there; low, high: ends of the 95 %
    range; determined: whether both lie inside the search bounds (Raue et al. 2009) and less than an
    order of magnitude apart. If not, the range is the result, `best` is one value in it, and
    `std_error` is meaningless. grid: (G,) values between the search bounds, at which the least cost
    over the other gain is compared with the limit.
    """

    best: float
    std_error: float
    low: float
    high: float
    determined: bool
    grid: Array


@dataclass(frozen=True)
class JointGains:
    """The gains of one joint, and costs as in `tracking_cost`.

    excited: whether the target moves; if not, the recording does not determine the gains. noise:
    (2,) [rad, rad/s], standard deviation of an independent sample of position and velocity; cost:
    the minimum; limit: cost at the ends of the 95 % range; stiff: cost of a joint that follows its
    target exactly.
    """

    position: Gain
    velocity: Gain
    excited: bool
    noise: Array
    cost: float
    limit: float
    stiff: float


@dataclass(frozen=True)
class GainSummary:
    """The estimated gains of each joint in closed loop, and the costs (6,) of published
    ones by their name; empty where targets were not recorded.
    """

    joints: list[JointGains] = field(default_factory=list)
    published: dict[str, Array] = field(default_factory=dict)
