"""What *Replay* shows of an arm."""

from dataclasses import dataclass

from ur5lib.timeseries.arrays import Array, Labels

Spans = list[tuple[float, float]]  # s, from and to


@dataclass(frozen=True)
class LinkPose:
    """The pose of frame k of an arm, in the frame that joint k turns: rotation (3, 3) and position
    (3,) [m].
    """

    rotation: Array
    position: Array


@dataclass(frozen=True, kw_only=True)
class Scene:
    """An arm at some times (K,) [s] of a recording, its base at the origin; None where unknown.

    links: of the arm's n joints; upright: (3, 3), from base axes to those in which gravity acts
    along −z; segment: (K,), labels of unbroken stretches; q: (K, n) [rad]; torque: (K, n) [Nm], the
    external one; force, std: (K, 3) [N], the environment on the arm at the origin of frame n and
    its standard deviation, base axes, by the estimate with the label `estimate`; hidden: (K, 3)
    [N], up to which a contact that it does not find could be, 0 in contacts; sensed: (K, 3) [N],
    the force by the sensor; link: (K,), the likeliest one that is touched, from 1, where the
    estimate finds a contact before the last one, else 0; contacts, alarms: contacts by the sensor
    and by the estimate; largest: the largest force [N] of each alarm, and half of its 95 % band;
    free: whether nothing touches the arm, so that each alarm is false.
    """

    links: list[LinkPose]
    upright: Array
    time: Array
    segment: Labels
    q: Array
    estimate: str = ""
    torque: Array | None = None
    force: Array | None = None
    std: Array | None = None
    hidden: Array | None = None
    sensed: Array | None = None
    link: Labels | None = None
    contacts: Spans | None = None
    alarms: Spans | None = None
    largest: list[tuple[float, float]] | None = None
    free: bool = False
