"""What the rows of tables are made from, beside the results of one recording or arm."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from ur5lib.report.reference import Printed, published
from ur5lib.timeseries.arrays import Array

Row = dict[str, Any]
Column = Array | Sequence[float | None]


class Published(NamedTuple):
    """The published tables, of which some hold values of one recording."""

    printed: Printed
    recording: str

    def values(self, table: str) -> dict[str, tuple[float, ...]]:
        """Return a table's printed values of this recording; empty for any other recording."""
        return published(getattr(self.printed, table), self.recording)


def transposed(columns: Mapping[str, Column], index: str, names: Sequence[Any]) -> list[Row]:
    """Return rows from columns that hold one value for each name of an index."""
    return [
        {index: name} | {column: values[i] for column, values in columns.items()}
        for i, name in enumerate(names)
    ]


def by_joint(columns: Mapping[str, Column]) -> Iterator[Row]:
    """Yield a row for each joint, from 1, of columns that hold one value for each."""
    count = max(map(len, columns.values()), default=0)
    yield from transposed(columns, "joint", range(1, count + 1))
