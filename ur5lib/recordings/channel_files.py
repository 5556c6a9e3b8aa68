"""Arrays of a folder of text files: one value a line, one sample a line, or one row of values."""

import re
from collections.abc import Collection, Iterator
from itertools import chain
from pathlib import Path

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recordings.array_files import Arrays, array_format
from ur5lib.recordings.delimited import first_cells, read_numbers
from ur5lib.recordings.limits import expect_room, most_columns
from ur5lib.recordings.text_blocks import text_blocks
from ur5lib.records.quality import Finding, Log
from ur5lib.timeseries.arrays import Array

BLANK_LINE = re.compile(rb"\n[ \t\r]*\n")
SEPARATORS_TO_BLANKS = bytes.maketrans(b",;\t", b"   ")


@array_format("channel-files", "a folder of text files", is_folder=True)
def channel_file_arrays(
    folder: Path, wanted: Collection[str] | None, findings: list[Finding]
) -> Arrays:
    """Return the numbers (n, k) of text files, by their names in a folder.

    Rows belong together by their number, so that a line that is lost inside a file would shift all
    later ones: raises InputError for it.
    """
    there = sorted(path.name for path in folder.iterdir() if path.is_file())
    return {
        name: _read_rows(folder / name, findings)
        for name in there
        if wanted is None or name in wanted
    }


def _read_rows(path: Path, findings: list[Finding]) -> np.ndarray:
    if (wide := _wide_rows(path)) is not None:
        return wide
    own: list[Finding] = []
    names = [str(index) for index, _ in enumerate(first_cells(path)[0])]
    table = read_numbers(Log(path, "robot", own), names)
    blank = BLANK_LINE.search(path.read_bytes().strip())
    if blank or any(finding.finding == "damaged lines" for finding in own):
        raise InputError(
            f"{path} has lines without a number, so that its rows can no longer be matched with "
            "those of the other files; correct these lines, or record it again"
        )
    findings += own
    return table.to_numpy()


def _wide_rows(path: Path) -> Array | None:
    """Return the rows (k, n) of a file of which each is longer than a table may be wide.

    None for other files. Raises InputError where they differ in length or hold more than numbers.
    """
    lines = _lines(path)
    first = next(lines)
    if first.count(b" ") < most_columns():
        return None
    try:
        return np.loadtxt(chain([first], lines), ndmin=2)
    except ValueError as error:
        raise InputError(
            f"{path}: its lines differ in length, or hold more than numbers; record it again, with "
            "one sample a line"
        ) from error


def _lines(path: Path) -> Iterator[bytes]:
    """Yield the lines, with blanks between numbers. Raises InputError where they are too many."""
    numbers = 0
    for block in text_blocks(Log(path, "robot", [])):
        for line in block.translate(SEPARATORS_TO_BLANKS).split(b"\n"):
            expect_room(path, numbers := numbers + line.count(b" ") + 1)
            yield line
