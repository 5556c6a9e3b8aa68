"""Tables of results from summaries that a test makes up."""

from collections.abc import Mapping, Sequence
from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from types import UnionType
from typing import Any, Literal, get_args, get_origin, get_type_hints

import numpy as np
import pandas as pd

from ur5lib.tables import as_record, key, read_csv, write_csv, write_rows
from ur5lib.thesis.reference import Printed

READ_OTHERWISE = ("signals", "torques", "closed_loop", "arm")  # than from JSON
NOTHING: dict[Any, Any] = {float: np.nan, int: 0, str: "", bool: False}


def table(name: str, printed: Printed | None = None, **summaries: Any) -> pd.DataFrame:
    """A table from summaries by recording or arm, for each kind of result.

    They are records, or the part of their plain data that the table reads.
    """
    kinds = {
        kind: found
        if kind in READ_OTHERWISE
        else {owner: record(records()[kind], one) for owner, one in found.items()}
        for kind, found in summaries.items()
    }
    return make_table(name, kinds, printed)


def gathered(kind: type, rows: Sequence[object], folder: Path) -> pd.DataFrame:
    """The table of a study of one arm, ur5, to which a step writes these rows."""
    part, whole = folder / "parameters" / "ur5" / "rows.csv", folder / "tables" / "rows.csv"
    write_rows(kind, rows, part)
    write_csv(joined([str(part)]), whole)
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
        given = {name: whole(hints[name], data[key(name)]) for name in hints if key(name) in data}
        lacking = {key(name): nothing(hints[name]) for name in needed if name not in given}
        return lacking | {key(name): value for name, value in given.items()}
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
    return pd.DataFrame(columns=declarations()[name].columns)
