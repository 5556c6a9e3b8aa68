"""The contents of a file, and the evidence for their meaning."""

import re
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from ur5lib.errors import InputError, some
from ur5lib.importing.blocks import (
    NAMELESS,
    OF_UR,
    Block,
    grouped,
    joints_of,
    names_command,
    place_of,
    with_names,
)
from ur5lib.recordings.array_files import ENDINGS, LOADERS
from ur5lib.recordings.arrays import seconds_of
from ur5lib.recordings.delimited import first_cells, number_in, read_numbers
from ur5lib.recordings.entries import FACTORS, expand
from ur5lib.recordings.quality import Finding, Log
from ur5lib.timeseries.arrays import Array

FORMATS = ENDINGS | dict.fromkeys((".csv", ".txt", ".tsv", ".gz"), "table-csv")
CLOCK = re.compile(r"time|stamp|clock|(^|[/_])t$|sec(s|onds)?$", re.IGNORECASE)
STEPS = {"s": (1e-4, 1.0), "ms": (1.0, 1e3), "us": (1e3, 5e5), "ns": (5e5, 1e9)}
RARELY = 0.1  # share of steps in which a clock of whole seconds changes, at most
HUGE = 1e9  # in any unit of a channel
AGAIN = " again "  # and its number: a column whose name is taken
NAMES = re.compile(r"(^|[._/])name[\d\[\]._]*$")  # a column of joints' names
EPOCH = 1e9  # s; stamps after 2001 count from 1970
NIST = [  # the columns of NIST's UR5 degradation measurements, which have no header in their files
    "time",
    *("target_q", "actual_q", "target_qd", "actual_qd", "target_current", "actual_current"),
    *("target_qdd", "target_moment", "joint_control_output"),
    *("actual_TCP_pose", "actual_TCP_force", "joint_temperatures"),
]


@dataclass(frozen=True)
class Header:
    """The columns of a delimited table, in the file's order.

    repeated: those with the name of an earlier column; layout: of a table without a header, the
    source whose columns it is assumed to have.
    """

    columns: list[str] = field(default_factory=list)
    repeated: list[str] = field(default_factory=list)
    layout: str = ""


@dataclass(frozen=True)
class Evidence:
    """Sentences about a file; ambiguous: parts that the entry therefore leaves out.

    left_out: names of blocks that contradict them.
    """

    proven: list[str] = field(default_factory=list)
    assumed: list[str] = field(default_factory=list)
    ambiguous: list[str] = field(default_factory=list)
    left_out: list[tuple[str, ...]] = field(default_factory=list)

    def lines(self) -> list[str]:
        """Return the three lists as comments of a study."""
        return [
            f"# {kind}: {sentence}"
            for kind in ("proven", "assumed", "ambiguous")
            for sentence in getattr(self, kind)
        ]


@dataclass(frozen=True)
class Contents:
    """A file's blocks, and its clocks: time stamps (N,) [s] by name.

    silent: blocks that are zero throughout; units: of the clocks that are not in seconds;
    findings: of the reader; joints: of the arm; evidence: for the meaning of the blocks.
    """

    path: Path
    format: str
    header: Header
    blocks: list[Block]
    silent: list[Block]
    clocks: dict[str, Array]
    units: dict[str, str]
    findings: list[Finding]
    joints: int = OF_UR
    evidence: Evidence = field(default_factory=Evidence)


def contents(path: Path) -> Contents:
    """Return a file's contents. Raises InputError for an unreadable file or unknown format."""
    format = FORMATS.get(path.suffix.lower())
    if format is None:
        raise InputError(
            f"{path}: no reader knows files that end in {path.suffix or 'nothing'}; save it as one "
            f"of {', '.join(FORMATS)}"
        )
    findings: list[Finding] = []
    header = read_header(path) if format == "table-csv" else Header()
    if header.columns:
        arrays = _table(path, header, findings)
    else:
        arrays = LOADERS[format](path, None, findings)
    unnamed = header.columns[:1] == [f"{NAMELESS}1"]
    # a table without names has blocks of as many columns beside its first
    fitting = (count for count in (OF_UR, 7, 8) if (len(arrays) - 1) % count == 0)
    joints = next(fitting, OF_UR) if unnamed else joints_of(path, arrays)
    clocks, units = _clocks(arrays)
    if not clocks:
        shown = [f"{name} {values.shape}" for name, values in arrays.items()]
        listed = some(shown, 8) or "its arrays (it has none)"
        raise InputError(
            f"{path}: none of {listed} increases like a clock; record the time, or write "
            "the entry by hand (raw/README.md)"
        )
    every = [*_blocks(arrays, clocks, joints, unnamed)]
    silent = [block for block in every if not np.nan_to_num(block.rows).any()]
    blocks = [block for block in every if np.nan_to_num(block.rows).any()]
    return Contents(path, format, header, blocks, silent, clocks, units, findings, joints)


def read_header(path: Path) -> Header:
    """Return the columns of a table; without a header, they are named `column 1` and so on.

    Those that are numbered like a list of the joints' names, as ROS writes it, have these names.
    """
    cells, row = first_cells(path)
    if cells[0].startswith("{"):
        raise InputError(f"{path}: holds JSON, no table; save each number in a column, as CSV")
    if all(number_in(cell.replace(",", ".").encode()) is not None for cell in cells):
        nist = expand(NIST)
        if len(cells) == len(nist):
            return Header(nist, layout="NIST's UR5 degradation measurements")
        return Header([f"{NAMELESS}{k + 1}" for k in range(len(cells))])
    lists = [row[k] for k, name in enumerate(cells[: len(row)]) if NAMES.search(name)]
    cells = with_names(cells, re.findall(r"\w+", " ".join(lists)))
    first = {name: k for k, name in reversed([*enumerate(cells)])}
    names = [name if first[name] == k else f"{name}{AGAIN}{k + 1}" for k, name in enumerate(cells)]
    return Header(names, [name for name in names if name not in first and not is_unnamed(name)])


def _table(path: Path, header: Header, findings: list[Finding]) -> dict[str, np.ndarray]:
    """Return a table's columns by name, each once, of commands the first.

    Raises InputError where measurements of equal names differ.
    """
    table = read_numbers(Log(path, "robot", findings), header.columns)
    for name in header.repeated:
        first = name.split(AGAIN)[0]
        stated = name in table and not names_command(place_of(first)[0])
        if stated and not table[name].equals(table[first]):
            raise InputError(
                f"{path}, line 1: {first!r} is ambiguous: it names two columns with different "
                "numbers; give each column its own name"
            )
    once = [name for name in table if name not in header.repeated and not is_unnamed(name)]
    return {name: table[name].to_numpy() for name in once}


def is_unnamed(name: str) -> bool:
    """Return whether a column has no name, as a table's index or an empty one."""
    return not name or name.startswith(AGAIN)


def _clocks(arrays: dict[str, np.ndarray]) -> tuple[dict[str, Array], dict[str, str]]:
    """Return the increasing time stamps [s] by name, and the units of those not in seconds.

    Arrays with the name of a clock, or else the first array.
    """
    named = [name for name in arrays if CLOCK.search(name)]
    stamps = {name: seconds_of(arrays[name]) for name in named or [*arrays][:1]}
    units = {name: unit for name, values in stamps.items() if (unit := _unit(values))}
    clocks = {name: stamps[name] * FACTORS.get(unit, 1.0) for name, unit in units.items()}
    return clocks, {name: unit for name, unit in units.items() if unit != "s"}


def _unit(stamps: Array) -> str | None:
    """Return the unit in which stamps (N,) have the steps of a recording; None if none does."""
    steps = np.diff(stamps[np.isfinite(stamps)]) if stamps.ndim == 1 else np.array([])
    if len(steps) < 2 or np.mean(steps >= 0) < 0.95 or np.mean(steps > 0) < RARELY:
        return None
    step = float(np.median(steps[steps > 0]))
    unit = next((unit for unit, (low, high) in STEPS.items() if low <= step < high), None)
    within_seconds = unit == "ns" and np.nanmax(stamps) < 1e9 and np.count_nonzero(steps < 0) > 1
    return None if within_seconds else unit


def _blocks(
    arrays: dict[str, np.ndarray], clocks: dict[str, Array], joints: int, nameless: bool
) -> Iterator[Block]:
    """Yield the arrays of several columns, and the groups of single columns."""
    single = []
    for name, values in arrays.items():
        clock = _clock_of(name, max(values.shape), clocks)
        if name in clocks or clock is None:
            continue
        if values.ndim == 2 and 1 not in values.shape:
            tall = values if values.shape[0] == len(clocks[clock]) else values.T
            yield Block((name,), _possible(tall), clock, joints=joints)
        else:
            single.append(name)
    last = len(single) - joints + 1
    each = [tuple(single[k : k + joints]) for k in range(0, last, joints)]
    groups = each if nameless else [*grouped(single, joints)]
    for names in groups:
        clock = _clock_of(names[0], arrays[names[0]].size, clocks)
        columns = [_possible(arrays[name].ravel()) for name in names]
        if clock and len({len(column) for column in columns}) == 1:
            yield Block(names, np.stack(columns, axis=1), clock, joints=joints)


def _possible(values: np.ndarray) -> Array:
    """Return values with NaN for impossible ones."""
    floats = values.astype(float)
    return np.where(np.abs(floats) < HUGE, floats, np.nan)


def _clock_of(name: str, length: int, clocks: dict[str, Array]) -> str | None:
    """Return the clock of an array: equally long, and nearest to it in the file's tree.

    Of clocks with equal stamps, as in each structure of a MAT file, the first.
    """
    same = [clock for clock, stamps in clocks.items() if len(stamps) == length]
    if not same:
        return None
    stamps = clocks[max(same, key=lambda clock: _shared(name, clock))]
    return next(clock for clock in same if np.array_equal(clocks[clock], stamps))


def _shared(one: str, other: str) -> int:
    """Return the number of leading parts that two paths share."""
    pairs = zip(one.split("/"), other.split("/"), strict=False)
    return next((k for k, (a, b) in enumerate(pairs) if a != b), min(one.count("/"), 99))
