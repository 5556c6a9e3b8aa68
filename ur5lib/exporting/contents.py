"""What is exported of a recording: its tables, their columns and units."""

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

    start: when their time was zero, in seconds since 1970, None where unknown; tables: with `time`
    [s] as index, which all have in common, and the columns' units in `attrs["units"]`.
    """

    name: str
    start: float | None
    tables: dict[str, pd.DataFrame]


def contents(study: FinishedStudy, name: str) -> Contents:
    """Return what is exported of a recording: the tables that hold anything.

    Raises InputError where the study lacks the recording or one of its tables.
    """
    frames = {table: study.frame(name, table) for table in TABLES}
    known = {table: frame for table, frame in frames.items() if len({*frame} - {"segment"})}
    for frame in known.values():
        units = frame.attrs["units"]
        frame.attrs["units"] = {column: own_unit(column, unit) for column, unit in units.items()}
    return Contents(name, study.start(name), known)


def own_unit(column: str, unit: str) -> str:
    """Return the unit of one column of a channel: of `N, Nm`, forces have the first."""
    first, _, second = unit.partition(", ")
    return first if FIRST_HALF.search(column) or not second else second


def channels(columns: list[str]) -> dict[str, list[str]]:
    """Return the columns of each channel: those of `actual_q` are actual_q_0 to actual_q_5."""
    found = groupby(columns, key=lambda column: INDEX.sub("", column))
    return {name: [*its] for name, its in found}
