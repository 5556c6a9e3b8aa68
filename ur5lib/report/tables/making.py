"""The study's tables from the results of all recordings and arms: `columns.yaml` lists them.

Tidy: one value a row, SI units, joints from 1.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from types import UnionType
from typing import Any, NamedTuple, get_args, get_type_hints

import numpy as np
import pandas as pd

from ur5lib.records.table import Table
from ur5lib.report.reference import Printed, Published
from ur5lib.report.tables import Row, files, forces, friction, models, motion
from ur5lib.robots.description import Robot, load_robot
from ur5lib.strict import read_yaml
from ur5lib.tables import ByKey, read_cells, read_record

MODULES = (files, motion, models, friction, forces)
WORDS = {True: "yes", False: "no"}


class Declared(NamedTuple):
    """A table: its columns, the function that makes its rows, and the parameters of this, typed."""

    columns: list[str]
    rows: Callable[..., Iterator[Row]]
    needs: dict[str, Any]

    @property
    def first(self) -> str:
        """Return the kind of result whose recordings or arms have rows."""
        return next(iter(self.needs))


@cache
def declarations() -> dict[str, Declared]:
    """Return each declared table."""
    groups = read_yaml(Path(__file__).with_name("columns.yaml"))
    return {
        name: Declared(columns, rows, _parameters(rows))
        for module in MODULES
        for name, columns in groups[module.__name__.rpartition(".")[2]].items()
        for rows in [getattr(module, name)]
    }


def _parameters(function: Callable[..., Any]) -> dict[str, Any]:
    """Return the types of a function's parameters, of an optional one without None."""
    hints = get_type_hints(function)
    del hints["return"]
    optional = {name: get_args(hint)[0] for name, hint in hints.items() if type(hint) is UnionType}
    return hints | optional


@cache
def records() -> dict[str, Any]:
    """Return the record of each kind of result, as the functions of the tables take it."""
    return {kind: record for own in declarations().values() for kind, record in own.needs.items()}


def lazy_results(kind: str, paths: Sequence[str]) -> ByKey[Any]:
    """Return the results of a kind by recording or arm, read on access; JSON, small, is cached.

    paths: each lies in the folder of its recording or arm.
    """
    record = records()[kind]
    read: Callable[[str], Any] = cache(partial(read_record, record))
    if record is Robot:
        read = load_robot
    elif isinstance(record, type) and issubclass(record, Table):
        read = record.read
    return ByKey({Path(path).parent.name: partial(read, path) for path in paths})


def make_table(
    name: str, kinds: Mapping[str, Mapping[str, Any]], printed: Printed | None = None
) -> pd.DataFrame:
    """Return a table, with True and False as yes and no.

    kinds: results by their kind, then by recording or arm; printed: published tables.
    """
    columns, rows_of, needs = declared = declarations()[name]
    owners = kinds[declared.first]
    first = "recording" if "recording" in columns else "robot"

    def given(need: str, owner: str) -> Any:
        if need == "published":
            return Published(printed or {}, owner)
        return owners if need == "every" else kinds[need].get(owner)

    rows = [
        {first: owner} | {column: _in_words(value) for column, value in row.items()}
        for owner in owners
        for row in rows_of(*(given(need, owner) for need in needs))
    ]
    return pd.DataFrame(rows, columns=columns)


def joined(parts: Sequence[str]) -> pd.DataFrame:
    """Return a table that a step has written for each arm, in the folder of its name.

    parts: paths; their cells are taken over as text.
    """
    tables = {Path(part).parent.name: read_cells(part) for part in parts}
    return pd.concat(tables, names=["robot", None]).reset_index("robot")


def joined_texts(parts: Sequence[str]) -> str:
    """Return a table as CSV from those of each recording.

    Thousands of tables are joined as text, since parsing takes a hundred times as long.
    """
    header = parts[0].partition("\n")[0]
    return "".join([header, "\n", *(part.partition("\n")[2] for part in parts)])


def _in_words(value: Any) -> Any:
    return WORDS[bool(value)] if isinstance(value, bool | np.bool_) else value
