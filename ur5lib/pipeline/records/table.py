"""What the records of all tables have in common: columns as arrays, with names, units and shapes.

A record is a frozen dataclass whose fields are declared with `channel` or `channels`. It is read
from and written to a table by these declarations alone.
"""

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass, field, fields
from pathlib import Path
from typing import Any, Self

import numpy as np
import pandas as pd

from ur5lib.tables import read_table, write_table
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import period

JOINTS = tuple("012345")
WRENCH = ("Fx", "Fy", "Fz", "nx", "ny", "nz")
XYZ = tuple("012")


@dataclass(frozen=True)
class Channel:
    """The columns of one quantity, <name>_<label> for each label, or <name> where it has none.

    shape: of one sample, whose flat elements the labels name in order; several: whether `{}` in
    the name stands for a key, which is one of `keys` where these are given.
    """

    name: str
    unit: str
    labels: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: type
    several: bool
    keys: tuple[str, ...]

    def columns(self, name: str) -> list[str]:
        """Return the columns' names; name: the channel's, its key filled in."""
        return [f"{name}_{label}" for label in self.labels] or [name]

    def read(self, table: pd.DataFrame) -> Any:
        """Return the samples (N, *shape), None where absent; by key where there are several."""
        if self.several:
            found = {key: self._array(table, self.name.format(key)) for key in self._found(table)}
            return {key: values for key, values in found.items() if values is not None}
        return self._array(table, self.name)

    def named_arrays(self, value: Any) -> Iterator[tuple[str, Array]]:
        """Yield each column's name and samples (N,) of a field's value."""
        arrays = value if self.several else {"": value}
        for key, array in arrays.items():
            flat = np.reshape(array, (len(array), math.prod(self.shape))).T
            yield from zip(self.columns(self.name.format(key)), flat, strict=True)

    def _array(self, table: pd.DataFrame, name: str) -> Array | None:
        columns = self.columns(name)
        if not set(columns) <= set(table):
            return None
        flat = table[columns].to_numpy(self.dtype, copy=True)
        return flat.reshape(len(table), *self.shape)

    def _found(self, table: pd.DataFrame) -> list[str]:
        """Return the keys of which the table has the columns, in their declared order."""
        pattern = re.compile(re.escape(self.columns(self.name)[0]).replace(r"\{\}", "(.+)"))
        found = [match[1] for name in table if (match := pattern.fullmatch(str(name)))]
        return [key for key in self.keys if key in found] if self.keys else found


def channel(
    name: str,
    unit: str,
    labels: tuple[str, ...] = (),
    shape: tuple[int, ...] | None = None,
    dtype: type = np.float64,
    optional: bool = False,
) -> Any:
    """Declare a field of samples (N, *shape); an optional one is None where it is absent."""
    own = (len(labels),) if labels else ()
    declared = Channel(name, unit, labels, own if shape is None else shape, dtype, False, ())
    metadata = {"channel": declared}
    return field(default=None, metadata=metadata) if optional else field(metadata=metadata)


def channels(name: str, unit: str, labels: tuple[str, ...], keys: tuple[str, ...] = ()) -> Any:
    """Declare a field of samples (N, len(labels)) by the key that stands for `{}` in the name."""
    declared = Channel(name, unit, labels, (len(labels),) if labels else (), np.float64, True, keys)
    return field(default_factory=dict, metadata={"channel": declared})


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of samples on the robot's uniform grid; time: (N,) [s]."""

    time: Array = channel("time", "s")

    @property
    def period(self) -> float:
        """Return the cycle [s]."""
        return period(self.time)

    @classmethod
    def read(cls, path: str | Path) -> Self:
        """Read a table. Raises KeyError where a column that is not optional is missing."""
        return cls.from_table(read_table(path))

    @classmethod
    def from_table(cls, table: pd.DataFrame) -> Self:
        """Return the record of a table in memory; raises as `read`."""
        found = {own.name: own.metadata["channel"].read(table) for own in fields(cls)}
        for own in fields(cls):
            if found[own.name] is None and own.default is not None:
                raise KeyError(own.metadata["channel"].name)
        return cls(**found)

    def write(self, path: str | Path) -> None:
        """Write the table, each column with its unit; absent channels are left out."""
        columns: dict[str, Array] = {}
        units: dict[str, str] = {}
        for own in fields(self):
            value, declared = getattr(self, own.name), own.metadata["channel"]
            if value is not None:
                named = dict(declared.named_arrays(value))
                columns |= named
                units |= dict.fromkeys(named, declared.unit)
        write_table(pd.DataFrame(columns), path, units)


@dataclass(frozen=True, kw_only=True)
class SegmentedTable(Table):
    """Samples of a recording that gaps may divide.

    segment: (N,), labels of unbroken stretches.
    """

    segment: Labels = channel("segment", "1", dtype=np.int64)
