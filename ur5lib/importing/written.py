"""What `ur5 import` prints, or writes into a study: entries of recordings, and their account."""

import re
import sys
from collections.abc import Sequence
from itertools import chain
from pathlib import Path

from ur5lib.channels import RECORDED_CHANNELS
from ur5lib.commands.console import announced, text_console
from ur5lib.errors import InputError, some
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.efforts import EFFORT_MEANINGS
from ur5lib.importing.entry import StudyEntry, identifier
from ur5lib.importing.files import (
    ImportedFiles,
    account_table,
    add_to_study,
    as_entries,
    import_files,
    write_study,
)
from ur5lib.importing.identity import NAME_IT, UNDESCRIBED_ARM
from ur5lib.importing.parted_runs import runs_of
from ur5lib.recordings.entries import SKIPPED_COLUMN
from ur5lib.robots.description import described
from ur5lib.study.address import is_study, study_file

ACCOUNT_WIDTH = 160  # characters of a table that no terminal limits


def user_statement(
    robot: str | None,
    columns: str | None,
    rate: float | None,
    units: Sequence[str],
    joints: str = "",
    prefix: str = "",
    sensor: Path | None = None,
) -> UserStatement:
    """Return what a user states of recordings.

    columns: channels, with commas between; joints: names, or the joint of each column from 1, with
    commas between; units: each as `actual_current=mA`. Raises InputError for an arm that is not
    described, and a unit without its channel.
    """
    if robot is not None:
        described(robot)
    names = tuple(columns.split(",")) if columns else ()
    named = tuple(name.strip() for name in joints.split(",") if name.strip())
    by_channel = dict(_pair(one) for one in units)
    numbers = tuple(int(name) for name in named if name.isdecimal())
    are_numbers = bool(named) and sorted(numbers) == [*range(1, len(named) + 1)]
    of_joints = ((), prefix, sensor, numbers) if are_numbers else (named, prefix, sensor)
    return UserStatement(robot or "", names, rate, by_channel, *of_joints)


def imported_files(files: Sequence[Path], stated: UserStatement) -> ImportedFiles:
    """Return the entries of recordings; the name of each file is printed on stderr when it is read.

    Raises InputError for a study among them, and a stated unit of a channel that they lack.
    """
    imported = import_files(announced(runs_of(expect_no_study(files))), stated)
    _expect_channels(imported, stated)
    return imported


def expect_no_study(files: Sequence[Path]) -> Sequence[Path]:
    """Return the files as given. Raises InputError for a study among them."""
    if study := next((file for file in files if is_study(str(file)) and file.is_file()), None):
        raise InputError(f"{study} is a study, no recording; build it: ur5 run {study}")
    return files


def _expect_channels(imported: ImportedFiles, stated: UserStatement) -> None:
    """Raise InputError for a stated unit of a channel that no column of any file became; an effort
    is one by any of its names.
    """
    for channel in stated.units:
        names = {*EFFORT_MEANINGS} if channel in EFFORT_MEANINGS else {channel}
        if not any(names & _channels(one.entry) for one in imported):
            found = sorted({*chain.from_iterable(_channels(one.entry) for one in imported)})
            raise InputError(
                f"--unit {channel}: no column became this channel; the files have {some(found)}"
            )


def _channels(entry: StudyEntry) -> set[str]:
    """Return the channels that an entry names, its force sensor's among them."""
    if "columns" not in entry and "channels" not in entry:
        return {"time", *RECORDED_CHANNELS}  # the format has them
    sensor = entry.get("force_sensor", {}).get("channels", {})
    columns = {re.sub(r"_[\dxyz]$", "", name) for name in entry.get("columns", [])}
    return {*entry.get("channels", {}), *sensor, *columns, *entry.get("columns", [])} - {
        SKIPPED_COLUMN
    }


def write_imported(
    imported: ImportedFiles,
    study: Path,
    last_line: str,
    append: bool = False,
    everything: bool = False,
) -> None:
    """Write a study of recordings, or append them to one (`append`); print their account and a last
    line. everything: with the rows of evidence.

    Raises InputError, after that, where some files were refused.
    """
    (add_to_study if append else write_study)(imported, study)
    print_account(imported, everything=everything)
    print(_to_name_the_arm(study) or last_line)
    expect_all(imported)


def print_imported(imported: ImportedFiles, next_command: str, everything: bool = False) -> None:
    """Print the entries of recordings, and on stderr their account and what comes next;
    everything: with the rows of evidence.

    Raises InputError, after that, where some files were refused.
    """
    print(as_entries(imported), end="")
    print_account(imported, stderr=True, everything=everything)
    unnamed = any(one.arm == UNDESCRIBED_ARM for one in imported)
    first = f"{NAME_IT}: " if unnamed else ""
    print(f"next: {first}{next_command}", file=sys.stderr)
    expect_all(imported)


def _to_name_the_arm(study: Path) -> str:
    """Return what comes next for a study with an arm that nothing states, "" for another."""
    lines = study.read_text(encoding="utf-8").splitlines()
    unnamed = [k for k, line in enumerate(lines, 1) if line.strip() == f"robot: {UNDESCRIBED_ARM}"]
    return f"{study} written; next, in line {unnamed[0]}: {NAME_IT}" if unnamed else ""


def study_of(named: Sequence[str], robot: str | None, output: Path | None) -> Path:
    """Return the named study's file, or write a new study of named recordings and return its file.

    output: the new file, None for one named by the recordings' folder. Raises InputError where a
    recording cannot be imported, and where the new file exists.
    """
    if len(named) == 1 and is_study(named[0]):
        return study_file(named[0])
    files = [Path(name) for name in named]
    study = output or Path(f"{identifier(files[0].resolve().parent.name)}.yaml")
    if study.exists():
        raise InputError(f"{study} exists; build it by `ur5 run {study}`, or name another: -o")
    imported = imported_files(files, user_statement(robot, None, None, []))
    write_imported(imported, study, f"{study} written; it is built now")
    return study


def print_account(imported: ImportedFiles, stderr: bool = False, everything: bool = False) -> None:
    """Print what the columns were taken for, as wide as the terminal; everything: and why."""
    width = None if sys.stdout.isatty() else ACCOUNT_WIDTH
    text_console(stderr=stderr, width=width).print(account_table(imported, everything))


def expect_all(imported: ImportedFiles) -> None:
    """Raise InputError where some files were refused."""
    if imported.refused:
        raise InputError("\n".join(["not imported:", *imported.refused]))


def _pair(stated: str) -> tuple[str, str]:
    """Return channel and unit. Raises InputError where they are not `channel=unit`."""
    channel, _, unit = stated.partition("=")
    if not (channel and unit):
        raise InputError(f"--unit {stated}: state a channel and its unit, as actual_current=mA")
    return channel, unit
