"""The check of a study's recordings without the workflow."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import NamedTuple

import pandas as pd
from rich.console import Console
from rich.padding import Padding
from rich.table import Table

from ur5lib.checks import files
from ur5lib.checks.channels import slow_samples
from ur5lib.checks.checked import Checked
from ur5lib.checks.contacts import sensed_contacts
from ur5lib.checks.devices import checked_intake
from ur5lib.checks.findings import contradictions
from ur5lib.checks.sides import unknown_side
from ur5lib.commands.console import announced, text_console
from ur5lib.commands.contract import Contract
from ur5lib.commands.processes import side_by_side
from ur5lib.errors import InputError
from ur5lib.force.tare import tare_doubts, touched_by_own_clock
from ur5lib.recordings.intake import Intake, read_and_repair
from ur5lib.records.account import UNKNOWN_NAME, AccountRow
from ur5lib.records.carried import carried, disagreements
from ur5lib.records.clocks import OwnClock, SettledClock
from ur5lib.records.codes import Found
from ur5lib.records.judgement import ClockRow, QualityRow
from ur5lib.records.quality import UNCHECKED, Finding, Quality
from ur5lib.records.signals import Signals
from ur5lib.report.page.findings import MAX_NAMED_PLACES, by_finding, group_findings
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics
from ur5lib.signals.clock import pool_drifts, settle_clocks
from ur5lib.signals.own_clocks import own_clocks
from ur5lib.steps.read_postures import checked_postures
from ur5lib.study.model import Recording, Study, arms_without_fit
from ur5lib.study.reading import read_study
from ur5lib.tables import json_text, table_by_owner
from ur5lib.workspace.extensions import take_up_all

ERROR_SEVERITIES = ("stop", "error")
MAX_NAMED = 3  # recordings in a finding
MAX_PROPOSED_NAMES = 20  # recordings that an error proposes
SEVERITY_STYLES = {"stop": "bold red", "error": "bold red", "warning": "yellow", "note": ""}


class Form(NamedTuple):
    """The form in which findings are printed: everything: list unchecked and unused parts in full;
    as_json: print JSON.
    """

    everything: bool = False
    as_json: bool = False


FOLDED = Form()


def print_findings(
    path: Path, named: Sequence[str] = (), form: Form = FOLDED, contract: Contract | None = None
) -> int:
    """Print the findings of a study's recordings, or those of some recordings in detail.

    contract: to check them against. Returns the number of stop signs and errors. Raises InputError
    if the study is wrong or lacks a named recording, or if an extension cannot be used.
    """
    take_up_all()
    study = read_study(path)
    names = [recording.name for recording in study.recordings]
    for name in named:
        if name not in names:
            near = get_close_matches(name, names, n=1) or names[:MAX_PROPOSED_NAMES]
            raise InputError(f"{path} has no recording {name!r}, but {', '.join(near)}")
    return print_findings_of(study, named, form, contract)


def print_findings_of(
    study: Study,
    named: Sequence[str] = (),
    form: Form = FOLDED,
    contract: Contract | None = None,
) -> int:
    """Print the findings of recordings; return the number of stop signs and errors.

    named: recordings with findings printed in detail; empty: all recordings, by finding; contract:
    to check them against.
    """
    console = text_console(stderr=form.as_json)  # the JSON is on stdout
    lacking = [f"contract: {one}" for one in contract.lacking(study)] if contract else []
    lacking += refused_arms(study)
    for sentence in lacking:
        console.print(sentence, style=SEVERITY_STYLES["error"])
    for arm in arms_without_fit(study):
        console.print(
            f"no recording of {arm} has the role `fit`: friction is only what other arms have, and "
            "bands are wide; give this role to a recording in which nothing touches the arm"
        )
    there = [recording for recording in study.recordings if is_there(recording)]
    if len(there) < len(study.recordings):
        names, present = (
            [recording_there.name for recording_there in study.recordings],
            {recording_there.name for recording_there in there},
        )
        unmade = concerned([name for name in names if name not in present], names)
        console.print(f"not simulated yet: {unmade}; `ur5 run` will simulate it first")
    if not there:
        return len(lacking)
    names = [recording.name for recording in there]
    # without its recordings, or each process would get all of them with every task
    alone = study.model_copy(update={"recordings": []})
    with side_by_side(partial(_held_against, contract, study=alone), there) as looked:
        results = dict(zip(announced(names), looked, strict=True))
    qualities = {name: quality for name, (quality, _) in results.items()}
    clocks = settled(
        study, qualities, {name: own_clocks_of for name, (_, own_clocks_of) in results.items()}
    )
    roles = {recording.name: recording.role for recording in there}
    return len(lacking) + print_tables(console, qualities, clocks, named, roles, form)


def refused_arms(study: Study) -> list[str]:
    """Return one reason for each arm to which `ur5 run` will fit nothing, because its description
    does not say whether its torques are the motors' or the joints'.
    """
    fitted = [recording for recording in study.recordings if recording.role == "fit"]
    accepted = {one.arm.known_as for one in fitted if "side" in one.accepted()}
    arms = {one.arm.known_as: one.arm for one in fitted if one.arm.known_as not in accepted}
    return [reason for arm in arms.values() if (reason := unknown_side(arm.description()))]


def _held_against(
    contract: Contract | None, recording: Recording, study: Study
) -> tuple[Quality, dict[str, OwnClock]]:
    """Return quality and clocks by `look_through`, with violations of the contract as errors."""
    quality, clocks = look_through(recording, study)
    return contract.held_against(recording, quality) if contract else quality, clocks


def print_tables(
    console: Console,
    qualities: Mapping[str, Quality],
    clocks: Mapping[str, Mapping[str, SettledClock]],
    named: Sequence[str] = (),
    roles: Mapping[str, str] | None = None,
    form: Form = FOLDED,
) -> int:
    """Print the quality and the clocks of recordings; return the number of stop signs and errors.

    named: recordings to print with all findings and clocks; if empty, each finding is printed once,
    with the least certain clock of each device; roles: by recording; form: of the tables.
    """
    findings = {
        name: map(files.quality_row, files.findings(own)) for name, own in qualities.items()
    }
    quality = files.name_copies(table_by_owner(QualityRow, findings), roles)
    offsets = table_by_owner(
        ClockRow, {name: files.clock_rows(own) for name, own in clocks.items()}
    )
    names = [name for name in qualities if name in named] if named else [*qualities]
    quality, offsets = (own[own["recording"].isin(names)] for own in (quality, offsets))
    severe_ones = int(quality["severity"].isin(ERROR_SEVERITIES).sum())
    if form.as_json:
        print(json_text(quality.to_dict("records")), end="")
        return severe_ones
    if named:
        console.print(_findings(quality, names))
    else:
        _print_by_finding(console, quality, names, form.everything)
        offsets = offsets.sort_values("end_std_s", ascending=False).drop_duplicates("device")
    if form.everything:
        console.print(_evidence({name: qualities[name].account for name in names}))
    if len(offsets):
        console.print(
            _clocks(offsets, "Clocks" if named else "The least certain clock of each device")
        )
    return severe_ones


def _evidence(accounts: Mapping[str, Sequence[AccountRow]]) -> Table:
    """Return a table of what each source says of the columns of recordings, as import found it."""
    heads = ["recording", "columns", "log-odds", "source"]
    table = Table(*heads, title="Evidence for what columns are")
    for name, account in accounts.items():
        for row in account:
            if row.confidence == "evidence":
                table.add_row(name, row.subject, row.taken_for, row.reason)
    return table


def severe(quality: Quality) -> list[str]:
    """Return the stop signs and errors of a recording, a sentence each."""
    return [one.sentence() for one in quality.findings if one.severity in ERROR_SEVERITIES]


def is_there(recording: Recording) -> bool:
    """Return whether a recording's files exist; those of a simulated one may not exist yet."""
    files = [Path(recording.folder) / name for name in recording.file_names()]
    return getattr(recording, "simulate", None) is None or all(file.is_file() for file in files)


def look_through(
    recording: Recording, study: Study, only_stops: bool = False
) -> tuple[Quality, dict[str, OwnClock]]:
    """Return a recording's quality, and its devices' clocks by name; of one that cannot be used, a
    quality with that error and no clocks.

    only_stops: leave out most doubts, which take a third of the time.
    """
    arm = recording.arm.description().mounted(recording.known_gravity())
    if recording.at_rest:
        return look_through_postures(recording, arm), {}
    try:
        read = read_and_repair(recording, arm, study.settings.frames.max_gap_s)
    except InputError as error:
        return unusable(error), {}
    intake = checked_intake(read, arm, recording.path.parts[-2:])
    declared, tool = recording.known_payload(), recording.known_tool()
    signals, fitted = Signals.from_table(intake.robot), recording.role == "fit"
    load = carried(declared, signals)
    cutoffs = study.settings.lowpass.cutoffs_hz()
    cutoff = cutoffs["currents"]
    touched = recording.role == "contact"
    checked = Checked(intake.robot, arm, load.configured, load.payload, fitted, cutoff, touched)
    doubts = disagreements(declared, tool.tcp if tool else None, signals)
    if not fitted:  # in a run, `slower_than_fit` decides whether it matters
        doubts += slow_samples(signals.actual_q, signals.segment, checked.step, cutoff)
    if recording.untouched is not None:
        doubts += tare_doubts(recording.untouched, signals, arm, cutoff)
        if "force" in intake.sensors:
            own = intake.sensors["force"], intake.quality.starts["force"]
            doubts += touched_by_own_clock(recording.untouched, *own)
    sensor = intake.sensors.get("force", intake.robot if "ft_fx" in intake.robot else None)
    if not touched and sensor is not None:
        doubts += sensed_contacts(sensor, load.mass)
    sensed, accepted = sensor is not None, recording.accepted()
    found = contradictions(checked, doubts, sensed, cutoffs, accepted, only_stops)
    findings = [*found.stop_signs, *intake.quality.findings, *found.findings]
    return replace(intake.quality, findings=findings), _clocks_of(intake, arm)


def look_through_postures(recording: Recording, arm: Robot) -> Quality:
    """Return the quality of a recording of postures at rest; arm: under its gravity."""
    tool = recording.known_tool()
    load, tcp = recording.known_payload(), tool.tcp if tool else None
    try:
        postures, quality = checked_postures(recording, arm, load, tcp, recording.accepted())
    except InputError as error:
        return unusable(error)
    contradictions = postures.contradictions
    return replace(
        quality, findings=[*contradictions.stop_signs, *quality.findings, *contradictions.findings]
    )


def unusable(error: InputError) -> Quality:
    """Return the quality of a recording that cannot be read."""
    return Quality(findings=[Finding("robot", Found.UNUSABLE, "error", 1, str(error))])


def _clocks_of(intake: Intake, arm: Robot) -> dict[str, OwnClock]:
    if not intake.sensors:
        return {}
    robot = Signals.from_table(intake.robot)
    rotation, _, jacobian = flange_kinematics(arm, robot.actual_q)
    return own_clocks(intake.quality.starts, intake.sensors, robot, rotation, jacobian)


def settled(
    study: Study,
    qualities: Mapping[str, Quality],
    clocks_of_devices: Mapping[str, Mapping[str, OwnClock]],
) -> dict[str, dict[str, SettledClock]]:
    """Return each recording's clocks by device, from each device's own clock and the drifts of
    hosts, by recording.
    """
    read = [recording for recording in study.recordings if recording.name in clocks_of_devices]
    drifts = {}
    for robot in study.arms():
        free = [r.name for r in read if r.arm.known_as == robot and r.role != "contact"]
        drifts[robot] = pool_drifts(
            {name: clocks_of_devices[name] for name in free}, study.devices_of_hosts()
        )
    return {
        r.name: settle_clocks(
            clocks_of_devices[r.name], drifts[r.arm.known_as], qualities[r.name].duration_s
        )
        for r in read
    }


def _print_by_finding(
    console: Console, quality: pd.DataFrame, names: list[str], everything: bool
) -> None:
    """Print each finding once: the recordings that it concerns, and what it means.

    everything: list unchecked and unused parts in full; otherwise in one line each.
    """
    is_unused = (quality["code"] == Found.COLUMNS_NOT_USED) & ~everything
    found = by_finding(quality[~is_unused], None if everything else MAX_NAMED_PLACES)
    is_open = found["code"].isin(UNCHECKED) & ~everything
    kinds = found[~is_open].groupby(["severity", "device", "finding"], sort=False)
    for (severity, device, finding), rows in kinds:
        title, style = f"{device}: {finding} ({severity}) in ", SEVERITY_STYLES[severity]
        for row in rows.itertuples():
            where = "" if row.alike else f"{row.recordings[0]}: "
            console.print(title + concerned(row.recordings, names), style=style)
            console.print(Padding(where + row.detail, (0, 0, 0, 4)))
    if is_open.any():
        console.print(_not_checked(found[is_open], names))
    if is_unused.any():
        console.print(_not_used(quality[is_unused], names))
    unsound = {*quality["recording"]}
    if sound := [name for name in names if name not in unsound]:
        console.print(f"nothing found in {concerned(sound, names)}")
    console.print("`ur5 check <study> <recording>` shows a recording's findings in detail")


def _not_checked(found: pd.DataFrame, names: list[str]) -> str:
    """Return one sentence on the parts that could not be checked, with the riskiest one in full."""
    rows = found.sort_values("code", key=lambda f: f.map(UNCHECKED.index), kind="stable")
    kinds = [*dict.fromkeys(rows["finding"].str.replace(" not checked", ""))]
    riskiest = rows.iloc[0]
    where = concerned(riskiest["recordings"], names)
    return (
        f"could not be checked: {', '.join(kinds)}; the riskiest, in {where}: {riskiest['detail']} "
        "(`ur5 check <study> --all` lists them)"
    )


def _not_used(unused: pd.DataFrame, names: list[str]) -> str:
    """Return one sentence on unused columns, with the riskiest ones, those of unknown names."""
    places = zip(unused["place"], unused["detail"], strict=True)
    reasons = pd.Series([d.removeprefix(f"{place}: ") for place, d in places], unused.index)
    reason = UNKNOWN_NAME if (reasons == UNKNOWN_NAME).any() else reasons.iloc[0]
    riskiest = group_findings(unused[reasons == reason], MAX_NAMED_PLACES).iloc[0]
    where = concerned([*unused["recording"].unique()], names)
    return (
        f"columns are not used in {where}; the riskiest, in {riskiest['recording']}: "
        f"{riskiest['detail']} (`ur5 check <study> --all` lists them)"
    )


def concerned(some: Sequence[str], names: Sequence[str]) -> str:
    """Return in words which of all `names` a finding concerns: the number of `some`, and a few of
    them.
    """
    if len(some) == 1:
        return some[0]
    if len(some) == len(names):
        return "both recordings" if len(names) == 2 else f"all {len(names)} recordings"
    count = f"{len(some)} of {len(names)} recordings"
    if len(some) > MAX_NAMED >= len(names) - len(some):
        those = {*some}
        return f"{count}: all but {', '.join(name for name in names if name not in those)}"
    more = f" and {len(some) - MAX_NAMED} more" if len(some) > MAX_NAMED else ""
    return f"{count}: {', '.join(some[:MAX_NAMED])}{more}"


def _findings(quality: pd.DataFrame, names: list[str]) -> Table:
    """Return a table of the findings, with one section per recording."""
    table = Table("recording", "finding", "count", "what it means", title="Findings")
    table.columns[0].overflow = "fold"
    findings = group_findings(quality)
    for name in names:
        title = name
        rows = findings[findings["recording"] == name]
        for row in rows.itertuples():
            finding = f"{row.device}: {row.finding} ({row.severity})"
            style = SEVERITY_STYLES[row.severity]
            table.add_row(title, finding, str(row.count), row.detail, style=style)
            title = ""
        if rows.empty:
            table.add_row(title, "nothing found", "0", "")
        table.add_section()
    return table


def _clocks(clocks: pd.DataFrame, title: str) -> Table:
    heads = ["recording", "device", "offset [s]", "drift [ppm]", "at the end [s]", "method"]
    table = Table(*heads, title=title)
    for row in clocks.itertuples():
        estimated = pd.notna(row.drift_ppm)
        drift = f"{row.drift_ppm:.0f} ± {row.drift_std_ppm:.0f}" if estimated else "not estimated"
        offset = f"{row.offset_s:.4f} ± {row.offset_std_s:.4f}"
        end = f"± {row.end_std_s:.4f}"
        table.add_row(row.recording, row.device, offset, drift, end, row.method)
    return table
