"""What a study's tables are made from: the results of one recording or arm."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from ur5lib.report.reference import Printed, published
from ur5lib.timeseries.arrays import Array

Row = dict[str, Any]
Column = Array | Sequence[float | None]


@dataclass(frozen=True)
class Source:
    """The results of one recording or arm, of which a table's rows are made.

    name: of the recording or arm; kinds: results by their kind, then by recording or arm;
    printed: published tables.
    """

    name: str
    kinds: Mapping[str, Mapping[str, Any]]
    printed: Printed = Printed()

    def __getitem__(self, kind: str) -> Any:
        """Return the result of a kind, `{}` where there is none."""
        return self.kinds[kind].get(self.name, {})

    def published(self, table: str) -> dict[str, tuple[float, ...]]:
        """Return a table's printed values of this recording; empty for any other recording."""
        return published(getattr(self.printed, table), self.name)


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
