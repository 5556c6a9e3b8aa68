"""The gains of the joints in closed loop, as their motion shows them."""

from dataclasses import dataclass, field

from ur5lib.identification.closed_loop import JointGains
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class GainSummary:
    """gains.json: the estimated gains of each joint in closed loop, and the costs (6,) of published
    ones by their name; empty where targets were not recorded.
    """

    joints: list[JointGains] = field(default_factory=list)
    published: dict[str, Array] = field(default_factory=dict)
