"""Columns of a table that hold text, as names and modes, or dates with the time of day."""

import math
import re
from collections.abc import Sequence
from datetime import UTC, datetime

import numpy as np
import pandas as pd

from ur5lib.channels import CHANNELS, channels_of
from ur5lib.timeseries.arrays import Array

DATE = re.compile(rb"\d{4}-\d\d-\d\d[T ]\d\d:\d\d")  # ISO 8601
NOT_A_NUMBER = ["", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "null", "NULL", "None"]
SAMPLE = 20  # rows that show what a column holds


def number_in(cell: bytes) -> float | None:
    """Return a cell's number, NaN for an empty cell, None for anything else."""
    text = cell.strip().decode(errors="replace")
    if text in NOT_A_NUMBER:
        return math.nan
    try:
        return None if "_" in text else float(text)  # float() would accept 1_000
    except ValueError:
        return None


def text_columns(
    rows: Sequence[Sequence[bytes]], names: Sequence[str]
) -> tuple[list[str], list[str]]:
    """Return the names of the columns of dates, and of those of other text that nothing needs.

    rows: cells of the first rows. None are returned where no column holds numbers.
    """
    columns = dict(zip(names, zip(*rows, strict=True), strict=False))
    worded = [name for name, cells in columns.items() if _is_text(cells)]
    if len(worded) == len(columns):
        return [], []
    dates = [name for name in worded if all(DATE.match(cell.strip()) for cell in columns[name])]
    return dates, [name for name in worded if name not in dates and not _is_needed(name)]


def _is_needed(name: str) -> bool:
    """Return whether a column is named like the time or a channel with a unit: no mode."""
    return name == "timestamp" or any(CHANNELS[found].unit != "1" for found in channels_of(name))


def _is_text(cells: Sequence[bytes]) -> bool:
    """Return whether cells hold text and no number."""
    found = [*map(number_in, cells)]
    return None in found and all(value is None or np.isnan(value) for value in found)


def seconds_of_dates(dates: pd.Series) -> Array:
    """Return the seconds since 1970 (N,) of ISO dates, NaN for others; without a zone, of UTC."""
    stamps = pd.to_datetime(dates, format="ISO8601", utc=True, errors="coerce")
    counted = stamps.astype("datetime64[ns, UTC]").astype("int64").to_numpy() * 1e-9
    return np.where(stamps.isna(), np.nan, counted)


def seconds_of_date(cell: bytes) -> float | None:
    """Return the seconds since 1970 of an ISO date, None for anything else."""
    try:
        stamp = datetime.fromisoformat(cell.strip().decode(errors="replace"))
    except ValueError:
        return None
    return (stamp if stamp.tzinfo else stamp.replace(tzinfo=UTC)).timestamp()
