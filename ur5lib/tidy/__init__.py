"""The rows of the study's tables, tidy: one value a row, SI units, joints from 1.

A function of a table's name yields its rows of one recording or arm; `columns.yaml` has the columns
of each table.
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.strict import read_yaml
from ur5lib.timeseries.arrays import Array

Row = dict[str, Any]
Column = Array | Sequence[float | None]
WORDS = {True: "yes", False: "no"}


@cache
def columns() -> dict[str, list[str]]:
    """Return the columns of each table."""
    declared: dict[str, list[str]] = read_yaml(Path(__file__).with_name("columns.yaml"))
    return declared


def rows_of(table: str, rows: Iterable[Row]) -> list[Row]:
    """Return rows of a table as they are written, without what is no column of it.

    Numbers are Python's, True and False yes and no.
    """
    names = columns()[table]
    return [{name: _plain(row[name]) for name in names if name in row} for row in rows]


def written(**tables: Iterable[Row]) -> dict[str, list[Row]]:
    """Return the rows of several tables, by name, as they are written."""
    return {name: rows_of(name, rows) for name, rows in tables.items()}


def part(name: str, rows: Iterable[Row]) -> pd.DataFrame:
    """Return the rows of one recording or arm as a part of a table, which `make_tables` joins."""
    return pd.DataFrame(rows_of(name, rows), columns=columns()[name][1:])


def table(name: str, rows: Mapping[str, Iterable[Row]], owner: str = "recording") -> pd.DataFrame:
    """Return a table from its rows by the recordings or arms (`robot`) that they are of."""
    each = [{owner: of, **row} for of, own in rows.items() for row in rows_of(name, own)]
    return pd.DataFrame(each, columns=columns()[name])


def _plain(value: Any) -> Any:
    value = value.item() if isinstance(value, np.generic) else value
    return WORDS[value] if isinstance(value, bool) else value


def transposed(
    columns: Mapping[str, Column], index: str, names: Sequence[Any], **about: Any
) -> Iterator[Row]:
    """Yield rows from columns that hold one value for each name of an index; about: of all rows."""
    for i, name in enumerate(names):
        yield about | {index: name} | {column: values[i] for column, values in columns.items()}


def by_joint(columns: Mapping[str, Column], **about: Any) -> Iterator[Row]:
    """Yield a row for each joint, from 1, of columns that hold one value for each."""
    count = max(map(len, columns.values()), default=0)
    yield from transposed(columns, "joint", range(1, count + 1), **about)
