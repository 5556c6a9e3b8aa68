"""The pushes that trials on an arm's contact-free recordings show to be detected."""

from dataclasses import dataclass
from typing import Literal

Basis = Literal["unseen", "fit"]
Reason = Literal["", "one_path", "fitted", "undetermined"]  # codes of verdicts


SPEEDS = {
    0.0: "at rest",
    0.01: "slow",
    0.25: "fast",
}  # of the flange, from [m/s] on


@dataclass(frozen=True, kw_only=True)
class SmallestPush:
    """A row of pushes.csv: the push along an axis that the leading estimate detects with 95 %.

    motion: of the flange, slow or fast, or at rest, of the whole arm; axis: x, y or z of the base;
    value [N], with its standard error and 95 % interval, empty where the trials do not determine it
    or the arm is fitted to a single path; bound: ">" of a push beyond `largest_tried` [N], the
    largest trial; seconds: duration of a trial push [s]; trials: number of those in this motion
    along this axis, of which so many are `blind`, in poses in which two standard deviations of the
    joints' torques exceed the largest contact that the gate expects, three typical ones: they count
    nowhere else;
    basis: unseen, if recordings that no fit has seen were among those tried, or fit; reason:
    one_path, undetermined, or fitted, of a value by fit recordings alone.
    """

    motion: str
    axis: str
    value: float | None = None
    std_error: float | None = None
    low: float | None = None
    high: float | None = None
    bound: str = ""
    largest_tried: float
    seconds: float
    trials: int
    blind: int = 0
    basis: Basis
    reason: Reason = ""


@dataclass(frozen=True, kw_only=True)
class PushDirection:
    """A row of push_directions.csv: the push in a direction at a posture that the leading estimate
    detects with 95 %.

    posture: which of all places of trials it is: stretched out or folded, with the flange farthest
    from the base's origin or nearest; easiest or hardest, where the direction that joints feel
    least needs the smallest or the largest push; recording, time_s, posture_deg: where it is, and
    the joints there [°]; motion: see `SmallestPush`; plane, angle_deg: of the direction,
    horizontal, from the base's x to its y, or vertical, from its x to its z [°]; unit: the push
    that is worth one standard deviation of the joints' torques [N], empty where no joint feels any;
    value: so many units that all axes together need in this motion [N], with its standard error,
    empty where joints feel almost none (see `blind`) and beyond the largest trial.
    """

    posture: str
    recording: str
    time_s: float
    posture_deg: str
    motion: str
    plane: str
    angle_deg: float
    unit: float | None
    value: float | None = None
    std_error: float | None = None


@dataclass(frozen=True, kw_only=True)
class PushesFound:
    """A row of push_curve.csv: the share of pushes of a force [N] that the leading estimate detects
    in a motion, along x, y and z together, by a logistic curve of the trials; but for `blind` ones.
    """

    motion: str
    force: float
    share: float
