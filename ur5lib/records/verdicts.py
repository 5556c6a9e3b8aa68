"""Verdicts: what may be used, the number that decides, and the reason."""

from dataclasses import dataclass
from enum import StrEnum
from typing import Literal, cast, get_args

from ur5lib.channels import CURRENT, Effort
from ur5lib.errors import printable

State = Literal["good", "usable", "do not use", "not determined"]
STATES: dict[State, str] = {  # what they mean to who copies a number
    "good": "copy it",
    "usable": "with this doubt",
    "do not use": "do not use",
    "not determined": "not known",
}
COPIED = ("constants", "friction")  # questions whose numbers a reader copies
NO_DOUBT = "no doubt"  # what `good` means of all others
Use = Literal["yes", "no"]
Sense = Literal[
    "", "less", "more", "ratio", "error", "change", "from", "beyond", "at most", "at least"
]
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
    "excludes",
    "imprecise",
    "extrapolated",
    "constant",
    "undetermined",
    "worse_than_zero",
    "large_error",
    "too_small",
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
    "no_contact",
    "no_reference",
    "no_effort",
    "no_motion",
    "no_unseen",
    "one_path",
    "fitted",
    "touched",
    "felt",
    "short",
    "changed",
    "few_dates",
    "loaded",
    "disagrees",
    "load_unsure",
    "other_friction",
    "uncalibrated",
    "unknown_links",
    "not_run",
]
REASONS: dict[str, str] = {  # a sentence each; {quantity} and {constant} as of the arm's effort
    "stopped": "A recording contradicts the study (stop sign).",
    "unread": "Its file cannot be used, or repeats another one.",
    "error": "A recording has an error: what it concerns is not used.",
    "warning": "Files have warnings.",
    "contradicted": "The {quantity}s contradict the known {constant}, which is used instead.",
    "unlikely": "The {constant} contradicts the known one, and forces are computed with it.",
    "unproven": "Fits to other paths predict the {quantity} worse than a constant.",
    "prior_only": "The value rests mostly on other arms.",
    "far": "The {constant} is farther from the known one than on 95 % of arms.",
    "excludes": "The 95 % interval excludes the known {constant}.",
    "imprecise": "It is known within ± 50 % or worse.",
    "extrapolated": "No fit recording moves as fast.",
    "constant": "The {constant} of the joint is in doubt.",
    "undetermined": "The recordings do not determine it.",
    "worse_than_zero": "The error is not below that of zero or of a constant.",
    "large_error": "The error is a large part of that of zero or of a constant.",
    "too_small": "What is measured is too small to judge an error by.",
    "rival_better": "The simple method errs less.",
    "rival_equal": "The simple method does about as well.",
    "far_above_floor": "On repeated motions, the error is more than three times the repeatability.",
    "wide_interval": "The 95 % interval of the error is unknown, or reaches half of the force.",
    "undercovers": "The 95 % band contains less than 90 % of the readings.",
    "too_wide": "The 95 % band is more than twice as wide as needed.",
    "blind": "In contact, the 95 % band contains zero for more than half of the time.",
    "sensor_bias": "The bias of the force sensor is uncertain.",
    "saturated": "The force sensor is saturated.",
    "no_sensor": "No working force sensor was recorded.",
    "no_contact": "The force sensor reads no contact on a recording outside the fit.",
    "no_reference": "Nothing was recorded to compare it with.",
    "no_effort": "No {quantity} was recorded.",
    "no_motion": "Nothing moves.",
    "no_unseen": "No recording outside the fit tests it.",
    "one_path": "All fit recordings follow one path, so that no error bar is tested.",
    "fitted": "The fit has used the recording.",
    "touched": "The force sensor reads contacts, although the role denies them.",
    "felt": "More contacts are found than false alarms explain, although the role is fit.",
    "short": "The recordings are too short to promise fewer than one a minute.",
    "changed": "It changed between dates by more than chance explains.",
    "few_dates": "Too few dates repeat a path of another date.",
    "loaded": "The arm carries an undeclared load.",
    "disagrees": "The load of more recordings than by chance differs from the declared one.",
    "load_unsure": "The load is known within ± a tenth of the rated payload or worse.",
    "other_friction": "Friction is unlike that of the fit.",
    "uncalibrated": "No friction was fitted.",
    "unknown_links": "The links are unknown, and only products of gain and link are determined.",
    "not_run": "The results have no verdicts; run the study again.",
}
assert {"", *REASONS} == {*get_args(Reason)}


def reason_in(cell: object) -> Reason:
    """Return the code of a reason from a table's cell, "" for an empty cell."""
    return cast("Reason", cell) if isinstance(cell, str) else ""


def state_in_words(state: State, question: str) -> str:
    """Return a state as the page words it of a question."""
    if state == "good" and question not in COPIED:
        return NO_DOUBT
    return STATES.get(state, state)


def reason_in_words(cell: object, effort: Effort = CURRENT) -> str:
    """Return the sentence of a reason in a table's cell, "" for an empty cell.

    effort: measured by the arm. An unknown reason, as of a later version, stays a code.
    """
    if not isinstance(cell, str):  # NaN
        return ""
    if cell not in REASONS:
        return printable(cell)
    return REASONS[cell].format(quantity=effort.quantity, constant=effort.constant)


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """A row of verdicts.csv: a number that answers a question about an arm, or the whole study.

    question: recordings, constants, friction, currents, links, motion, force, bands, contacts,
    alarms, pushes, load, or of a topic; arm: empty of the whole study; rank: 1 decides, others are
    further numbers; state: empty of a number without one; reason: why not better; quantity: what
    the number is, in words; low, high: ends of the interval that `interval` names; joint, axis,
    recording, motion (at rest, slow, fast, in motion): its place; zero: the same of an estimate of
    zero or a constant; rival, rival_value: the simple method and its number; floor: repeatability;
    count, of: how many of how many; basis: real, trial, unseen or fit; sense: which numbers are
    good: less or more; a ratio is best at 1, an error or a change with its sign at 0 (below: too
    small, or fallen); from: it holds from this number on; beyond: it, or its high end, is larger;
    at most, at least: a limit of it; posture: the joints [°] at which it holds. Without value and
    count, low to high is the number.
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
    sense: Sense = ""
    posture: str = ""


@dataclass(frozen=True, kw_only=True)
class RecordingUse:
    """A row of uses.csv: whether a recording may serve a purpose, and why not, or with which doubt.

    purpose: fit, currents, load, links, force, contacts, motion; all of one that serves none.
    """

    recording: str
    purpose: str
    use: Use
    reason: Reason = ""


@dataclass(frozen=True, kw_only=True)
class JudgedError:
    """A row of judged_errors.csv: an error at one joint or component by which a question is judged.

    error: mean over `recordings`, from low to high; zero: of an estimate of zero or a constant;
    model: which was judged; rival, rival_error: the simple method; floor: repeatability, with the
    error on the same repeats as a multiple of it (`in_floors`); coverage95: least share in the 95 %
    band, band_factor95: largest and least_factor95: least multiple of it that contains 95 %;
    largest: the largest error, on `recording`, where zero errs by `largest_zero`; torque: the error
    of a current as a torque [Nm].
    """

    question: str
    robot: str
    joint: int | None = None
    component: str = ""
    model: str = ""
    unit: str
    error: float
    low: float
    high: float
    recordings: int
    zero: float
    rival: str = ""
    rival_error: float | None = None
    floor: float | None = None
    in_floors: float | None = None
    coverage95: float | None = None
    band_factor95: float | None = None
    least_factor95: float | None = None
    largest: float
    recording: str
    largest_zero: float
    torque: float | None = None
    largest_torque: float | None = None
    state: State
    reason: Reason = ""


@dataclass(frozen=True, kw_only=True)
class ModelError:
    """A row of model_errors.csv: errors of a link model, means over recordings [Nm]."""

    robot: str
    motion: str
    model: str
    joint: int
    mae: float
    mae_2hz: float
    zero_mae: float
    zero_mae_2hz: float


@dataclass(frozen=True, kw_only=True)
class FalseAlarms:
    """A row of false_alarms.csv: alarms where nothing touches the arm and no load is undeclared.

    role: fit or validate; days: all, without fit (without a fit recording), or farthest (from one);
    per_min, per_min_high: rate, and its upper limit (95 %, Poisson).
    """

    role: str
    estimate: str
    days: str
    recordings: int
    minutes: float
    alarms: int
    per_min: float
    per_min_high: float


@dataclass(frozen=True, kw_only=True)
class Noticed:
    """A row of noticed.csv: contacts at the sensor of a recording, and its alarms.

    contacts: that reach 5 N, of which found by an alarm of their own, merged (within another one's)
    and missed; missed_s, merged_s: their starts [s]; largest_missed,
    smallest_found: peaks [N]; peak_bias: mean relative error of the found peaks; alarms: all,
    false_alarms: as in detection.csv, without a sensor those of the kind false, empty of a contact
    recording; untouched_n, hidden_n, hidden_at_all_n: where no contact is found, and
    unseen_link_2_n, unseen_link_3_n: at rest before the wrist, as in detection.csv; band: the
    widest 95 % band of an alarm's largest force, half of it [N] along band_axis at band_s in a
    posture [°].
    """

    recording: str
    role: str
    contacts: int
    found: int
    merged: int
    missed: int
    missed_s: str = ""
    merged_s: str = ""
    largest_missed: float | None = None
    smallest_found: float | None = None
    peak_bias: float | None = None
    alarms: int
    alarms_per_min: float
    false_alarms: int | None
    untouched_n: float | None = None
    hidden_n: float | None = None
    hidden_at_all_n: float | None = None
    unseen_link_2_n: float | None = None
    unseen_link_3_n: float | None = None
    band: float | None = None
    band_axis: str = ""
    band_s: float | None = None
    posture_deg: str = ""


@dataclass(frozen=True, kw_only=True)
class ErrorParts:
    """A row of error_parts.csv: parts of a force's error in contact [N], means over x, y, z.

    error = missed + late_alarms + gain + friction; share: of the mean force; sensor_bias: sure or
    uncertain; drift_x to drift_z: of the bias [N/min], where determined within 1 N/min (drift_std).
    """

    recording: str
    error: float
    share: float
    missed: float
    late_alarms: float
    gain: float
    friction: float
    sensor_bias: str
    drift_x: float | None = None
    drift_y: float | None = None
    drift_z: float | None = None
    drift_std: float | None = None


class Asks(StrEnum):
    """What to do next; `ASKED` in `ur5lib/report/next_steps.py` has the sentences."""

    STOP_RECORDING = "stop_recording"
    STOP_ARM = "stop_arm"
    TOUCHED = "touched"
    FELT = "felt"
    HIDDEN = "hidden"
    PAYLOAD = "payload"
    EXPLAINED = "explained"
    CONTRADICTION = "contradiction"
    NO_EFFORT = "no_effort"
    LOSSY = "lossy"
    DOUBTED = "doubted"
    UNKNOWN_LINKS = "unknown_links"
    NO_MOTION = "no_motion"
    ONE_PATH = "one_path"
    FEW_PATHS = "few_paths"
    FIT = "fit"
    VALIDATE = "validate"
    ADVISED = "advised"
    LIGHT = "light"
    PUSHES = "pushes"


@dataclass(frozen=True, kw_only=True)
class Advice:
    """A row of advice.csv: what to do next, the most urgent first.

    code: of the sentence; kind: correction, recording (what to record), or later, after what
    topics propose; recording: the first of `recordings`; joints: numbers with blanks between;
    value, std_error: the number in the sentence; detail: words of the finding.
    """

    code: Asks
    kind: Literal["correction", "recording", "later"]
    robot: str = ""
    recording: str = ""
    recordings: int = 0
    joints: str = ""
    value: float | None = None
    std_error: float | None = None
    detail: str = ""
