"""Findings about the quality of a recording."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from itertools import chain
from pathlib import Path
from typing import Literal, SupportsInt, TypeVar

from ur5lib.errors import InputError, overrulable, printable
from ur5lib.records.account import AccountRow
from ur5lib.records.codes import CauseCode, Found

T = TypeVar("T")
Device = Literal["robot", "force", "imu"]
Severity = Literal["stop", "error", "warning", "note"]
# Largest share of target_moment that the right arm's model may not explain; measured: 0.063.
MAX_SHARE_UNMODELLED = 0.15
# A larger residual, as a share of the motor's largest torque, is a contact. In recordings without
# contact, it is at most 0.071, without the worst arm 0.061.
CONTACT_TORQUE_SHARE = 0.1
STOP = "stop sign"  # in place of a remark's step: no forces are stated for the arm
UNCHECKED = (  # findings that something could not be checked, the riskiest first
    Found.NOTHING_CHECKED,
    Found.ARM_NOT_CHECKED,
    Found.ORDER_NOT_CHECKED,
    Found.CURRENTS_NOT_CHECKED,
    Found.UNIT_NOT_CHECKED,
    Found.SIZE_NOT_CHECKED,
    Found.SIGN_NOT_CHECKED,
    Found.COLUMNS_NOT_CHECKED,
    Found.TORQUES_NOT_CHECKED,
    Found.CLOCK_NOT_CHECKED,
    Found.CONTACT_NOT_CHECKED,
)
SENSORS: dict[str, Device] = {"force_sensor": "force", "imu": "imu"}  # their keys in the study


@dataclass(frozen=True)
class Finding:
    """A finding: one kind of defect in one device's files.

    severity: stop (the recording contradicts the study), error (the device is unusable), warning
    (results may suffer), note (harmless); count: number of samples, rows or files; detail: the
    sentence about it, made printable, since it quotes hostile files; place: in a file, with which
    the sentence starts; kind: name by which a study accepts a stop sign, "" if it cannot; cause,
    joints (from 1), channels: those concerned, if other code depends on them.
    """

    device: Device
    code: Found
    severity: Severity
    count: int
    detail: str
    place: str = ""
    kind: str = ""
    cause: CauseCode | None = None
    joints: tuple[int, ...] = ()
    channels: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        """Make the words printable."""
        object.__setattr__(self, "detail", printable(self.detail))
        object.__setattr__(self, "place", printable(self.place))

    def sentence(self) -> str:
        """Return the sentence about the finding; for a stop sign, with how to overrule it."""
        return overrulable(self.detail, self.kind)


@dataclass(frozen=True)
class StartOffset:
    """The delay of a device's clock after the robot's, by the start stamps [s].

    drift_std: for samples stamped by the robot's host; 0 for the robot's own clock; None for
    others.
    """

    seconds: float
    std: float
    drift_std: float | None = None


def add_finding(
    findings: list[Finding],
    device: Device,
    code: Found,
    severity: Severity,
    count: SupportsInt,
    detail: str,
    channels: Sequence[str] = (),
) -> None:
    """Add a finding unless its count is 0."""
    if count:
        found = Finding(device, code, severity, int(count), detail, channels=(*channels,))
        findings.append(found)


@dataclass(frozen=True, kw_only=True)
class Quality:
    """quality.json: the size and timing of a recording, its files and what is wrong with them.

    rows: as read; frames: after the repair; jitter_s: of the time stamps, "median" and "99 %";
    start_epoch_s: zero of the robot's clock, since 1970; starts: of the other devices; files:
    SHA-256 of the devices' files, read: of all files, by their path; fingerprint: hashes of the
    robot's rows, efforts: of its efforts; account: channels that import assigned to the columns;
    ends: first and last row, as text.
    """

    rows: int = 0
    frames: int = 0
    duration_s: float = 0.0
    period_s: float = float("nan")
    longest_step_s: float = float("nan")
    jitter_s: dict[str, float] = field(default_factory=dict)
    start_epoch_s: float | None = None
    devices: list[Device] = field(default_factory=list)
    starts: dict[Device, StartOffset] = field(default_factory=dict)
    files: dict[Device, str] = field(default_factory=dict)
    findings: list[Finding] = field(default_factory=list)
    read: dict[str, str] = field(default_factory=dict)
    fingerprint: list[int] = field(default_factory=list)
    efforts: str = ""
    account: list[AccountRow] = field(default_factory=list)
    ends: str = ""

    def saturated_channels(self) -> list[str]:
        """Return the force sensor's channels that stay at their largest value."""
        return [
            name
            for one in self.findings
            if (one.device, one.code) == ("force", Found.SATURATION)
            for name in one.channels
        ]


@dataclass(frozen=True)
class Contradictions:
    """Contradictions between a recording and the study, and doubts about the recording.

    stop_signs: contradictions that forbid to state forces; findings: about its payload, its tool,
    its length and the targets of its currents.
    """

    stop_signs: list[Finding] = field(default_factory=list)
    findings: list[Finding] = field(default_factory=list)

    def odd_targets(self) -> list[int]:
        """Return the joints, from 1, with a `target_current` that does not match their motors."""
        odd = (one.joints for one in self.findings if one.code == Found.ODD_TARGET)
        return [*chain.from_iterable(odd)]


@dataclass(frozen=True)
class Log:
    """The findings on a file of a device, collected while it is read."""

    path: Path
    device: Device
    findings: list[Finding]

    def add(
        self,
        code: Found,
        severity: Severity,
        count: SupportsInt,
        meaning: str,
        line: str = "",
        channels: Sequence[str] = (),
    ) -> None:
        """Add a finding, with the file's name before its meaning, unless its count is 0; line:
        place in the file.
        """
        if count:
            place = f"{self.path.name}, line {line}" if line else self.path.name
            told = f"{place}: {meaning}", place
            found = Finding(self.device, code, severity, int(count), *told, channels=(*channels,))
            self.findings.append(found)

    def unless_unusable(self, read: Callable[[], T | None]) -> T | None:
        """Return the result of `read`, which reads a sensor; None, with a finding added, if it
        raises InputError.
        """
        try:
            return read()
        except InputError as error:
            detail = f"{error}; not used"
            self.findings.append(Finding(self.device, Found.UNUSABLE_SENSOR, "error", 1, detail))
            return None


def contradiction(cause: CauseCode, kind: str, detail: str, joints: Sequence[int] = ()) -> Finding:
    """Return a stop sign: a contradiction of the study that forbids to state forces.

    kind: name by which a study accepts it (`Accept`); joints: those concerned, from 1.
    """
    named = (*joints,)
    return Finding("robot", Found.CONTRADICTION, "stop", 1, detail, "", kind, cause, named)
