"""The exported contents of a recording: tables, columns and units."""

import re
from dataclasses import dataclass
from itertools import groupby

import pandas as pd

from ur5lib.finished import FinishedStudy

TABLES = ("signals", "motion", "currents", "forces", "sensor")
INDEX = re.compile(r"_[0-9]+$|_[Fnft][xyz]$|(?<=imu_[agm])[xyz]$")
FIRST_HALF = re.compile(r"_[0-2]$|_F[xyz]$")  # of a pose or a wrench


@dataclass(frozen=True)
class Contents:
    """A recording's tables by name.

    start: time zero in seconds since 1970, None where unknown; tables: with the common index `time`
    [s], and the columns' units in `attrs["units"]`.
    """

    name: str
    start: float | None
    tables: dict[str, pd.DataFrame]


def contents(study: FinishedStudy, name: str) -> Contents:
    """Return the tables of a recording that are not empty.

    Raises InputError where the study lacks the recording or one of its tables.
    """
    frames = {table: study.frame(name, table) for table in TABLES}
    filled = {table: frame for table, frame in frames.items() if len({*frame} - {"segment"})}
    for frame in filled.values():
        units = frame.attrs["units"]
        frame.attrs["units"] = {column: column_unit(column, unit) for column, unit in units.items()}
    return Contents(name, study.start(name), filled)


def column_unit(column: str, unit: str) -> str:
    """Return the unit of one column of a channel: of `N, Nm`, forces have the first."""
    first, _, second = unit.partition(", ")
    return first if FIRST_HALF.search(column) or not second else second


def channels(columns: list[str]) -> dict[str, list[str]]:
    """Return the columns of each channel: those of `actual_q` are actual_q_0 to actual_q_5."""
    groups = groupby(columns, key=lambda column: INDEX.sub("", column))
    return {name: [*group] for name, group in groups}
