"""Columns of Parquet and Feather files."""

from collections.abc import Collection
from pathlib import Path

import numpy as np
import pyarrow as pa
import pyarrow.feather as feather
import pyarrow.parquet as pq

from ur5lib.recordings.quality import Finding
from ur5lib.recordings.storage import Arrays, damaged


def parquet_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the columns of numbers by name. Raises InputError when the file is damaged."""
    try:
        return _columns(pq.read_table(path, columns=None), wanted)
    except Exception as error:  # of damaged files, the library may raise anything
        raise damaged(path, "a Parquet file", error) from error


def feather_arrays(path: Path, wanted: Collection[str] | None, findings: list[Finding]) -> Arrays:
    """Return the columns of numbers by name. Raises InputError when the file is damaged."""
    try:
        table = feather.read_table(path)
        table.validate(full=True)
        return _columns(table, wanted)
    except Exception as error:  # of damaged files, the library may raise anything
        raise damaged(path, "a Feather file", error) from error


def _columns(table: pa.Table, wanted: Collection[str] | None) -> Arrays:
    """Return the columns: of numbers as (n,), of stamps in seconds, of lists as (n, k)."""
    names = table.column_names
    columns = {n: _column(table.column(k)) for k, n in enumerate(names) if names.count(n) == 1}
    return {
        name: values
        for name, values in columns.items()
        if values is not None and (wanted is None or name in wanted)
    }


def _column(column: pa.ChunkedArray) -> np.ndarray | None:
    kind = column.type
    if pa.types.is_timestamp(kind):
        return column.cast(pa.timestamp("ns")).cast(pa.int64()).to_numpy() * 1e-9
    if pa.types.is_integer(kind) or pa.types.is_floating(kind):
        return column.cast(pa.float64()).to_numpy()
    if pa.types.is_list(kind) or pa.types.is_fixed_size_list(kind):
        rows = column.to_pylist()
        width = len(rows[0] or []) if rows else 0
        return np.array([row if row and len(row) == width else [np.nan] * width for row in rows])
    return None
