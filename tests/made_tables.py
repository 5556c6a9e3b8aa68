"""Tables of results from summaries that a test makes up."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from enum import EnumType
from pathlib import Path
from types import UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
import pandas as pd

from ur5lib.steps.make_tables import OF_ARMS, OF_MOTION, OF_RECORDINGS, joined
from ur5lib.tables import as_record, key, read_csv, table_by_owner, write_csv, write_rows

COLUMNS = {
    name: [owner, *(field.name for field in fields(kind))]
    for owner, tables in (("recording", OF_RECORDINGS | OF_MOTION), ("robot", OF_ARMS))
    for name, kind in tables.items()
}
NOTHING: dict[Any, Any] = {float: np.nan, int: 0, str: "", bool: False}


def table(kind: type, rows: Mapping[str, Iterable[object]]) -> pd.DataFrame:
    """The table of rows by recording or arm."""
    return table_by_owner(kind, rows, "robot" if kind in OF_ARMS.values() else "recording")


def gathered(kind: type, rows: Sequence[object], folder: Path) -> pd.DataFrame:
    """The table of a study of one arm, ur5, to which a step writes these rows."""
    part, whole = folder / "parameters" / "ur5" / "rows.csv", folder / "tables" / "rows.csv"
    write_rows(kind, rows, part)
    write_csv(joined([part])["rows"], whole)
    return read_csv(whole)


def record(kind: Any, data: Any) -> Any:
    """A record from the part of its plain data that a test gives."""
    return as_record(kind, whole(kind, data))


def whole(kind: Any, data: Any) -> Any:
    """Plain data with what a record of this kind needs besides."""
    inner = get_args(kind)
    if get_origin(kind) is UnionType:
        return whole(inner[0], data)
    if is_dataclass(kind) and isinstance(data, Mapping):
        hints = get_type_hints(kind)
        needed = [own.name for own in fields(kind) if own.default is own.default_factory is MISSING]
        told = {name: whole(hints[name], data[key(name)]) for name in hints if key(name) in data}
        lacking = {key(name): nothing(hints[name]) for name in needed if name not in told}
        return lacking | {key(name): value for name, value in told.items()}
    if isinstance(data, Mapping):
        return {name: whole(inner[-1], one) for name, one in data.items()} if inner else data
    if isinstance(data, list) and inner and get_origin(kind) in (list, tuple):
        return [whole(inner[0], one) for one in data]
    return data


def nothing(kind: Any) -> Any:
    """An empty value of a kind."""
    inner = get_args(kind)
    if get_origin(kind) is UnionType:
        return None
    if get_origin(kind) is tuple and Ellipsis not in inner:
        return [nothing(one) for one in inner]
    if isinstance(kind, EnumType):
        return next(iter(kind))
    if is_dataclass(kind):
        return whole(kind, {})
    if get_origin(kind) is dict:
        return {}
    return NOTHING.get(kind, inner[0] if get_origin(kind) is Literal else [])


def empty(name: str) -> pd.DataFrame:
    return pd.DataFrame(columns=COLUMNS[name])
