"""The contents of a file, what the user states about it, and the evidence for its meaning."""

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

from ur5lib.channels import MOST_JOINTS
from ur5lib.checks.checked import described
from ur5lib.errors import InputError, some, with_controls
from ur5lib.importing.account import Account
from ur5lib.importing.blocks import (
    JOINTS_OF_UR,
    NAMELESS_PREFIX,
    ColumnBlock,
    grouped,
    joints_of,
    with_bare_positions,
    with_names,
)
from ur5lib.importing.chosen_joints import joint_arrays, joint_columns, of_joints, of_prefix
from ur5lib.importing.clocks import ROW_CLOCK, FileClocks, clocks_of, equally_spaced
from ur5lib.importing.form_of_file import FormOfFile
from ur5lib.importing.parted_runs import TEXT_ENDINGS, PartedRun
from ur5lib.importing.spellings import (
    ARM_NAME,
    CLOCK_NAME,
    EFFORTS,
    NAME_COLUMN,
    TOOL_WORDS,
    is_computed,
    lettered_joints,
    names_positions,
    quantity,
    words,
)
from ur5lib.recordings.added import is_added
from ur5lib.recordings.arm_joints import FEWEST_JOINTS
from ur5lib.recordings.array_files import LOADERS, format_of
from ur5lib.recordings.channel_files import at_stamps, has_stamps
from ur5lib.recordings.delimited import TextTable
from ur5lib.recordings.echo_start import MESSAGE_FORMATS
from ur5lib.recordings.entries import SKIPPED_COLUMN, expand
from ur5lib.recordings.plausibility import is_silent
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log
from ur5lib.robots.description import robot_names
from ur5lib.timeseries.arrays import Array

TABLE_FORMAT = "table-csv"
PARTED_FORMAT = "channel-files"
TOPIC_NAME = re.compile(r"joint|state|motion", re.IGNORECASE)  # and no arm's
MAX_POSSIBLE_VALUE = 1e9  # in any unit of a channel; larger numbers are none
GRIPPER_RANGE = (-0.1, 1.1)  # rad, m, or the share that it is open
ROWS_TOLD = {  # by the finding
    Found.MISSING_LAST_ROW: "those of all files",
    Found.TURNED_TABLE: "its columns",
}
REPEATED_INFIX = " again "  # is added, with a number, to the name of a column that is taken
NIST_COLUMNS = [  # NIST's UR5 degradation measurements have files without a header
    "time",
    *("target_q", "actual_q", "target_qd", "actual_qd", "target_current", "actual_current"),
    *("target_qdd", "target_moment", "joint_control_output"),
    *("actual_TCP_pose", "actual_TCP_force", "joint_temperatures"),
]


@dataclass(frozen=True)
class UserStatement:
    """What the user states about files, which nothing overrules.

    robot: name of the arm; columns: channels of a table's columns in order, or `channel=name` of
    arrays; rate: of rows without a clock [Hz]; units: by channel; joint_names: of the arm, in its
    order; joint_numbers: the joint of each column, from 1; prefix: of the names of the arm's joints
    or columns, as `left_`; sensor: the file of the force sensor.
    """

    robot: str = ""
    columns: Sequence[str] = ()
    rate: float | None = None
    units: Mapping[str, str] = field(default_factory=dict)
    joint_names: Sequence[str] = ()
    prefix: str = ""
    sensor: Path | None = None
    joint_numbers: Sequence[int] = ()

    def names(self) -> dict[str, str]:
        """Return, by the name of an array in the file, the channel that the user states for it."""
        pairs = (column.partition("=") for column in self.columns if "=" in column)
        return {name: channel for channel, _, name in pairs}

    def joints(self) -> int | None:
        """Return how many joints the stated arm has, None if none is stated or it is not
        described.
        """
        is_described = self.robot and self.robot in robot_names()
        return len(described(self.robot).joints) if is_described else None


NO_STATEMENT = UserStatement()


@dataclass(frozen=True)
class TableHeader:
    """The columns of a delimited table, in the file's order.

    repeated: columns with the name of an earlier one; layout: of a table without a header, where
    the columns that it is assumed to have come from; entry: the columns as the user states them.
    """

    columns: list[str] = field(default_factory=list)
    repeated: list[str] = field(default_factory=list)
    layout: str = ""
    entry: list[str] = field(default_factory=list)


@dataclass(frozen=True)
class FileContents:
    """A file's blocks of columns and its clocks.

    blocks: with numbers; silent: with zeros alone; findings: of the reader; stated: by the user;
    joints: number of the arm's joints; account: what is stated about the blocks; precedent: form of
    another file, like which this one is read.
    """

    path: Path
    format: str
    header: TableHeader
    blocks: list[ColumnBlock]
    silent: list[ColumnBlock]
    clocks: FileClocks
    findings: list[Finding]
    stated: UserStatement = NO_STATEMENT
    joints: int = JOINTS_OF_UR
    account: Account = field(default_factory=Account)
    precedent: FormOfFile | None = None

    def has_clock(self) -> bool:
        """Return whether the file has time stamps."""
        return ROW_CLOCK not in self.clocks.stamps

    def block(self, names: tuple[str, ...]) -> ColumnBlock:
        """Return the block of some names."""
        return next(block for block in self.blocks if block.names == names)

    def meant(self, meaning: str, clock: str) -> ColumnBlock | None:
        """Return the block with a meaning on a clock with the same stamps; None if there is
        none.
        """
        stamps = self.clocks.stamps
        for block in self.blocks:
            same = np.array_equal(stamps[block.clock], stamps[clock], equal_nan=True)
            if same and block.meaning() == meaning and block.names not in self.account.excluded:
                return block
        return None

    def on_clock(self, clock: str, other: str, stamps: Array, unit: str) -> "FileContents":
        """Return the file with the blocks of `clock` moved to the clock `other` with stamps (N,)
        [s].
        """
        blocks = [replace(b, clock=other) if b.clock == clock else b for b in self.blocks]
        units = {name: u for name, u in self.clocks.units.items() if name != other}
        units |= {} if unit == "s" else {other: unit}
        clocks = FileClocks(self.clocks.stamps | {other: stamps}, units)
        return replace(self, blocks=blocks, clocks=clocks)


def arm_labels(file: FileContents) -> list[str]:
    """Return, for a file of several arms, the part of the positions' names that only one arm has,
    as `left`; empty for one arm.

    They come from the parts of a bag's topic, else from words that distinguish arms.
    """
    names = [
        b.names
        for b in file.blocks
        if names_positions(b.stem()) and b.rows.shape[1] >= FEWEST_JOINTS
    ]
    names = [own for own in names if not is_computed(own[0])]
    places = [own[0].split("/")[:-1] for own in names if file.format in MESSAGE_FORMATS]
    # /joint_states and /motion, /ur/joint_states and /ur/motion are topics, no arms of one
    places = [place for place in places if len(place) > 2 and not TOPIC_NAME.search(place[-1])]
    topics = Counter("/".join(place[:-1]) for place in places)
    if of_topic := [place[-1] for place in places if topics["/".join(place[:-1])] > 1]:
        return of_topic
    found = [{*map(str.lower, ARM_NAME.findall(" ".join(own)))} for own in names]
    alone = [own - set[str]().union(*(it for it in found if it != own)) for own in found]
    labels = [*dict.fromkeys(min(own, default="") for own in alone)]
    return labels if len(labels) > 1 and "" not in labels else []


def contents(
    file: Path | PartedRun, stated: UserStatement = NO_STATEMENT, timed: bool = True
) -> FileContents:
    """Return the contents of a file, or of the files of one run.

    timed: whether a column may be the clock by its place alone. Raises InputError for an unreadable
    file, and where rows of several files do not belong together.
    """
    findings: list[Finding] = []
    path, account = file.folder / file.name if isinstance(file, PartedRun) else file, Account()
    format = PARTED_FORMAT if isinstance(file, PartedRun) else format_of(path) or TABLE_FORMAT
    if path.is_file() and path.stat().st_size == 0:
        raise InputError(f"{path} is empty; record it again, or copy it again from its source")
    header, arrays = _read(file, path, format, stated, findings, account)
    if (own := _joints_of_arm(stated)) and any(f.code == Found.UNNAMED_JOINTS for f in findings):
        with suppress(InputError):  # for a message may have other names than the description
            return contents(file, replace(stated, joint_names=own), timed)
    if controls := with_controls([path.name, *header.columns, *arrays]):
        raise InputError(f"{path}: the name {controls!r} has a control character; rename it there")
    for finding in findings:
        if taken_for := ROWS_TOLD.get(finding.code):
            account.tell("assumed", "rows", taken_for, "position", finding.detail)
    account.order.extend(header.columns or arrays)
    clocks = _clocks(arrays, stated, timed, account)
    rest = [name for name in arrays if name not in clocks.stamps and name not in clocks.doubts]
    unnamed = header.columns[:1] == [f"{NAMELESS_PREFIX}1"]
    width = _width_of_nameless(len(rest), stated.joints()) if unnamed else None
    chosen = joint_columns(rest, stated.joint_names)
    parts = [*_chosen_blocks(arrays, chosen, clocks)]
    rest = [name for name in rest if not any(name in names for names in chosen.values())]
    parts += _blocks({name: arrays[name] for name in rest}, clocks, width, account)
    parts = with_bare_positions(parts)
    told = len(stated.joint_names) or stated.joints() or width
    joints, named = told or joints_of(path, parts), stated.names()
    parts = _without_gripper(parts, joints, account) if stated.joints() else parts
    _expect_named(named, arrays, parts, path)
    all_blocks = [
        replace(b, joints=joints, stated=named.get(b.names[0]) or named.get(b.stem(), b.stated))
        for b in parts
    ]
    beside_efforts = {block.clock for block in all_blocks if block.meaning() in EFFORTS}
    # a measured state first, and one that has efforts
    all_blocks.sort(key=lambda b: (is_computed(b.names[0]), b.clock not in beside_efforts))
    silent = [b for b in all_blocks if is_silent(b.rows) and not _follows_a_hand(b, all_blocks)]
    blocks = [block for block in all_blocks if not any(block is one for one in silent)]
    described_by = path, format, header, blocks, silent, clocks, findings, stated, joints, account
    return FileContents(*described_by)


def _expect_named(
    named: Iterable[str], columns: Iterable[str], blocks: Iterable[ColumnBlock], path: Path
) -> None:
    """Raise InputError where the user names a column that the file does not have."""
    if lacking := {*named} - {*columns, *(block.stem() for block in blocks)}:
        raise InputError(
            f"{path}: --columns names {some(sorted(lacking))}, but it has {some([*columns], 8)}"
        )


def _joints_of_arm(stated: UserStatement) -> Sequence[str]:
    """Return the names of the stated arm's joints; none where the user names joints, or where the
    arm is not described or has sizes of joints alone.
    """
    joints = described(stated.robot).joints if stated.joints() and not stated.joint_names else ()
    return joints if len({*joints}) == len(joints) else ()


def _follows_a_hand(block: ColumnBlock, blocks: Sequence[ColumnBlock]) -> bool:
    """Return whether a block has target accelerations of zero while the target moves, as of an arm
    that a hand leads.
    """
    zero = block.meaning() == "target_qdd" and not block.rows.any()
    return zero and any(b.meaning() == "target_qd" and not is_silent(b.rows) for b in blocks)


def _read(
    file: Path | PartedRun,
    path: Path,
    format: str,
    stated: UserStatement,
    findings: list[Finding],
    account: Account,
) -> tuple[TableHeader, dict[str, np.ndarray]]:
    """Return a table's header and its columns, or an empty header and a file's arrays, without
    those of other joints or another prefix than the user states.
    """
    header = TableHeader()
    if isinstance(file, PartedRun):
        arrays = _together(file, findings, account)
    elif format == TABLE_FORMAT:
        text = TextTable(Log(path, "robot", findings))
        header = _header(text, stated)
        arrays = _table(text, header, account)
    else:
        arrays = LOADERS[format](path, None, findings)
        if stated.joint_names and format in MESSAGE_FORMATS:
            findings.clear()
            arrays = LOADERS[format](path, joint_arrays(arrays, stated.joint_names), findings)
        _state_unread(findings, account)
    arrays = {name: own for name, own in arrays.items() if not is_added(name)}
    arrays = of_prefix(arrays, stated.prefix, path, account) if stated.prefix else arrays
    if stated.joint_names:
        arrays = of_joints(arrays, stated.joint_names, path, account)
    return header, arrays


def _together(run: PartedRun, findings: list[Finding], account: Account) -> dict[str, np.ndarray]:
    """Return the columns of a run's files by name, at the stamps of the first file if each has its
    own.

    Raises InputError where the files differ in rows and not each has stamps that show how.
    """
    first, tables = run.files[0], LOADERS[PARTED_FORMAT](run.folder, run.files, findings)
    timed = any(rows.shape[1] == 1 and CLOCK_NAME.search(name) for name, rows in tables.items())
    stamps = {n: rows[:, 0] for n, rows in tables.items() if not timed and has_stamps(rows)}
    if len({*map(len, tables.values())}) > 1 and len(stamps) < len(tables):
        counts = ", ".join(f"{name} {len(tables[name])}" for name in run.files)
        raise InputError(
            f"{run.folder}: files of one run differ in rows ({counts}), and not each has stamps in "
            "its first column: record the time in each, or cut them to the same rows"
        )
    arrays = dict[str, np.ndarray]()
    if first in stamps:
        tables, arrays = at_stamps(tables, first), {f"{first}_0": stamps[first]}
        moved = [n for n in stamps if not np.array_equal(stamps[n], stamps[first])]
        if moved:
            at_its = f"{', '.join(moved)}: values between their own stamps, at those of {first}"
            account.tell("assumed", "rows", f"those of {first}", "numbers", at_its)
    for name, rows in tables.items():
        columns = {f"{name}_{k}": rows[:, k] for k in range(1, rows.shape[1])}
        arrays |= columns if name in stamps else {name: rows}
    return arrays


def _state_unread(findings: Iterable[Finding], account: Account) -> None:
    """State in the account which columns the reader left out, and why."""
    for finding in findings:
        for name in finding.channels if finding.code == Found.UNREAD else ():
            if is_added(name):
                continue
            why = finding.detail.rpartition(": ")[2]
            account.state("left out", (name,), name, "name", why)


def _clocks(
    arrays: Mapping[str, np.ndarray], stated: UserStatement, timed: bool, account: Account
) -> FileClocks:
    """Return the clocks among arrays, or else the rows' numbers as one; state why others are
    none.
    """
    joints = lettered_joints(arrays)  # among them T
    arrays = {n: values for n, values in arrays.items() if n not in joints}
    by_place = timed and not stated.rate
    likely = {n: values for n, values in arrays.items() if by_place or CLOCK_NAME.search(n)}
    clocks = clocks_of(likely, stated.units.get("time"))
    if stated.rate:
        clocks = FileClocks({}, {}, dict.fromkeys(clocks.stamps, "the rows are timed by --rate"))
    for name, reason in clocks.doubts.items():
        account.state("left out", (name,), name, "numbers", reason)
    for name, note in clocks.notes.items():
        account.state("assumed", (name,), name, "numbers", note)
    if not clocks.stamps:
        return equally_spaced(arrays, stated.rate, clocks.doubts)
    return _with_second_clock(arrays, clocks, stated.joints() or JOINTS_OF_UR)


def _with_second_clock(
    arrays: Mapping[str, np.ndarray], clocks: FileClocks, joints: int
) -> FileClocks:
    """Return the clocks of a table without names, with the column after the first one if that is a
    clock, too, and whole groups of joints are left.
    """
    rest = [name for name in arrays if name not in clocks.stamps]
    if not rest or not rest[0].startswith(NAMELESS_PREFIX) or len(rest) % joints != 1:
        return clocks
    second = clocks_of({rest[0]: arrays[rest[0]]}, None)
    stamps, units = clocks.stamps | second.stamps, clocks.units | second.units
    return clocks._replace(stamps=stamps, units=units)


def _without_gripper(
    blocks: Sequence[ColumnBlock], joints: int, account: Account
) -> list[ColumnBlock]:
    """Return blocks without the column of a gripper, if positions have one more than the joints.

    It is the only column that rests, or the only one with values from 0 to 1; else the first if
    that has such values and the last has not; else the last.
    """
    of_joints = (block for block in blocks if not words(block.stem()) & TOOL_WORDS)
    wide = [block for block in of_joints if block.rows.shape[1] == joints + 1]
    positions = [
        b for b in wide if b.is_nameless() or b.stated == "actual_q" or names_positions(b.stem())
    ]
    whole = any(b.rows.shape[1] == joints and names_positions(b.stem()) for b in blocks)
    if whole or not positions:
        return [*blocks]
    low, high = (find(positions[0].rows, axis=0) for find in (np.nanmin, np.nanmax))
    inside = np.flatnonzero((low > GRIPPER_RANGE[0]) & (high < GRIPPER_RANGE[1]))
    rests = np.any([np.ptp(np.nan_to_num(b.rows), axis=0) == 0 for b in wide], axis=0)
    alone = (found for found in (np.flatnonzero(rests), inside) if len(found) == 1)
    at_first = 0 in inside and joints not in inside
    column = next((int(found[0]) for found in alone), 0 if at_first else joints)
    kept = [k for k in range(joints + 1) if k != column]
    parts = [b.only(kept) if any(b is one for one in wide) else b for b in blocks]
    for block in wide:
        named = block.names[column] if len(block.names) > 1 else f"{block.title}_{column}"
        of_gripper = (
            f"one more than {joints} joints: taken for a gripper's; else --columns names it"
        )
        account.state("check", (named,), named, "numbers", of_gripper)
    return parts


def _width_of_nameless(columns: int, joints: int | None) -> int:
    """Return how many columns form a group in a table without names: those of the joints, or one
    more for a gripper.
    """
    counts = (joints, joints + 1) if joints else (JOINTS_OF_UR, 7, 8)
    fitting = (count for count in counts if columns % count == 0)
    return next(fitting, joints or JOINTS_OF_UR)


def _header(text: TextTable, stated: UserStatement) -> TableHeader:
    """Return the columns of a table; without a header, they are named `column 1` and so on.

    Columns that are numbered get the joints' names if the table lists these, as ROS does. Raises
    InputError if the user states another number of columns.
    """
    path, cells, row = text.log.path, text.cells, text.below
    if cells[0].startswith("{"):
        raise InputError(f"{path}: holds JSON, no table; save each number in a column, as CSV")
    if stated.columns and not stated.names():
        return _stated_header(path, stated, len(cells))
    if not text.has_names():
        nist = expand(NIST_COLUMNS)
        if len(cells) == len(nist):
            return TableHeader(nist, layout="NIST's UR5 degradation measurements")
        return TableHeader([f"{NAMELESS_PREFIX}{k + 1}" for k in range(len(cells))])
    lists = [row[k] for k, name in enumerate(cells[: len(row)]) if NAME_COLUMN.search(name)]
    cells = with_names(cells, re.findall(r"\w+", " ".join(lists)))
    cells = _numbered(cells, stated)
    first_place = {name: k for k, name in reversed([*enumerate(cells)])}
    names = [
        name if first_place[name] == k else f"{name}{REPEATED_INFIX}{k + 1}"
        for k, name in enumerate(cells)
    ]
    repeated = [name for name in names if name not in first_place and not is_unnamed(name)]
    return TableHeader(names, repeated)


def _stated_header(path: Path, stated: UserStatement, count: int) -> TableHeader:
    names = expand(stated.columns, stated.joints() or JOINTS_OF_UR)
    if len(names) != count:
        raise InputError(
            f"{path}, line 1: has {count} columns, but --columns names {len(names)}; name each, "
            f"a channel without suffix for all its columns, `{SKIPPED_COLUMN}` for one to skip"
        )
    return TableHeader(names, entry=[*stated.columns])


def _numbered(cells: Sequence[str], stated: UserStatement) -> list[str]:
    """Return columns with the names of the stated arm's joints replaced by their numbers."""
    names = _joints_of_arm(stated)
    longest_first = sorted(enumerate(names), key=lambda numbered: -len(numbered[1]))
    found = [next((pair for pair in longest_first if pair[1] in cell), None) for cell in cells]
    pairs = zip(cells, found, strict=True)
    return [cell.replace(pair[1], str(pair[0])) if pair else cell for cell, pair in pairs]


def _table(text: TextTable, header: TableHeader, account: Account) -> dict[str, np.ndarray]:
    """Return a table's numeric columns by name; of equal names the first, the others stated."""
    table, _ = text.rows(header.columns)
    kept = dict[str, np.ndarray]()
    for name in header.columns:
        if name in header.repeated:
            twice = "its name appears twice in the header; the first is read"
            account.state("left out", (name,), name.split(REPEATED_INFIX)[0], "name", twice)
        elif header.entry and name.startswith(SKIPPED_COLUMN):
            account.state("left out", (name,), name, "option", "to be skipped, by --columns")
        elif is_unnamed(name):
            title = f"column {header.columns.index(name) + 1}"
            account.state("left out", (name,), title, "position", "it has no name")
        elif name not in table:
            account.state("left out", (name,), name, "numbers", "it holds text")
        else:
            kept[name] = table[name].to_numpy()
    return kept


def _chosen_blocks(
    arrays: Mapping[str, np.ndarray], chosen: Mapping[str, tuple[str, ...]], clocks: FileClocks
) -> Iterator[ColumnBlock]:
    """Yield a block for each quantity of the joints that the user names."""
    for stem, names in chosen.items():
        if block := _joined(names, arrays, clocks):
            yield replace(block, stated=quantity(stem, len(names), len(names)) or "")


def _joined(
    names: tuple[str, ...], arrays: Mapping[str, np.ndarray], clocks: FileClocks
) -> ColumnBlock | None:
    """Return single columns as a block; None where they differ in length, or have no clock."""
    columns = [_possible(arrays[name].ravel()) for name in names]
    clock = _clock_of(names[0], len(columns[0]), clocks.stamps)
    if clock is None or len({*map(len, columns)}) > 1:
        return None
    return ColumnBlock(names, np.stack(columns, axis=1), clock)


def is_unnamed(name: str) -> bool:
    """Return whether a column has no name, as a table's index or an empty one."""
    return not name or name.startswith(REPEATED_INFIX)


def _blocks(
    arrays: dict[str, np.ndarray], clocks: FileClocks, width: int | None, account: Account
) -> Iterator[ColumnBlock]:
    """Yield a block for each array of several columns, and for each group of single columns.

    width: of a group where columns have no names, None where they have.
    """
    single, in_matrices = [], all(_is_matrix(values) for values in arrays.values())
    for name, values in arrays.items():
        clock = _clock_of(name, max(values.shape, default=0), clocks.stamps)
        if clock is None:
            reason = "no clock of the file has as many stamps as it has rows"
            account.state("left out", (name,), name, "numbers", reason)
        elif values.ndim == 2 and 1 not in values.shape:
            tall = values if values.shape[0] == len(clocks.stamps[clock]) else values.T
            block = ColumnBlock((name,), _possible(tall), clock)
            is_table = in_matrices or (_is_matrix(tall) and name.endswith(TEXT_ENDINGS))
            yield from _of_matrix(block) if is_table else [block]
        else:
            single.append(name)
    starts = range(0, len(single), width) if width else []
    for names in [tuple(single[k : k + (width or 0)]) for k in starts] or grouped(single):
        if joined := _joined(names, arrays, clocks):
            yield joined
        else:
            title = ColumnBlock(names, np.empty((0, 0)), "").title
            account.state("left out", names, title, "numbers", "its columns differ in length")


def _is_matrix(values: np.ndarray) -> bool:
    """Return whether an array is a table without names: it has more columns than any quantity."""
    return values.ndim == 2 and min(values.shape) > MOST_JOINTS


def _of_matrix(block: ColumnBlock) -> Iterator[ColumnBlock]:
    """Yield the quantities of a table without names, as many columns each as an arm has joints."""
    count = block.rows.shape[1]
    width = _width_of_nameless(count, None)
    yield from (block.only(range(k, min(k + width, count))) for k in range(0, count, width))


def _possible(values: np.ndarray) -> Array:
    """Return values with NaN for impossible ones."""
    floats = values.astype(float)
    return np.where(np.abs(floats) < MAX_POSSIBLE_VALUE, floats, np.nan)


def _clock_of(name: str, length: int, clocks: dict[str, Array]) -> str | None:
    """Return the name of an array's clock: of equal length, nearest in the file's tree; None if
    there is none. Of clocks with the same stamps, it is the first.
    """
    same = [clock for clock, stamps in clocks.items() if len(stamps) == length]
    if not same:
        return None
    stamps = clocks[max(same, key=lambda clock: _shared_parts(name, clock))]
    return next(clock for clock in same if np.array_equal(clocks[clock], stamps, equal_nan=True))


def _shared_parts(path: str, other: str) -> int:
    """Return the number of leading parts that two paths share."""
    pairs = zip(path.split("/"), other.split("/"), strict=False)
    return next((k for k, (a, b) in enumerate(pairs) if a != b), min(path.count("/"), 99))


def block_widths(file: FileContents) -> str:
    """Return in words the blocks of a file with their numbers of columns, and what is not read."""
    widths = [f"{block.title} ({block.rows.shape[1]})" for block in file.blocks]
    seen = [name for one in file.findings if one.code == Found.UNREAD for name in one.channels]
    unread = f"; seen, not read: {some(seen, 6)}" if seen else ""
    nothing = "no numbers that are read" if seen else "nothing beside its clock"
    return (some(widths, 6) or nothing) + unread
