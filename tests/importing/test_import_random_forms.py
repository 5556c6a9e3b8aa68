"""`ur5 import` on logs of random form: an entry for each, right or marked, with a row a column."""

import re
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
import pytest

from tests.entries import in_words, read_recording
from tests.random_forms import RandomLog, drawn
from ur5lib.channels import JOINT_CHANNELS, RECORDED_CHANNELS, columns
from ur5lib.errors import InputError
from ur5lib.importing.files import ImportedRecording, import_files
from ur5lib.recordings.wraps import without_wraps
from ur5lib.records.account import NOTHING, AccountRow
from ur5lib.timeseries.arrays import Array

RIGHT, MARKED, REFUSED = "right", "marked", "refused with a true sentence"
WRONG, ROWLESS, CRASH, UNTRUE = (
    *("silently wrong", "column without a row", "traceback", "untrue sentence"),
)
OUTCOMES = (RIGHT, MARKED, REFUSED, WRONG, ROWLESS, CRASH, UNTRUE)
QUANTITY_OF = {  # of a channel
    "actual_q": "q", "actual_qd": "qd", "actual_current": "i", "actual_TCP_pose": "pose",
    "actual_current_as_torque": "tau", "actual_torque": "tau", "target_q": "target",
    "ft_f": "wrench", "ft_t": "wrench", "actual_TCP_force": "wrench",
    "joint_temperatures": "temperatures",
}  # fmt: skip
OF_FILE = ("robot", "the joints' order", "rate", "rows", "columns", "recording")
RIVAL_WORDS = (
    "before",
    "next",
    "further",
    "beside",
    "than",
    "under",
    "else",
    "no torque",
    "as radians",
    "without",
    "within",
    "twice",
)

OPTION = re.compile(r"--[a-z]+ ?|`\w+(: .*?)?`|`ur5 describe|write (fit|contact)")
RIVAL = re.compile(r"\b(or|before|otherwise|else|another|others?|if|far better|no unit|would be)\b")


class Outcome(NamedTuple):
    """What import made of a log, and the details of it."""

    seed: int
    form: dict[str, str]
    result: str
    details: list[str]
    said: str


def outcome(seed: int, folder: Path) -> Outcome:
    """Return what import makes of a log of random form."""
    log = drawn(seed, folder)
    try:
        (found,) = import_files([log.path], log.told)
    except InputError as error:
        right = log.form["names"] == "none" and "--columns" in str(error)
        return Outcome(seed, log.form, REFUSED if right else UNTRUE, [], str(error))
    except Exception as error:
        return Outcome(seed, log.form, CRASH, [repr(error)], "")
    wrong, missing = wrongs(log, found)
    faults = {
        WRONG: wrong,
        ROWLESS: rowless(log, found.account),
        UNTRUE: untrue(log, found.account),
    }
    said = in_words(found.account)
    for name, details in faults.items():
        if details:
            return Outcome(seed, log.form, name, details, said)
    marked = missing or any(row.confidence == "check" for row in found.account)
    return Outcome(seed, log.form, MARKED if marked else RIGHT, missing, said)


def wrongs(log: RandomLog, found: ImportedRecording) -> tuple[list[str], list[str]]:
    """Return what is silently wrong in an entry, and what is missing or wrong, but marked."""
    try:
        recording = read_recording(found.entry)
    except InputError as error:
        marked = any(row.confidence == "check" for row in found.account)
        return ([], [str(error)]) if marked else ([str(error)], [])
    robot = without_wraps(recording.robot.table)[0]
    tables = [robot, *(sensor.table for sensor in recording.sensors.values())]
    there = {name: rows for table in tables for name, rows in in_table(table)}
    bad = {name: "read" for name, rows in there.items() if not is_right(log, name, rows)}
    bad |= dict.fromkeys(known(log) - {*there}, "missing")
    silent = [f"{name} {how}" for name, how in bad.items() if not is_marked(log, name, found)]
    checked = {row.subject for row in found.account if row.confidence == "check"}
    told_arm = log.arm.name if log.arm else "my_arm"
    if found.arm != told_arm and "robot" not in checked:
        silent.append(f"robot {found.arm} for {told_arm}")
    lasts = np.ptp(robot["time"].to_numpy())
    late = abs(lasts - np.ptp(log.time)) > 1.2 and "still" not in found.entry
    if late and not checked & {"rate", "rows"}:
        silent.append(f"lasts {lasts:.4g} s for {np.ptp(log.time):.4g} s")
    named = log.quantities.get("wrench") and log.form["names"] != "none"
    unlike = named and (found.entry["role"] == "contact") != log.pushed
    if unlike and "role" not in checked:
        silent.append(f"role {found.entry['role']}")
    return silent, [f"{name} {how}" for name, how in bad.items()]


def in_table(table: pd.DataFrame) -> Iterable[tuple[str, Array]]:
    """Yield the channels of a table, (N, k), without empty rows."""
    for name in {*RECORDED_CHANNELS, "ft_f", "ft_t"} - {"time", "ft", "imu"}:
        wide = [c for c in columns(name, 8) if c in table] if name in JOINT_CHANNELS else None
        its = [c for c in (wide or columns(name)) if c in table]
        rows = table[its].to_numpy(float) if its else np.empty((0, 0))
        if np.isfinite(rows).any():
            yield name, rows[np.isfinite(rows).all(axis=1)]


def is_right(log: RandomLog, name: str, rows: Array) -> bool:
    """Return whether rows of a channel are those that were recorded; angles but for turns."""
    if name == "actual_torque_less_gravity" or name not in log.channels:
        return False
    truth = log.channels[name]
    if rows.shape[1] != truth.shape[1] or abs(len(rows) - len(truth)) > 0.02 * len(truth):
        return False
    truth, rows = truth[: len(rows)], rows[: len(truth)]
    off = rows - truth
    if name == "actual_q" and log.form["wrap"]:
        off = off - np.round(off / (2 * np.pi)) * 2 * np.pi
        if np.abs(np.diff(rows, axis=0)).max() > 3:
            return False
    return bool(np.abs(off).max() < 1e-3 * max(1.0, np.abs(truth).max()))


def known(log: RandomLog) -> set[str]:
    """Return the channels that the log has and an entry should have."""
    return {n for n in log.channels if n in QUANTITY_OF and QUANTITY_OF[n] in log.quantities}


def is_marked(log: RandomLog, channel: str, found: ImportedRecording) -> bool:
    """Return whether the account doubts a channel, its columns, or what all channels depend on."""
    names = log.quantities.get(QUANTITY_OF.get(channel, ""), [])
    doubts = [row for row in found.account if row.confidence in ("check", "left out")]
    if log.form["names"] == "none":
        return any(row.subject.startswith(("column ", *OF_FILE)) for row in doubts)
    of_channel = [row for row in doubts if row.taken_for.startswith(channel)]
    of_columns = [row for row in doubts if any(name in row.subject for name in names)]
    if log.form["kind"] in ("bag", "db3", "mcap", "folder"):
        part = {"actual_q": "position", "actual_qd": "velocity"}.get(channel, "effort")
        of_columns = [row for row in doubts if row.subject == f"/joint_states/{part}"]
    of_file = [row for row in doubts if row.subject in OF_FILE]
    return bool(of_channel or of_columns or of_file)


def rowless(log: RandomLog, account: Iterable[AccountRow]) -> list[str]:
    """Return the columns of a file that no row names, alone or between the two that it names."""
    parts = [part for row in account for part in row.subject.split(", ")]
    if log.form["names"] == "none":
        return []
    named = set(parts)
    for first, *last in (part.split(" … ") for part in parts):
        for names in log.quantities.values() if last else ():
            if first in names and last[0] in names:
                ends = sorted((names.index(first), names.index(last[0])))
                named |= {*names[ends[0] : ends[1] + 1]}
    named |= {part.partition(" … ")[0].rpartition("_")[0] for part in parts if " … " in part}
    every = {name for names in log.quantities.values() for name in names}
    return [name for name in every if not name.startswith("/joint_states/p") and name not in named]


def untrue(log: RandomLog, account: Iterable[AccountRow]) -> list[str]:
    """Return the sentences of an account that are not so, as far as the log tells it."""
    found = []
    for row in account:
        reason, form = row.reason, log.form
        claims = {
            "no block is named so": "qd" not in log.quantities or form["names"] == "none",
            "wraps by": bool(form["wrap"]),
            "zero throughout": form["names"] == "none"
            or any(n in row.subject for n in _zeros(log)),
            "no clock": form["clock"] in ("none", "row numbers") or bool(log.told.rate),
            "never negative": form["effort"] == "rectified",
            "opposite sign": form["sign"] != "as usual",
            "of a gripper": "gripper" in row.subject,
            "holds text": "text" in log.quantities,
            "appears twice": bool(form.get("twice")),
            "has no name": bool(form.get("unnamed")) or form["names"] == "none",
            "no channel is named so": row.taken_for == NOTHING,
        }
        found += [
            f"{row.subject}: {reason}"
            for claim, so in claims.items()
            if claim in reason and not so and not reason.startswith("if ")
        ]
        if not ends_a_doubt(row):
            found.append(f"{row.subject}: a doubt without rival or option: {reason}")
        if row.confidence == "proven":
            rival = any(word in reason for word in RIVAL_WORDS) and re.search(r"\d", reason)
            found += [] if rival else [f"{row.subject}: no rival: {reason}"]
            if row.subject == "robot" and log.arm and row.taken_for != log.arm.name:
                found.append(f"robot {row.taken_for} proven")
    return found


def ends_a_doubt(row: AccountRow) -> bool:
    """Return whether a row to be checked names the next candidate, and what ends the doubt."""
    is_doubt = row.confidence == "check"
    return not is_doubt or bool(OPTION.search(row.reason) and RIVAL.search(row.reason))


def _zeros(log: RandomLog) -> list[str]:
    rest = [n for n, v in log.table.items() if np.asarray(v).dtype != object and not np.any(v)]
    accelerations = [] if log.channels["qdd"].any() else log.quantities.get("qdd", [])
    return [*rest, *accelerations, *log.quantities.get("denormal", [])]


def by_form(outcomes: Iterable[Outcome]) -> pd.DataFrame:
    """Return how often each outcome was reached, by what was drawn (arm ur, names ros, …)."""
    counts = dict[str, Counter[str]]()
    for made in outcomes:
        drawn_words = [
            f"{key}: {part}" for key, words in made.form.items() for part in words.split(", ")
        ]
        for words in ["all", *drawn_words]:
            counts.setdefault(words, Counter())[made.result] += 1
    table = pd.DataFrame(counts).T.reindex(columns=OUTCOMES).fillna(0).astype(int)
    return table.sort_index()


FAULTS = (WRONG, ROWLESS, CRASH, UNTRUE)


# Sizes with a minus; a percentage, 1 % of which is 1.5 Nm; a wrench with stamps of whole seconds;
# nanoseconds of an arm at rest, which are as regular as any unit; dates below a row of units;
# RTDE's numbers of joints in another order; a percentage named as a torque; a random walk, turned.
FOUND_WRONG = (8128, 20599, 20713, 21113, 21257, 8253, 8261, 21146, 22268, 22199, 22035)


@pytest.mark.parametrize("seed", [*range(12), *FOUND_WRONG])
def test_no_form_is_silently_wrong(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    made = outcome(seed, tmp_path)
    assert made.result not in FAULTS, made


@pytest.mark.slow
@pytest.mark.thorough
def test_none_of_three_hundred_forms_is_silently_wrong(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    made = []
    for seed in range(300):
        folder = tmp_path / str(seed)
        folder.mkdir()
        monkeypatch.chdir(folder)
        made.append(outcome(seed, folder))
    table = by_form(made)
    print(table.to_string())
    assert [one for one in made if one.result in FAULTS] == []
    assert table.loc["all", RIGHT] > 50


def test_a_unit_in_the_name_counts_where_a_share_would_be_as_near(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    log = drawn(20599, tmp_path)
    head, *rows = log.path.read_text().splitlines()
    named = re.sub(r"(actual_joint_torque_\d)", r"\1 [Nm]", head)
    log.path.write_text("\n".join([named, *rows]))
    (found,) = import_files([log.path], log.told)
    (row, *_) = (row for row in found.account if "joint_torque" in row.subject)
    assert (row.taken_for.split()[0], row.confidence) == ("actual_current_as_torque", "proven")
