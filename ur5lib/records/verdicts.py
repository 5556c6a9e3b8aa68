"""Verdicts: what may be used, the number that decides, and the reason."""

from dataclasses import dataclass
from typing import Literal, get_args

State = Literal["good", "usable", "do not use", "not determined"]
Use = Literal["yes", "no"]
Reason = Literal[
    "",
    "stopped",
    "unread",
    "error",
    "warning",
    "contradicted",
    "unlikely",
    "unproven",
    "prior_only",
    "far",
    "undetermined",
    "worse_than_zero",
    "rival_better",
    "rival_equal",
    "far_above_floor",
    "wide_interval",
    "undercovers",
    "too_wide",
    "blind",
    "sensor_bias",
    "saturated",
    "no_sensor",
    "no_motion",
    "no_unseen",
    "one_path",
    "fitted",
    "touched",
    "loaded",
    "other_friction",
    "uncalibrated",
    "unknown_links",
    "not_run",
]
REASONS: dict[str, str] = {  # a sentence each; {quantity} and {constant} as of the arm's effort
    "stopped": "A recording contradicts the study (stop sign).",
    "unread": "Its file cannot be used, or repeats another one.",
    "error": "A file has an error: what it concerns is not used.",
    "warning": "Files have warnings.",
    "contradicted": "The {quantity}s contradict the known {constant}, which is used instead.",
    "unlikely": "The {constant} contradicts the known one, and forces are computed with it.",
    "unproven": "Fits to other paths predict the {quantity} worse than a constant.",
    "prior_only": "The value rests mostly on other arms.",
    "far": "The {constant} is farther from the known one than on 95 % of arms.",
    "undetermined": "The recordings do not determine it.",
    "worse_than_zero": "The error is not below that of zero or of a constant.",
    "rival_better": "The simple method errs less.",
    "rival_equal": "The simple method does about as well.",
    "far_above_floor": "The error is more than three times the repeatability.",
    "wide_interval": "The 95 % interval of the error is too wide, or unknown.",
    "undercovers": "The 95 % band contains less than 90 % of the readings.",
    "too_wide": "The 95 % band is more than twice as wide as needed.",
    "blind": "In contact, the 95 % band contains zero for more than half of the time.",
    "sensor_bias": "The bias of the force sensor is uncertain.",
    "saturated": "The force sensor is saturated.",
    "no_sensor": "No working force sensor was recorded.",
    "no_motion": "Nothing moves.",
    "no_unseen": "No recording outside the fit tests it.",
    "one_path": "All fit recordings follow one path, so that no error bar is tested.",
    "fitted": "The fit has used the recording.",
    "touched": "The force sensor reads contacts, although the role says that nothing touches the arm.",
    "loaded": "The arm carries an undeclared load.",
    "other_friction": "Friction is unlike that of the fit.",
    "uncalibrated": "No friction was fitted.",
    "unknown_links": "The links are unknown, and only products of gain and link are determined.",
    "not_run": "The results have no verdicts; run the study again.",
}
assert {"", *REASONS} == {*get_args(Reason)}


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """A row of verdicts.csv: a number that answers a question about an arm, or the whole study.

    question: recordings, constants, friction, currents, links, motion, force, bands, contacts,
    alarms, pushes, load, or of a topic; arm: empty of the whole study; rank: 1 decides, others are
    further numbers; state: empty of a number without one; reason: why not better; quantity: what
    the number is, in words; low, high: ends of the interval that `interval` names; joint, axis,
    recording, motion (at rest, slow, fast, in motion): its place; zero: the same of an estimate of
    zero or a constant; rival, rival_value: the simple method and its number; floor: repeatability;
    count, of: how many of how many; basis: real, trial, unseen or fit.
    """

    question: str
    arm: str = ""
    rank: int = 1
    state: State | None = None
    reason: Reason = ""
    quantity: str = ""
    value: float | None = None
    unit: str = ""
    low: float | None = None
    high: float | None = None
    interval: str = ""
    joint: int | None = None
    axis: str = ""
    recording: str = ""
    motion: str = ""
    zero: float | None = None
    rival: str = ""
    rival_value: float | None = None
    floor: float | None = None
    count: int | None = None
    of: int | None = None
    basis: Literal["", "real", "trial", "unseen", "fit"] = ""


@dataclass(frozen=True, kw_only=True)
class RecordingUse:
    """A row of uses.csv: whether a recording may serve a purpose, and why not, or with which doubt.

    purpose: fit, currents, load, links, force, contacts, motion; all of one that serves none.
    """

    recording: str
    purpose: str
    use: Use
    reason: Reason = ""
