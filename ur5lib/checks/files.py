"""What tables show of a recording's files: their size, clocks and findings, and copies of files."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, cast

import numpy as np
import pandas as pd

from ur5lib.checks.parts_of_runs import parts_seen
from ur5lib.recordings.copies import same_runs, spare_copy
from ur5lib.records.account import NOTHING
from ur5lib.records.clocks import SettledClock
from ur5lib.records.codes import Found
from ur5lib.records.judgement import ClockRow, FileRead, QualityRow, RecordingSummary
from ur5lib.records.phrases import number
from ur5lib.records.quality import Contradictions, Device, Finding, Quality
from ur5lib.records.signals import Signals

TRAVEL = 0.02  # rad; the ends of a moving joint's path are this far apart


def summary(quality: Quality, signals: Signals | None) -> RecordingSummary:
    """Return a recording's size, duration, time steps, devices and moving joints.

    Postures at rest have no signals.
    """
    moving = moving_joints(signals) if signals else []
    return RecordingSummary(
        duration_s=quality.duration_s,
        rows_read=quality.rows,
        frames=quality.frames,
        longest_step_s=quality.longest_step_s,
        jitter_s=quality.jitter_s["99 %"],
        devices=" ".join(quality.devices),
        moving_joints=" ".join(map(str, moving)),
    )


def moving_joints(signals: Signals) -> list[int]:
    """Return the joints, from 1, that do not rest throughout a recording."""
    travel = np.nanmax(signals.actual_q, axis=0) - np.nanmin(signals.actual_q, axis=0)
    return [int(joint) + 1 for joint in np.flatnonzero(travel > TRAVEL)]


def files_read(quality: Quality) -> list[FileRead]:
    """Return the files that a recording was read from."""
    return [FileRead(file=file, sha256=checksum) for file, checksum in quality.read.items()]


def clock_rows(clocks: Mapping[str, SettledClock]) -> list[ClockRow]:
    """Return offset and drift of each device's clock against the robot's."""
    return [
        ClockRow(
            device=device,
            offset_s=clock.offset,
            offset_std_s=clock.offset_std,
            drift_ppm=clock.drift and 1e6 * clock.drift,
            drift_std_ppm=clock.drift_std and 1e6 * clock.drift_std,
            method=clock.method,
            end_std_s=clock.end_std,
        )
        for device, clock in clocks.items()
    ]


def findings(
    quality: Quality,
    contradictions: Contradictions | None = None,
    clocks: Mapping[str, SettledClock] | None = None,
) -> list[Finding]:
    """Return the findings about a recording's files and about clocks without a measured drift.

    Among them are a note for each device's file, with its checksum and the count 1 if it is used,
    else 0, and those with the fingerprints of the robot's rows and efforts: `name_copies` keeps
    those that several recordings have.
    """
    contradictions = contradictions or Contradictions()
    found = [*contradictions.stop_signs, *quality.findings, *contradictions.findings]
    for row in quality.account:
        for columns in row.subject.split(", ") if row.taken_for == NOTHING else ():
            why = f"{columns}: {row.reason}", columns
            found.append(Finding("robot", Found.COLUMNS_NOT_USED, "note", 1, *why))
    for device, checksum in quality.files.items():
        used = int(device in quality.devices)
        found.append(Finding(device, Found.SAME_FILE, "note", used, checksum))
    fingerprint = " ".join(map(str, quality.fingerprint))
    found.append(Finding("robot", Found.SAME_RUN, "note", 0, fingerprint))
    found.append(Finding("robot", Found.ENDS, "note", 0, quality.ends))
    found.append(Finding("robot", Found.REPEATED_COMMAND, "note", 0, quality.efforts))
    for sensor, clock in (clocks or {}).items():
        found += _doubts_of(cast(Device, sensor), clock)
    return found


def _doubts_of(device: Device, clock: SettledClock) -> Iterator[Finding]:
    """Yield a warning of a clock without a measured drift."""
    start, end = number(clock.offset_std, ".2g"), number(clock.end_std, ".2g")
    accurate = f"accurate to {start} s at the start and {end} s at the end"
    if clock.warning is not None:
        detail = f"{clock.warning.text}; {accurate}"
        yield Finding(device, Found.CLOCK_BY_STAMPS_ALONE, "warning", 1, detail)
    elif clock.drift is None:
        detail = (
            f"its clock is known from its start stamp only, {accurate}; if one computer timestamps "
            "both this device and an IMU, list both under `hosts`"
        )
        yield Finding(device, Found.UNKNOWN_DRIFT, "warning", 1, detail)


def quality_row(finding: Finding) -> QualityRow:
    """Return a finding as a row of quality.csv."""
    names = ("device", "severity", "count", "place", "code")
    own: dict[str, Any] = {name: getattr(finding, name) for name in names}
    return QualityRow(finding=finding.code.words, detail=finding.sentence(), **own)


def unreadable(reason: str) -> QualityRow:
    """Return the row of quality.csv with the stop sign of a recording that cannot be read."""
    return quality_row(Finding("robot", Found.UNREADABLE, "stop", 1, reason))


def spare_copies(quality: pd.DataFrame, roles: Mapping[str, str]) -> list[str]:
    """Return the recordings that are left out because they are of the same run as another one.

    quality: with all robots' rows; roles: of all recordings, by name.
    """
    pairs = _same_runs(quality[quality["code"] == Found.SAME_RUN])
    return [name for pair in pairs if (name := spare_copy(pair, roles))]


def name_copies(quality: pd.DataFrame, roles: Mapping[str, str] | None = None) -> pd.DataFrame:
    """Return the findings of all recordings; those on files, runs and efforts only if several
    recordings have them.

    quality: with the notes on all device files and robots' rows; the finding of each copy names the
    other recordings; roles: by recording, which decide whether a copy is left out or a stop sign.
    """
    kinds = Found.SAME_FILE, Found.SAME_RUN, Found.ENDS, Found.REPEATED_COMMAND
    files, runs, ends, efforts = (quality[quality["code"] == kind] for kind in kinds)
    alike = files.groupby(["device", "detail"], sort=False)
    copies = {at: _copy(files.loc[at], own) for _, own in alike if len(own) > 1 for at in own.index}
    repeated = _repeated(runs, roles or {})
    copies |= repeated | _neighbours(ends, roles or {})
    copies |= _commanded_again(efforts, [row["recording"] for row in repeated.values()])
    others = quality.drop([*files.index, *runs.index, *ends.index, *efforts.index])
    named = pd.DataFrame([*copies.values()], [*copies], quality.columns)
    return pd.concat([others, named]).sort_index() if copies else others


def _same_runs(runs: pd.DataFrame) -> Iterator[tuple[str, str]]:
    """Yield the pairs of recordings of one run; runs: the findings with the fingerprints of their
    rows.
    """
    by_name = zip(runs["recording"], runs["detail"].fillna("").astype(str), strict=True)
    yield from same_runs({name: [*map(int, rows.split())] for name, rows in by_name})


def _repeated(runs: pd.DataFrame, roles: Mapping[str, str]) -> dict[Any, dict[str, Any]]:
    """Return, by index of `runs`, the findings on runs that several recordings contain."""
    holders: dict[str, set[str]] = {name: {name} for name in runs["recording"]}
    spare, standing = list[str](), set[str]()
    for pair in _same_runs(runs):
        for name in pair:
            holders[name].update(pair)
        copy = spare_copy(pair, roles)
        spare += [copy] * bool(copy)
        standing.update(() if copy else pair)
    repeated = {}
    for at, row in runs.iterrows():
        own = row["recording"]
        names = [name for name in holders if name in holders[own]]
        if len(names) > 1:
            left_out = [name for name in names if name in spare]
            repeated[at] = {**row, **_run(names, left_out, own in standing)}
    return repeated


def _neighbours(ends: pd.DataFrame, roles: Mapping[str, str]) -> dict[Any, dict[str, Any]]:
    """Return, by index of `ends`, the findings of recordings that are a part of a fitted run."""
    details = ends["detail"].fillna("").astype(str)
    fitted = dict(parts_seen(dict(zip(ends["recording"], details, strict=True)), roles))
    parts = Found.PARTS_OF_ONE_RUN
    about = {"code": parts, "finding": parts.words, "count": 1}
    return {
        at: {**row, **about, "detail": _part(row["recording"], fitted)}
        for at, row in ends.iterrows()
        if row["recording"] in fitted
    }


def _commanded_again(efforts: pd.DataFrame, copied: Sequence[str]) -> dict[Any, dict[str, Any]]:
    """Return, by index of `efforts`, the findings of recordings with the efforts of others; copied:
    recordings whose motion is another's, too.
    """
    known = efforts[efforts["detail"].fillna("").ne("") & ~efforts["recording"].isin(copied)]
    found = dict[Any, dict[str, Any]]()
    for _, alike in known.groupby("detail", sort=False):
        if len(alike) > 1:
            detail = (
                f"{' and '.join(alike['recording'])} have the same efforts, number by number, and "
                "move otherwise: a command that was sent again, or a file copied by mistake; "
                "record what was measured"
            )
            about = {"severity": "warning", "count": len(alike) - 1, "detail": detail}
            found |= {at: {**row, **about} for at, row in alike.iterrows()}
    return found


def _part(name: str, fitted: Mapping[str, str]) -> str:
    return (
        f"{name} and {fitted[name]} are parts of one run: the errors of {name} are not those of an "
        "unseen recording; validate with another run"
    )


def _run(names: Sequence[str], spare: Sequence[str], standing: bool) -> dict[str, Any]:
    """Return count, severity and detail of the finding that recordings are of one run.

    spare: those of them that are left out; standing: whether that is none, which is a stop sign.
    """
    same = f"{', '.join(names)} are one run: their rows are equal"
    detail = (
        f"{same}, so that it would count twice; keep one of them in the study"
        if standing
        else f"{same}, and {' and '.join(spare)} would count twice: left out of the results; "
        "remove it from the study, or name its own file"
    )
    severity = "stop" if standing else "warning"
    return {"count": len(names) - 1, "severity": severity, "detail": detail}


def _copy(row: pd.Series, alike: pd.DataFrame) -> dict[str, Any]:
    """Return the finding of a file that is the same in several recordings."""
    others = [name for name in alike["recording"] if name != row["recording"]]
    used = "used" if int(row["count"]) else "not used"
    detail = f"identical to the file of {', '.join(others)}; {used} here"
    return {**row, "count": len(others), "detail": detail}
