"""Columns of a table that hold text, as names and modes, or dates with the time of day."""

import re
from collections.abc import Callable, Sequence
from datetime import UTC, datetime
from functools import partial

import numpy as np
import pandas as pd

from ur5lib.channels import CHANNELS, channels_of
from ur5lib.timeseries.arrays import Array

DATE = re.compile(rb"\d{4}-\d\d-\d\d[T ]\d\d:\d\d")  # ISO 8601
SAMPLE = 20  # rows that show what a column holds


def text_columns(
    rows: Sequence[Sequence[bytes]], names: Sequence[str], number: Callable[[bytes], float]
) -> tuple[list[str], list[str]]:
    """Return the names of the columns of dates, and of those of other text that nothing needs.

    rows: cells of the first rows; number: of a cell, NaN for an empty one; raises ValueError for
    text. None are returned where no column holds numbers.
    """
    columns = dict(zip(names, zip(*rows, strict=True), strict=False))
    worded = [name for name, cells in columns.items() if _is_text(cells, number)]
    if len(worded) == len(columns):
        return [], []
    dates = [name for name in worded if all(DATE.match(cell.strip()) for cell in columns[name])]
    return dates, [name for name in worded if name not in dates and not _is_needed(name)]


def _is_needed(name: str) -> bool:
    """Return whether a column is named like the time or a channel with a unit: no mode."""
    return name == "timestamp" or any(CHANNELS[found].unit != "1" for found in channels_of(name))


def _is_text(cells: Sequence[bytes], number: Callable[[bytes], float]) -> bool:
    """Return whether cells hold text and no number."""
    found = [*map(partial(_number_or_none, number=number), cells)]
    return None in found and all(value is None or np.isnan(value) for value in found)


def _number_or_none(cell: bytes, number: Callable[[bytes], float]) -> float | None:
    try:
        return number(cell)
    except ValueError:
        return None


def seconds_of_dates(dates: pd.Series) -> Array:
    """Return the seconds since 1970 (N,) of ISO dates, NaN for others; without a zone, of UTC."""
    stamps = pd.to_datetime(dates, format="ISO8601", utc=True, errors="coerce")
    counted = stamps.astype("datetime64[ns, UTC]").astype("int64").to_numpy() * 1e-9
    return np.where(stamps.isna(), np.nan, counted)


def seconds_of_date(cell: bytes) -> float:
    """Return the seconds since 1970 of an ISO date. Raises ValueError for anything else."""
    stamp = datetime.fromisoformat(cell.strip().decode(errors="replace"))
    return (stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)).timestamp()
