"""What the records of all tables have in common: columns as arrays, with names, units and shapes.

A record is a frozen dataclass with fields declared by `channel`. It is read from and written to a
table by these declarations alone.
"""

import math
import re
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field, fields
from functools import cache, partial
from typing import TYPE_CHECKING, Any, Self

import numpy as np
import pandas as pd

from ur5lib.tables import ByKey, Source, read_columns, read_footer, write_table
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import period

JOINTS = ("0", "1", "...")  # labels, as many as the arm has joints
SIX = tuple("012345")
WRENCH = ("Fx", "Fy", "Fz", "nx", "ny", "nz")
WRENCH_UNITS = ["N"] * 3 + ["Nm"] * 3
XYZ = tuple("012")

Load = Callable[[list[str], type], Array]  # names and type to a table's columns (N, len(names))


@dataclass(frozen=True)
class Channel:
    """The columns of one quantity, <name>_<label> for each label, or <name> without labels.

    shape: of one sample, labels: of its flat elements in order; -1 in the shape is the number of
    joints, with JOINTS as labels; optional: whether it may be absent; keys: that may replace `{}`
    in the name; without them, any key that does not end in _std (standard deviations).
    """

    name: str
    unit: str
    labels: tuple[str, ...]
    shape: tuple[int, ...]
    dtype: type
    optional: bool = False
    keys: tuple[str, ...] = ()

    @property
    def several(self) -> bool:
        """Return whether a table may have the channel several times, once for each key."""
        return "{}" in self.name

    def columns(self, name: str, joints: int = 6) -> list[str]:
        """Return the names of the columns; name: of the channel, with its key filled in."""
        whole = math.prod(self.sized(joints))
        labels = map(str, range(whole)) if self.labels == JOINTS else self.labels
        return [f"{name}_{label}" for label in labels] or [name]

    def sized(self, joints: int) -> tuple[int, ...]:
        """Return the shape of a sample for an arm with so many joints."""
        return tuple(joints if size < 0 else size for size in self.shape)

    def joints_in(self, names: Collection[str]) -> int:
        """Return the number of joints in a table's columns of this channel, 0 without them."""
        if self.labels != JOINTS:
            return 0
        pattern = re.escape(self.name).replace(r"\{\}", ".+") + r"_(\d+)"
        places = [int(match[1]) for name in names if (match := re.fullmatch(pattern, name))]
        of_each_joint = abs(math.prod(self.shape))
        return math.ceil((max(places, default=-1) + 1) / of_each_joint)

    def stems(self, names: Collection[str], joints: int) -> dict[str, str]:
        """Return the channel's name by key, for keys with all columns in a table.

        The key is "" for a channel without keys.
        """
        stems, have = {"": self.name}, {*names}
        if self.several:
            first, *_ = self.columns(self.name)
            pattern = re.compile(re.escape(first).replace(r"\{\}", r"(.+(?<!_std))"))
            found = [match[1] for name in names if (match := pattern.fullmatch(name))]
            keys = [key for key in self.keys if key in found] if self.keys else found
            stems = {key: self.name.format(key) for key in keys}
        return {key: stem for key, stem in stems.items() if {*self.columns(stem, joints)} <= have}

    def samples(self, load: Load, stem: str, joints: int) -> Array:
        """Return the samples (N, *shape); stem: the channel's name, with its key filled in."""
        flat = load(self.columns(stem, joints), self.dtype)
        return flat.reshape(len(flat), *self.sized(joints))

    def named_arrays(self, value: Any) -> Iterator[tuple[str, Array]]:
        """Yield each column's name and samples (N,) of a field's value."""
        arrays = value if self.several else {"": value}
        for key, array in arrays.items():
            flat = np.reshape(array, (len(array), math.prod(np.shape(array)[1:]))).T
            joints = len(flat) // abs(math.prod(self.shape))
            yield from zip(self.columns(self.name.format(key), joints), flat, strict=True)


def channel(
    name: str,
    unit: str,
    labels: tuple[str, ...] = (),
    shape: tuple[int, ...] | None = None,
    dtype: type = np.float64,
    optional: bool = False,
    keys: tuple[str, ...] = (),
) -> Any:
    """Declare a field of samples (N, *shape), by default one element for each label.

    An optional one is None where it is absent; with `{}` in its name, it is a dict by key.
    """
    own = (-1,) if labels == JOINTS else (len(labels),) if labels else ()
    declared = Channel(name, unit, labels, own if shape is None else shape, dtype, optional, keys)
    metadata = {"channel": declared}
    # a default would be an attribute of the class and hide the file's channel
    if declared.several:
        return field(default_factory=dict, metadata=metadata)
    if optional:
        return field(default_factory=type(None), metadata=metadata)
    return field(metadata=metadata)


@dataclass(frozen=True, kw_only=True)
class Table:
    """A table of samples on the robot's uniform grid; time: (N,) [s]."""

    time: Array = channel("time", "s")

    @property
    def period(self) -> float:
        """Return the period of the samples [s]."""
        return period(self.time)

    @classmethod
    def read(cls, path: Source, rows: Labels | None = None) -> Self:
        """Read a table, each channel when it is first used, since long recordings exceed memory.

        rows: to read, ascending, all by default. Raises KeyError if a column of a channel that is
        not optional is missing.
        """
        footer = read_footer(path)
        load = partial(read_columns, path, rows=rows, footer=footer)
        made = cls._of([*footer.schema.names], load)
        made.__dict__["_path"] = path
        return made

    def anew(self, rows: Labels | None = None) -> Self:
        """Return a table of the same file in which no channel is loaded yet, so that the memory of
        this one can be freed.

        rows: to read, ascending, all by default. A table in memory is returned with these rows.
        """
        path = self.__dict__.get("_path")
        if path is not None:
            return self.read(path, rows)
        return self if rows is None else self._at(rows)

    def _at(self, rows: Labels) -> Self:
        """Return the rows `rows` of the table, in memory."""
        values = {name: getattr(self, name) for name in _channels(type(self))}
        taken: dict[str, Any] = {
            name: {key: own[rows] for key, own in value.items()}
            if isinstance(value, Mapping)
            else value
            if value is None
            else value[rows]
            for name, value in values.items()
        }
        return type(self)(**taken)

    @property
    def file(self) -> Source:
        """Return the file of a table that was read from one."""
        source: Source = self.__dict__["_path"]
        return source

    @classmethod
    def from_table(cls, table: pd.DataFrame) -> Self:
        """Return the record of a table in memory; raises as `read`."""

        def load(names: list[str], dtype: type) -> Array:
            return table[names].to_numpy(dtype, copy=True)

        return cls._of([*map(str, table)], load)

    @classmethod
    def _of(cls, names: list[str], load: Load) -> Self:
        channels, made = _channels(cls), object.__new__(cls)
        # the number of joints of the widest channel
        joints = max(declared.joints_in(names) for declared in channels.values()) or 6
        loads = made.__dict__["_loads"] = {}
        for name, declared in channels.items():
            stems = declared.stems(names, joints).items()
            found = {key: partial(declared.samples, load, stem, joints) for key, stem in stems}
            if not (found or declared.optional or declared.several):
                raise KeyError(declared.name)
            by_key = ByKey({key: cache(samples) for key, samples in found.items()})
            loads[name] = by_key if declared.several else found.get("")
        return made

    if not TYPE_CHECKING:  # a type checker knows the fields by their declarations

        def __getattr__(self, name: str) -> Any:
            """Load a channel from the file at the first use of its field."""
            if name not in self.__dict__.get("_loads", ()):
                raise AttributeError(name)
            samples = self._loads[name]
            self.__dict__[name] = samples() if callable(samples) else samples
            return self.__dict__[name]

    def write(self, path: Source) -> None:
        """Write the table, each column with its unit; absent channels are left out."""
        columns: dict[str, Array] = {}
        units: dict[str, str] = {}
        for name, declared in _channels(type(self)).items():
            value = getattr(self, name)
            if value is not None:
                named = dict(declared.named_arrays(value))
                columns |= named
                units |= dict.fromkeys(named, declared.unit)
        write_table(columns, path, units)


def _channels(record: type[Table]) -> dict[str, Channel]:
    """Return the channels of a record by the names of its fields."""
    return {own.name: own.metadata["channel"] for own in fields(record)}


@dataclass(frozen=True, kw_only=True)
class SegmentedTable(Table):
    """Samples of a recording that may have gaps.

    segment: (N,), labels of unbroken stretches.
    """

    segment: Labels = channel("segment", "1", dtype=np.int64)
