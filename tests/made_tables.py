"""Tables of results from summaries that a test makes up."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from types import UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
import pandas as pd

from ur5lib import tidy
from ur5lib.steps.make_tables import joined
from ur5lib.tables import as_record, key, read_csv, write_csv, write_rows
from ur5lib.tidy import Row, columns

NOTHING: dict[Any, Any] = {float: np.nan, int: 0, str: "", bool: False}


def table(rows: Callable[..., Iterator[Row]], found: Mapping[str, Any]) -> pd.DataFrame:
    """The table of the name of its rows, from what these take, by recording or arm.

    Several arguments are a tuple. Each is a record, or the part of its plain data that is read.
    """
    name = rows.__name__
    kinds = [*get_type_hints(rows).values()]
    each = {of: one if type(one) is tuple else (one,) for of, one in found.items()}
    made = {
        of: rows(*(given(*pair) for pair in zip(kinds, one, strict=False)))
        for of, one in each.items()
    }
    return tidy.table(name, made, "recording" if "recording" in columns()[name] else "robot")


def given(kind: Any, value: Any) -> Any:
    """An argument, which may be a part of its plain data."""
    return record(kind, value) if isinstance(value, Mapping) else value


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
    if is_dataclass(kind):
        return whole(kind, {})
    if get_origin(kind) is dict:
        return {}
    return NOTHING.get(kind, inner[0] if get_origin(kind) is Literal else [])


def empty(name: str) -> pd.DataFrame:
    return pd.DataFrame(columns=columns()[name])
