"""Blocks: columns of a file that belong together, and their meaning by name."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ur5lib.channels import MOST_JOINTS
from ur5lib.errors import InputError
from ur5lib.importing.spellings import (
    GRIPPER_WORDS,
    UNIT_MEANINGS,
    WHOLE_NAMES,
    kind_of_quantity,
    lettered_joints,
    names_joints,
    names_positions,
    place_of,
    quantity,
    unit_text,
    without_unit,
    words,
)
from ur5lib.recordings.arm_joints import FEWEST_JOINTS, JOINTS, arms_among, joint_order
from ur5lib.recordings.entries import OPPOSITE_SIGN, UNKNOWN
from ur5lib.records.account import Evidence
from ur5lib.timeseries.arrays import Array

NAMELESS_PREFIX = "column "  # and its number: a column of a table without a header
JOINTS_OF_UR = 6
OTHER_JOINT_COUNTS = (4, 5, 7, 8, 9)  # a gripper's fingers among them
AXES = ("x", "y", "z")


@dataclass(frozen=True)
class ColumnBlock:
    """Columns of a file that belong together.

    names: as in a study, one for all columns or one for each; rows: (N, k); clock: name of the
    block's time stamps; factors: by which the file's numbers were multiplied, empty if they are as
    read; joints: number of joints of the file's arm; stated: the block's meaning if the user, the
    numbers or the whole of which it is a part give it, "" if its own name does; is_known: whether
    its unit is; of_array: whether the names are an array's with numbers that the file has not.
    """

    names: tuple[str, ...]
    rows: Array
    clock: str
    factors: tuple[float, ...] = ()
    joints: int = JOINTS_OF_UR
    stated: str = ""
    is_known: bool = True
    of_array: bool = False

    def scaled(self, factors: Array | float) -> "ColumnBlock":
        """Return the block with each column multiplied by a factor."""
        before = np.array(self.factors or [1.0] * self.rows.shape[1])
        return replace(self, rows=self.rows * factors, factors=tuple(before * factors))

    def all_factors(self) -> tuple[float, ...]:
        """Return the factor of each column by which the file's numbers were multiplied."""
        return self.factors or (1.0,) * self.rows.shape[1]

    def unit(self) -> str | list[float] | None:
        """Return the unit of the file's numbers as a study has it, None for SI."""
        if not self.is_known:
            return UNKNOWN
        whole = [float(f"{factor:.7g}") for factor in self.factors or (1.0,)]
        unit_names = {1.0: None, -1.0: OPPOSITE_SIGN, 1e-3: "mA"}
        return unit_names.get(whole[0], whole) if len({*whole}) == 1 else whole

    def only(self, kept: Iterable[int]) -> "ColumnBlock":
        """Return the block with some of its columns, by their numbers from 0; columns of an array
        are named `<name>_<k>`.
        """
        kept, of_array = [*kept], len(self.names) == 1
        every = (
            [f"{self.names[0]}_{k}" for k in range(self.rows.shape[1])] if of_array else self.names
        )
        names = tuple(every[k] for k in kept)
        return replace(
            self, names=names, rows=self.rows[:, kept], of_array=of_array or self.of_array
        )

    @property
    def title(self) -> str:
        """Return the block's name, or the first and the last of its names."""
        return self.names[0] if len(self.names) == 1 else f"{self.names[0]} … {self.names[-1]}"

    @property
    def evidence(self) -> Evidence:
        """Return what identifies a block whose numbers prove nothing: "option" of the user, its
        "name", or its "position" in the file.
        """
        return "option" if self.stated else "position" if self.is_nameless() else "name"

    def is_nameless(self) -> bool:
        """Return whether the block is from a table without a header."""
        return self.names[0].startswith(NAMELESS_PREFIX) and not self.stated

    def stem(self) -> str:
        """Return the name of its quantity, a path in the file, without the joints' numbers."""
        return place_of(self.names[0])[0] if len(self.names) > 1 else self.names[0]

    def meaning(self) -> str | None:
        """Return the meaning by statement or name: an RTDE channel, a kind of joint quantity or a
        spatial quantity; None for none.
        """
        return self.stated or quantity(self.stem(), self.rows.shape[1], self.joints)


def _by_stem(names: Iterable[str]) -> dict[str, dict[int, str]]:
    """Return, by quantity, the names of its columns by their place, from 0 or 1; joints' and axes'
    columns apart.
    """
    stems = defaultdict[str, dict[int, str]](dict)
    for name in names:
        stem, place = place_of(name)
        stem += unit_text(name) if names_joints(stem) else ""
        stem += "_axes" if without_unit(name).endswith(AXES) else ""
        stems[name if place in stems[stem] else stem][place] = name
    return stems


def grouped(names: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Yield the names of single columns that belong together: of joints, of a pose, or x, y, z.

    They are in the order of the joints' names, or else of their numbers; motors with other names
    (`elbow_flex.pos`) are in the file's order.
    """
    while lettered := lettered_joints(names):
        yield lettered
        names = [name for name in names if name not in lettered]
    stems = _by_stem(names)
    for motors in _by_motor(names):
        if len({place_of(name)[0] for name in motors}) > 1:
            order = joint_order(motors) if len(motors) == JOINTS_OF_UR else None
            yield tuple(motors[k] for k in order or range(len(motors)))
            for places in stems.values():
                for place in [place for place, name in places.items() if name in motors]:
                    del places[place]
    for places in stems.values():
        if places:
            yield tuple(places[place] for place in sorted(places))


def _by_motor(names: Sequence[str]) -> Iterator[tuple[str, ...]]:
    """Yield, for each arm and quantity, the columns that are named by motor and quantity, as
    elbow_flex.pos, without those of a gripper or a rail.
    """
    tails = defaultdict[tuple[str, str], dict[str, str]](dict)
    for name in names:
        path, _, leaf = without_unit(name).rpartition("/")
        motor, mark, tail = leaf.rpartition(".") if "." in leaf else leaf.rpartition("_")
        if mark and kind_of_quantity(tail) and not words(motor) & GRIPPER_WORDS:
            tails[path, mark + tail][motor] = name
        elif path in WHOLE_NAMES and not words(leaf) & GRIPPER_WORDS:
            tails[path, ""][leaf] = name
    for motors in tails.values():
        arms = [arm.names for arm in arms_among([*motors])] or [tuple(motors)]
        yield from (tuple(motors[one] for one in arm) for arm in arms if len(arm) >= FEWEST_JOINTS)


def with_names(columns: Sequence[str], joints: Sequence[str]) -> list[str]:
    """Return columns with their numbers replaced by names of joints, if `joints` are an arm's.

    joints: in the order in which the columns of each quantity are numbered.
    """
    order = joint_order(tuple(joints))
    if order is None:
        return [*columns]
    named = dict(zip(order, JOINTS, strict=True))
    renamed = {
        column: f"{stem}_{named[place - min(places)]}"
        for stem, places in _by_stem(columns).items()
        for place, column in places.items()
        if len(places) == len(joints) and place - min(places) in named
    }
    return [renamed.get(column, column) for column in columns]


def with_bare_positions(blocks: Sequence[ColumnBlock]) -> list[ColumnBlock]:
    """Return blocks, of which those named by joints alone have the meaning of their unit; if one of
    angles, or without unit, is left and none is named as positions, it is taken for the positions.
    """
    blocks = [_with_meaning_of_unit(block) for block in blocks]
    bare = [
        block
        for block in blocks
        if FEWEST_JOINTS <= block.rows.shape[1] <= MOST_JOINTS
        and len(block.names) > 1
        and not (block.is_nameless() or block.stated)
        and names_joints(block.stem())
        and np.ptp(np.nan_to_num(block.rows), axis=0).any()
    ]
    wide = (block for block in blocks if block.rows.shape[1] >= FEWEST_JOINTS)  # no x, y, z
    if len(bare) != 1 or any(names_positions(block.stem()) for block in wide):
        return [*blocks]
    return [replace(b, stated="actual_q") if b is bare[0] else b for b in blocks]


def _with_meaning_of_unit(block: ColumnBlock) -> ColumnBlock:
    is_bare = len(block.names) > 1 and not block.is_nameless() and names_joints(block.stem())
    meaning = UNIT_MEANINGS.get(unit_text(block.names[0]), "") if is_bare else ""
    return replace(block, stated=meaning) if meaning else block


def joints_of(path: Path, blocks: Sequence[ColumnBlock]) -> int:
    """Return the number of joints by the positions among a file's blocks: 6 if a block has so many,
    else the most of 4, 5, 7, 8 and 9 that one has.

    Raises InputError where they are more than an arm's.
    """
    positions = [b for b in blocks if b.stated == "actual_q" or names_positions(b.stem())]
    counts = {block.rows.shape[1]: block.title for block in positions}
    others = max((count for count in counts if count in OTHER_JOINT_COUNTS), default=JOINTS_OF_UR)
    if JOINTS_OF_UR in counts:
        return JOINTS_OF_UR
    if others > MOST_JOINTS:
        raise InputError(
            f"{path} holds {others} joints: {counts[others]} are positions; arms have up to "
            f"{MOST_JOINTS}. Save the arm's joints without those of a gripper"
        )
    return others
