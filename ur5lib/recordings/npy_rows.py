"""Rows of a NumPy file as lines of CSV, with all digits."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd

from ur5lib.errors import InputError
from ur5lib.recordings.limits import expect_room
from ur5lib.tables import exact_text

SIGNATURE = b"\x93NUMPY"
ROWS_OF_BLOCK = 20_000


def npy_lines(path: Path) -> Iterator[bytes]:
    """Yield the rows of a NumPy file in blocks of lines, after a line of names if it has them.

    Raises InputError where it is damaged, holds Python objects, or has no rows of numbers.
    """
    try:
        rows = np.load(path, mmap_mode="r", allow_pickle=False)
    except Exception as error:  # of damaged files, the library may raise anything
        raise InputError(
            f"{path} is a damaged NumPy file, or holds Python objects, which could run code; "
            "save its numbers by np.save, or copy it again from its source"
        ) from error
    kinds = {rows.dtype[k].base.kind for k in range(len(rows.dtype.names or ()))}
    if rows.ndim > 2 or rows.ndim == 0 or not (kinds or {rows.dtype.kind}) <= {*"biuf"}:
        shape = " × ".join(map(str, rows.shape)) or "one value"
        raise InputError(
            f"{path} holds {shape} of {rows.dtype.name:.40}, no rows of numbers; save one array of "
            "rows, or several by np.savez"
        )
    expect_room(path, rows.nbytes / 8)
    names = rows.dtype.names
    header = [*_columns_of(rows.dtype, names)] if names else None
    for start in range(0, max(len(rows), 1), ROWS_OF_BLOCK):
        part = np.array(rows[start : start + ROWS_OF_BLOCK])
        table = np.column_stack([part[name] for name in names]) if names else part
        begins = header is not None and start == 0
        yield exact_text(pd.DataFrame(table, columns=header), begins).encode()


def _columns_of(kind: np.dtype, names: tuple[str, ...]) -> Iterator[str]:
    """Yield a name for each column of a record's fields."""
    for name in names:
        width = int(np.prod(kind[name].shape))
        yield from (f"{name}_{k}" for k in range(width)) if kind[name].shape else [name]
