"""The detected pushes in trials on an arm's contact-free recordings."""

from dataclasses import dataclass
from typing import Literal

YOURS = "your"  # the posture that the user names
Basis = Literal["unseen", "fit"]
Reason = Literal["", "one_path", "fitted", "undetermined", "uncalibrated"]  # codes of verdicts


SPEEDS = {
    0.0: "at rest",
    0.01: "slow",
    0.25: "fast",
}  # name of a motion by the least speed of the flange [m/s]


@dataclass(frozen=True, kw_only=True)
class SmallestPush:
    """A row of pushes.csv: the push along an axis that the leading estimate detects with 95 %.

    motion: slow or fast (of the flange), or at rest (of the whole arm); axis: x, y or z of the
    base; value [N], with standard error and 95 % interval, empty if the trials do not determine it
    or the arm is fitted to a single path; bound: ">" if the push exceeds `largest_tried` [N];
    seconds: duration of a trial push [s]; trials: their number in this motion along this axis;
    blind: number of trials in poses in which two standard deviations of the joints' torques exceed
    the largest contact that the gate expects, three typical ones; they count nowhere else; basis:
    unseen if a recording that no fit has seen was tried, else fit; reason: one_path, undetermined,
    fitted (the value is from fit recordings only), or uncalibrated (without a fit).
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

    posture: one of all places of trials: stretched out or folded, with the flange farthest from the
    base's origin or nearest; easiest or hardest, with the smallest or largest push in the direction
    that joints feel least; or your own, at rest; recording, time_s, posture_deg: of this place,
    with the joints [°], the first two empty of your own;
    motion: see `SmallestPush`; plane, angle_deg: of the direction [°], horizontal from the base's x
    to its y, or vertical from x to z; unit: the push that changes the joints' torques by one
    standard deviation [N], empty if no joint feels any; value: unit times the number of units that
    all axes together need in this motion [N], with its standard error, empty if joints feel almost
    none (see `blind`) and beyond the largest trial.
    """

    posture: str
    recording: str
    time_s: float | None
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
    in a motion, along x, y and z together, by a logistic curve fitted to all but `blind` trials.
    """

    motion: str
    force: float
    share: float
