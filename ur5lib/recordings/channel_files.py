"""Text files of one channel each: one value a line, or one row of values."""

import re
from collections.abc import Collection
from pathlib import Path

import numpy as np

from ur5lib.errors import InputError
from ur5lib.recordings.delimited import read_numbers
from ur5lib.recordings.quality import Finding
from ur5lib.recordings.storage import Arrays

BLANK = re.compile(rb"\n[ \t\r]*\n")


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
    own: list[Finding] = []
    table = read_numbers(path, _column_names(path), "robot", own)
    if any(finding.finding == "damaged lines" for finding in own) or _has_blank_line(path):
        raise InputError(
            f"{path} has lines without a number, so that its rows can no longer be matched with "
            "those of the other files; correct these lines, or record it again"
        )
    findings += own
    return table.to_numpy()


def _column_names(path: Path) -> list[str]:
    """Return a name for each cell of the first line."""
    with path.open("rb") as stream:
        cells = re.split(rb"[;,\t]\s*|\s+", stream.readline(4096).strip())
    return [str(index) for index in range(len(cells))]


def _has_blank_line(path: Path) -> bool:
    return BLANK.search(path.read_bytes().strip()) is not None
