"""Recordings that were read: their content, their use, and their signals as frames."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from numbers import Integral
from typing import TYPE_CHECKING

import pandas as pd
from pydantic import ValidationError

from ur5lib.chain.by_joint import by_joint
from ur5lib.chain.shown import Shown, counted, frames
from ur5lib.chain.steps import Chain, Files
from ur5lib.channels import (
    EFFORT_CHANNELS,
    MOST_JOINTS,
    RECORDED_CHANNELS,
    UNKNOWN_UNIT,
    columns,
)
from ur5lib.errors import InputError, briefly, expect_known, expect_text, perhaps, printable, some
from ur5lib.jobs.memory import Content, record_of
from ur5lib.records.account import AccountRow
from ur5lib.records.quality import Finding, Quality
from ur5lib.robots.description import Robot
from ur5lib.strict import explain
from ur5lib.study.accept import Accept, joined
from ur5lib.study.model import Recording, Study
from ur5lib.study.selection import Selection
from ur5lib.tables import has_unit, read_footer, read_table, read_units, table_by_owner

if TYPE_CHECKING:
    import xarray

NO_USE = ("stop", "error")  # severities of findings that prevent a fit
UNIT_OF_THE_FILE = "unit of the file"  # of efforts of which nobody knows it


class Arm(Shown):
    """An arm as `ur5lib.read_arm` returns it; it shows the limits of its joints.

    name: in results; description: its joints, link models, drives and frames, in SI units, a
    `ur5lib.robots.description.Robot`.

        >>> ur5lib.read_arm("ur5e").description.rated_payload  # [kg]
        5.0
    """

    def __init__(self, name: str, description: Robot) -> None:
        """Take an arm's name and description; `ur5lib.read_arm` calls this."""
        self.name, self.description = name, description

    def _title(self) -> str:
        robot = self.description
        return (
            f"Arm {self.name}: {len(robot.joints)} joints, measures {robot.measured.quantity}s; "
            f"link models {', '.join(robot.models)}"
        )

    def summary(self) -> pd.DataFrame:
        """Return the limits of each joint: position [rad], speed [rad/s] and torque [Nm]."""
        robot = self.description
        low, high = zip(*robot.position_limits(), strict=True)
        return pd.DataFrame(
            {
                "joint": range(1, len(robot.joints) + 1),
                "from [rad]": low,
                "to [rad]": high,
                "speed [rad/s]": robot.velocity_limits(),
                "torque [Nm]": robot.torque_limits(),
            }
        ).round(3)


class Recordings(Shown):
    """Recordings of one arm, as `ur5lib.read` returns them; a loop over them yields each as
    `Recordings` of one.

    `runs["free1"]` is one of them, `runs["free1", "free2"]` are several, and `runs.fit`,
    `runs.validate` and `runs.contact` those of a role. A signal is a data frame (N, n) by `time`
    [s], of several recordings by `recording` and `time`, with its units in `attrs["units"]`. Raises
    InputError for unknown names, and for what was not recorded.

        >>> runs["free1"].current.attrs["units"]["actual_current_0"]
        'A'
        >>> [run.names for run in runs.fit]
        [['free1'], ['free2']]
    """

    def __init__(
        self,
        study: Study,
        arm: Files,
        files: Mapping[str, Files],
        qualities: Mapping[str, Quality],
    ) -> None:
        """Take what was read of each; `ur5lib.read` makes them."""
        self._study, self._arm, self._files, self._qualities = study, arm, files, qualities
        self._read_as: object = None  # how, for `read(..., like=)`

    @property
    def names(self) -> list[str]:
        """Return the names of the recordings."""
        return [*self._files]

    @property
    def robot(self) -> str:
        """Return the arm's name in results."""
        return next(iter(self._study.arms()))

    @property
    def roles(self) -> dict[str, str]:
        """Return the role of each recording: fit, validate or contact."""
        return {one.name: one.role for one in self._study.recordings}

    def __len__(self) -> int:
        """Return the number of recordings."""
        return len(self._files)

    def __iter__(self) -> Iterator[Recordings]:
        """Yield each recording as `Recordings` of one."""
        return map(self.__getitem__, self.names)

    def __getitem__(self, names: str | int | Sequence[str]) -> Recordings:
        """Return one recording, or several, in the order of these recordings.

        A number, from 0, is that of one. Raises InputError for an unknown name, and for no name.
        """
        asked = names if isinstance(names, list | tuple) and names else [names]
        if isinstance(names, Integral):
            asked = self.names[int(names) :][:1] if int(names) >= 0 else []
        if not asked:
            raise InputError(f"{len(self)} recordings have no number {names}, counted from 0")
        chosen = [expect_known("recording", name, self.names) for name in asked]
        entries = [one for one in self._study.recordings if one.name in chosen]
        return self._of(entries)

    @property
    def fit(self) -> Recordings:
        """Return the recordings of the role `fit`, to which models are fitted. Raises InputError if
        there are none.
        """
        return self._with_role("fit")

    @property
    def validate(self) -> Recordings:
        """Return the recordings of the role `validate`, without contact and used by no fit. Raises
        InputError if there are none.
        """
        return self._with_role("validate")

    @property
    def contact(self) -> Recordings:
        """Return the recordings of the role `contact`, in which something may touch the arm. Raises
        InputError if there are none.
        """
        return self._with_role("contact")

    def _with_role(self, role: str) -> Recordings:
        names = [name for name, own in self.roles.items() if own == role]
        if not names:
            raise InputError(
                f"none of {some(self.names)} has the role `{role}`; state it: "
                f'ur5lib.read(..., role={{"{self.names[0]}": "{role}"}})'
            )
        return self[names]

    @property
    def q(self) -> pd.DataFrame:
        """Return the measured angles, `actual_q_0` ... [rad]."""
        return self.channel("actual_q")

    @property
    def qd(self) -> pd.DataFrame:
        """Return the measured velocities, `actual_qd_0` ... [rad/s]."""
        return self.channel("actual_qd")

    @property
    def current(self) -> pd.DataFrame:
        """Return the motor currents, `actual_current_0` ... [A]."""
        return self.channel("actual_current")

    @property
    def torque(self) -> pd.DataFrame:
        """Return the torques of an arm that measures them, `actual_torque_0` ... [Nm]."""
        return self.channel("actual_torque")

    def channel(self, name: str) -> pd.DataFrame:
        """Return a channel on the robot's grid, e.g. `target_moment`.

        Raises InputError, with the channels there are, where no recording has it.
        """
        return self._frame("robot", expect_text(name, "channel"))

    def device(self, name: str) -> pd.DataFrame:
        """Return the samples of a device on its own clock: `robot`, `force` or `imu`."""
        return self._frame(expect_known("device", name, ["robot", "force", "imu"]))

    def findings(self) -> pd.DataFrame:
        """Return the findings in the files: recording, severity, and the sentence."""
        rows = [
            {"recording": name, "severity": one.severity, "detail": one.sentence()}
            for name in self.names
            for one in self._qualities[name].findings
        ]
        return pd.DataFrame(rows, columns=["recording", "severity", "detail"])

    def to_xarray(self, device: str = "robot") -> xarray.Dataset:
        """Return the samples of a device of one recording with a dimension `joint`, from 1 as in
        tables; see `device`.

        Raises InputError of several recordings, and without xarray, an extra.

            >>> runs["free1"].to_xarray()["actual_current"].sel(joint=3).attrs["units"]
            'A'
        """
        if len(self) > 1:
            raise InputError(f"{some(self.names)} have times of their own; take one of them")
        return by_joint(self.device(device))

    def check(self) -> pd.DataFrame:
        """Return the findings in the files, as `findings` does, where they may be used.

        Raises InputError that lists the stop signs and errors, where `ur5 check` would fail.

            >>> [*runs.check()]
            ['recording', 'severity', 'detail']
        """
        stops = {name: self._stop_signs(name) for name in self.names}
        lines = [f"{name}: {one.sentence()}" for name, own in stops.items() for one in own]
        if lines:
            raise InputError("\n".join(lines))
        return self.findings()

    @property
    def account(self) -> pd.DataFrame:
        """Return how import interpreted each column: recording, and the columns of an `AccountRow`,
        subject, taken_for, evidence, confidence and reason.
        """
        rows = {one.name: one.account for one in self._study.recordings}
        return table_by_owner(AccountRow, rows)

    def line(self, name: str) -> str:
        """Return one line on how import interpreted the columns of a recording, and what to
        check.
        """
        own = self.account.query("recording == @name and confidence != 'evidence'")
        whole = own["subject"] == "columns"  # of a file that is read like another
        channels = own["taken_for"].map(lambda taken: has_unit(taken.partition(" ")[0]))
        read = own["taken_for"][whole | channels]
        checks = own[own["confidence"] == "check"]
        words = "".join(f"; check {row.subject}: {row.taken_for}" for row in checks.itertuples())
        return printable(f"{name}: {self.roles[name]}, {', '.join(read)}{words}")

    def _accepting(self, reasons: Mapping[str, str] | None) -> Recordings:
        """Return the recordings with further reasons to overrule stop signs; reasons: by kind, as
        `accept` of a study, None for no further ones.

        Raises InputError for an unknown kind, and for a kind without a reason.
        """
        if reasons is None:
            return self
        if not isinstance(reasons, Mapping):
            raise InputError(
                f'accept: {briefly(reasons)} has no kinds; write {{"order": "why it is right"}}'
            )
        if bare := [kind for kind, reason in reasons.items() if not isinstance(reason, str)]:
            raise InputError(f"accept: {some(bare)} without a reason; write why, as text")
        try:
            general = Accept.model_validate(dict(reasons))
        except ValidationError as error:
            schema = Accept.model_json_schema()
            mistakes = "; ".join(explain(one, schema) for one in error.errors())
            raise InputError(f"accept: {mistakes}") from error
        entries = [
            one.model_copy(update={"accept": joined(general, one.accept)})
            for one in self._study.recordings
        ]
        return self._of(entries)

    def _timing(self, name: str) -> Quality:
        """Return timing and findings of a recording's file, as they were read."""
        quality: Quality = record_of(Quality, self._files[name]["quality"])
        return quality

    def _with(self, **changes: object) -> Recordings:
        """Return the recordings with changes to their entries."""
        return self._of([one.model_copy(update=changes) for one in self._study.recordings])

    def _of(self, entries: Sequence[Recording]) -> Recordings:
        """Return the recordings that have one of some entries in their study."""
        study = self._study.model_copy(update={"recordings": entries})
        files = {one.name: self._files[one.name] for one in entries}
        chosen = Recordings(study, self._arm, files, self._qualities)
        chosen._read_as = self._read_as
        return chosen

    def _chain(self, study: Study) -> Chain:
        """Return a `Chain` that runs steps on these recordings, with copies of the results
        so far.
        """
        files = {name: dict(own) for name, own in self._files.items()}
        selection = Selection(study)
        return Chain(selection, self.robot, dict(self._arm), files, {})

    def _frame(self, file: str, channel: str = "") -> pd.DataFrame:
        parts = {
            name: own[file]
            for name, own in self._files.items()
            if file in own and not isinstance(own[file], str)
        }
        every = {name: read_footer(one).schema.names for name, one in parts.items()}
        asked = {*columns(channel, MOST_JOINTS)}
        chosen = {n: [c for c in own if c in asked or not channel] for n, own in every.items()}
        have = {name: own for name, own in chosen.items() if {*own} - {"time"}}
        if not have:
            present = {column for own in every.values() for column in own} - {"time"}
            there = [n for n in RECORDED_CHANNELS if present & {*columns(n, MOST_JOINTS)}]
            recorded = f"{perhaps(channel, there)}; recorded: {', '.join(there)}" if channel else ""
            raise InputError(
                f"{', '.join(self.names)}: no {channel or file} was recorded{recorded}"
            )
        return frames({name: frame_of(parts[name], own) for name, own in have.items()})

    def _title(self) -> str:
        duration = sum(self._qualities[name].duration_s for name in self.names)
        stopped = [name for name in self.names if self._stop_signs(name)]
        unused = (
            f"; not used, for a stop sign (see findings()): {', '.join(stopped)}" if stopped else ""
        )
        return f"{counted(len(self), 'recording')} of {self.robot}, {duration:.0f} s{unused}"

    def _stop_signs(self, name: str) -> list[Finding]:
        return [one for one in self._qualities[name].findings if one.severity in NO_USE]

    def summary(self) -> pd.DataFrame:
        """Return role, length, rate and worst finding of each recording."""
        rows = []
        for name in self.names:
            quality = self._qualities[name]
            worst = self._stop_signs(name) or quality.findings[:0]
            count = {
                level: sum(one.severity == level for one in quality.findings)
                for level in ("warning", "note")
            }
            minor = ", ".join(counted(n, level) for level, n in count.items() if n)
            rows.append(
                {
                    "recording": name,
                    "role": self.roles[name],
                    "duration [s]": round(quality.duration_s, 1),
                    "rate [Hz]": round(1 / quality.period_s) if quality.period_s > 0 else None,
                    "devices": " ".join(quality.devices),
                    "found": worst[0].sentence() if worst else minor or "nothing",
                }
            )
        return pd.DataFrame(rows)


def as_recordings(recordings: object) -> Recordings:
    """Return recordings unchanged, a list of them as one. Raises InputError for anything but the
    result of `ur5lib.read`, and for different recordings of one name.
    """
    if isinstance(recordings, list | tuple) and {*map(type, recordings)} == {Recordings}:
        first = recordings[0]
        entries = [entry for one in recordings for entry in one._study.recordings]
        named = dict[str, Recording]()
        for one in entries:
            if named.setdefault(one.name, one) != one:
                raise InputError(
                    f"two recordings are named {one.name}; read them together, by names of their "
                    "own: ur5lib.read({name: file, …})"
                )
        files = {name: own for one in recordings for name, own in one._files.items()}
        study = first._study.model_copy(update={"recordings": entries})
        qualities = {name: one._qualities[name] for one in recordings for name in one.names}
        return Recordings(study, first._arm, files, qualities)
    if not isinstance(recordings, Recordings):
        raise InputError(
            f"{briefly(recordings)} is no recording that was read; put it through ur5lib.read first"
        )
    return recordings


def forces_of(content: Content) -> pd.DataFrame:
    """Return the estimated contact wrenches as a data frame by `time`; NaN where an estimate states
    nothing.

    The file has zeros there, for example of gated least squares outside contacts.
    """
    frame = frame_of(content)
    for std in [name for name in frame if "_std_" in name]:
        stated = frame[std] != 0
        for name in (std, std.replace("_std_", "_")):
            frame[name] = frame[name].where(stated)
    return frame


def frame_of(content: Content, columns: list[str] | None = None) -> pd.DataFrame:
    """Return a table of samples with `time` [s] as index, and its units in `attrs["units"]`.

    columns: to read in addition to the time; None: all.
    """
    assert not isinstance(content, str), "a table is no text"
    names = None if columns is None else ["time", *(c for c in columns if c != "time")]
    frame = read_table(content, names).set_index("time")
    units = read_units(content)
    if UNKNOWN_UNIT in units:
        units |= {one: UNIT_OF_THE_FILE for one in units if one.startswith(EFFORT_CHANNELS)}
    frame.attrs["units"] = {name: units[name] for name in ("time", *map(str, frame.columns))}
    return frame
