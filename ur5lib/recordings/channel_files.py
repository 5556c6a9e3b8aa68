"""Arrays of a folder of text files: one value a line, one sample a line, or one row of values."""

import re
from collections.abc import Collection
from pathlib import Path

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recordings.array_files import Arrays, array_format
from ur5lib.recordings.delimited import TextTable
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log
from ur5lib.timeseries.arrays import Array

BLANK_LINE = re.compile(rb"\n[ \t\r]*\n")
MIN_STAMPS, MIN_SHARE_FORWARD = 4, 0.95  # of a table's stamps, and of their steps
MAX_STEP = 1.5  # rows that show what is between them are within this many usual steps of a table


@array_format("channel-files", "a folder of text files", is_folder=True)
def channel_file_arrays(
    folder: Path, wanted: Collection[str] | None, findings: list[Finding]
) -> Arrays:
    """Return the numbers (n, k) of text files, by their names in a folder.

    Rows belong together by their number, so that a line that is lost inside a file would shift all
    later ones: raises InputError for it. A file may lack the last, as the input of a last state.
    """
    there = sorted(path.name for path in folder.iterdir() if path.is_file())
    tables = {
        name: _read_rows(folder / name, findings)
        for name in there
        if wanted is None or name in wanted
    }
    most = max((len(rows) for rows in tables.values()), default=0)
    short = [
        name
        for name, rows in tables.items()
        if rows.shape[1] < len(rows) == most - 1 and not has_stamps(rows)
    ]
    meaning = (
        f"the last of {most:,} rows is missing, as the input of a last state, which is left out"
    )
    for name in short:
        Log(folder / name, "robot", findings).add(Found.MISSING_LAST_ROW, "note", 1, meaning)
    return {
        name: rows[: most - 1] if short and len(rows) == most else rows
        for name, rows in tables.items()
    }


def has_stamps(rows: Array) -> bool:
    """Return whether a table's first column, and no other, increases like a clock."""
    if rows.ndim != 2 or rows.shape[1] < 2 or len(rows) < MIN_STAMPS:
        return False
    forward = (np.diff(rows, axis=0) > 0).mean(axis=0) >= MIN_SHARE_FORWARD
    return bool(forward[0] and not forward[1:].any())


def at_stamps(tables: Arrays, name: str) -> Arrays:
    """Return tables with their rows interpolated at the stamps of the table `name`.

    tables: (n, k), with stamps in the first column; tables without stamps are unchanged. NaN where
    a table has no rows near enough (MAX_STEP usual steps apart).
    """
    stamps = tables[name][:, 0]
    return {
        other: _between(rows, stamps) if has_stamps(rows) else rows
        for other, rows in tables.items()
    }


def _between(rows: Array, stamps: Array) -> Array:
    own, order = np.unique(rows[:, 0], return_index=True)
    if np.array_equal(own, stamps):
        return rows
    place = np.clip(np.searchsorted(own, stamps), 1, len(own) - 1)
    step = own[place] - own[place - 1]
    known = (stamps >= own[0]) & (stamps <= own[-1]) & (step <= MAX_STEP * np.median(np.diff(own)))
    columns = [np.interp(stamps, own, column) for column in rows[order, 1:].T]
    return np.column_stack([stamps, *(np.where(known, column, np.nan) for column in columns)])


def _read_rows(path: Path, findings: list[Finding]) -> np.ndarray:
    own: list[Finding] = []
    text = TextTable(Log(path, "robot", own))
    table, _ = text.rows([*map(str, range(len(text.cells)))])
    blank = BLANK_LINE.search(path.read_bytes().strip())
    if blank or any(finding.code == Found.DAMAGED_LINES for finding in own):
        raise InputError(
            f"{path} has lines without a number, so that its rows can no longer be matched with "
            "those of the other files; correct these lines, or record it again"
        )
    findings += own
    return table.to_numpy()
