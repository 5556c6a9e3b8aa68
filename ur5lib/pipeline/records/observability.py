"""What can be observed on an arm."""

from dataclasses import dataclass, field

from ur5lib.pipeline.records.contacts import SmallestPush


@dataclass(frozen=True)
class Share:
    """Share of a joint's samples within the band of its friction, and their number, in a range of
    its speed [rad/s]; speed_high: None without an upper end.
    """

    joint: int
    speed_low: float
    speed_high: float | None
    share: float
    samples: float


@dataclass(frozen=True)
class Predicted:
    """The range of a joint's speed [rad/s] in which its friction is predicted within its band.

    speed_low: NaN where there is none; speed_high: None without an upper end.
    """

    joint: int
    speed_low: float
    speed_high: float | None


@dataclass(frozen=True)
class Observability:
    """observability.json: the smallest pushes by speed of the flange, and along each axis; shares
    within the band by joint and speed, and where they suffice.
    """

    pushes: list[SmallestPush] = field(default_factory=list)
    axes: list[SmallestPush] = field(default_factory=list)
    shares: list[Share] = field(default_factory=list)
    predicted: list[Predicted] = field(default_factory=list)
