"""Where the rows of a recording's file lie on the time grid of its repaired samples."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.errors import InputError
from ur5lib.recordings.array_files import LOADERS
from ur5lib.recordings.arrays import rows_of_arrays
from ur5lib.recordings.bunched_stamps import evenly_stamped
from ur5lib.recordings.delimited import TextTable
from ur5lib.recordings.entries import Files, RtdeFiles, TableFiles, expand
from ur5lib.recordings.frames import grid_times
from ur5lib.recordings.ordering import continued, epochs
from ur5lib.recordings.plausibility import first_time
from ur5lib.records.quality import Log
from ur5lib.timeseries.arrays import Array, Labels

HALF = 0.51  # of a period: a row belongs to the sample that is nearer


def _of_table(recording: TableFiles) -> pd.DataFrame:
    text = TextTable(Log(recording.path, "robot", []))
    table, rows = text.rows(expand(recording.columns))
    return recording.in_si(table, rows).set_index(rows)


def _of_rtde(recording: RtdeFiles) -> pd.DataFrame:
    table, rows = TextTable(Log(recording.path, "robot", [])).rows(None)
    return table.rename(columns={"timestamp": "time"}).set_index(rows)


ROWS: dict[str, Callable[[Any], pd.DataFrame]] = {
    "table-csv": _of_table,
    "rtde-csv": _of_rtde,
    **dict.fromkeys(LOADERS, rows_of_arrays),
}


def file_rows(recording: Files) -> pd.DataFrame:
    """Return the rows of a recording's file with their `time` [s], NaN where one has none; the
    index is a row's number in the file, from 0, below a table's header.

    Raises InputError for a format of several files.
    """
    if recording.format not in ROWS:
        raise InputError(f"{recording.path}: rows of `{recording.format}` are not told apart")
    table = ROWS[recording.format](recording)
    time = table["time"].to_numpy(float)
    return table.assign(time=time - first_time(time[np.isfinite(time)]))


def samples_of_rows(recording: Files, time: Array, period: float, max_gap: float) -> Labels:
    """Return the number of the sample (N,) of each row of a recording's file, by its row, -1 where
    a row has none.

    time: of the repaired samples (M,) [s]; period: of their grid [s]; max_gap: over which gaps are
    filled [s].
    """
    table = file_rows(recording)
    found = np.full(int(table.index.max()) + 1, -1)
    timed = _excerpt(table[np.isfinite(table["time"])], recording)
    if not len(timed):
        return found
    stamps = evenly_stamped(timed.reset_index(drop=True), [])["time"].to_numpy(float)
    epoch = epochs(stamps)
    stamps = continued(stamps, epoch)
    order = np.lexsort([stamps, epoch])
    grid = grid_times(stamps[order], epoch[order], period, max_gap)
    after = np.clip(np.searchsorted(time, grid), 1, len(time) - 1)
    nearest = np.where(grid - time[after - 1] <= time[after] - grid, after - 1, after)
    within = np.abs(time[nearest] - grid) <= HALF * period
    found[timed.index.to_numpy()[order]] = np.where(within, nearest, -1)
    return found


def _excerpt(table: pd.DataFrame, recording: Files) -> pd.DataFrame:
    """Return the rows between `from_s` and `to_s` of a recording."""
    time = table["time"].to_numpy(float)
    since = continued(time, epochs(time))
    start, end = recording.from_s or 0.0, recording.to_s or np.inf
    return table[(since >= start) & (since < end)]
