"""The tables of results: `columns.yaml` names them, a function of the same name makes the rows.

Its parameters name the kinds of results that it needs, of one recording or arm: only those with the
first kind have rows, others are None where there are none. `published` and `every`, the results of
the first kind by recording, may follow.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from ur5lib.timeseries.arrays import Array

Row = dict[str, Any]
Column = Array | Sequence[float | None]


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
