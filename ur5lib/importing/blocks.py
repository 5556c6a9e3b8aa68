"""Blocks: columns of a file that belong together, their meaning by name, and their joints."""

import re
from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5lib.channels import MOST_JOINTS, SUFFIXES
from ur5lib.errors import InputError
from ur5lib.recordings.entries import OPPOSITE
from ur5lib.recordings.rosbag import JOINT_NAMES, JOINTS, joint_order
from ur5lib.timeseries.arrays import Array

TARGET = {"target", "desired", "des", "ref", "reference", "cmd", "command", "commanded", "setpoint"}
TARGET |= {"action", "actions"}  # of a policy
CONTAINERS = {"data", "value", "values", "signals"}  # in which a path ends behind its quantity
TOOL = {"tcp", "tool", "cartesian", "transform", "tf", "eef"}
OF_IMU = {"imu", "mag", "magnetometer"}  # mx is a magnetic field there
UNIT = re.compile(r" *[\[(](?!J?\d*[\])])[^\])]*[\])]$", re.IGNORECASE)  # at the end of a name
NUMBERED = r"(.*?)(?:[jJ]oint|[aA]xis|(?<![A-Za-z])[jJaA])[ _.]?(\d)"
NAMELESS = "column "  # and its number: a column of a table without a header
MEANINGS = {  # of a block with a column for each joint, by a word of its name
    "q": {"q", "position", "positions", "pos", "angle", "angles"},
    "qd": {"qd", "dq", "qdot", "velocity", "velocities", "vel", "speed", "speeds"},
    "qdd": {"qdd", "ddq", "acceleration", "accelerations", "acc"},
    "current": {"i", "current", "currents", "curr", "cur"},
    "torque": {"m", "torque", "torques", "tau", "moment", "moments"},
    "effort": {"effort", "efforts"},
}
OF_TOOL = {
    "actual_TCP_force": {"force", "wrench"},
    "actual_TCP_speed": {"speed", "velocity"},
    "actual_TCP_pose": {"pose", "vector", "position", "positions", "pos", "rot", "coord"},
}
IN_SPACE = {  # of a block with three columns
    "force": {"force", "forces", "f"},
    "torque": {"torque", "torques", "moment", "t", "m", "n"},
    "position": {"position", "positions", "translation"},
}


@dataclass(frozen=True)
class Block:
    """Columns of a file that belong together.

    names: as in a study, one for all columns or one for each; rows: (N, k); clock: name of their
    time stamps; factors: by which the file's numbers were multiplied, none if they are as read;
    joints: of the file's arm.
    """

    names: tuple[str, ...]
    rows: Array
    clock: str
    factors: tuple[float, ...] = ()
    joints: int = 6

    def scaled(self, factors: Array) -> "Block":
        """Return the block with each column multiplied by a factor."""
        whole = tuple(float(factor) for factor in factors * (self.factors or 1.0))
        return replace(self, rows=self.rows * factors, factors=whole)

    def unit(self) -> str | list[float] | None:
        """Return the unit of the file's numbers as a study has it, None for SI."""
        if len({*self.factors}) <= 1:
            return {-1.0: OPPOSITE, 1e-3: "mA"}.get((self.factors or (1.0,))[0])
        return [float(f"{factor:.7g}") for factor in self.factors]

    @property
    def title(self) -> str:
        """Return the name, or the first and the last one."""
        return self.names[0] if len(self.names) == 1 else f"{self.names[0]} … {self.names[-1]}"

    def is_nameless(self) -> bool:
        """Return whether the block is from a table without a header."""
        return self.names[0].startswith(NAMELESS)

    def stem(self) -> str:
        """Return the name of its quantity, a path in the file, without the joints' numbers."""
        return place_of(self.names[0])[0] if len(self.names) > 1 else self.names[0]

    def meaning(self) -> str | None:
        """Return the meaning of the name: RTDE channel, kind of joint or spatial quantity."""
        stem = self.stem()
        last, width = _last(stem), self.rows.shape[1]
        if last in SUFFIXES and len(SUFFIXES[last]) == width:
            return last
        words = _words(last) | ({"target"} if names_command(stem) else set())
        if width == 6 and words & {"wrench", "ft"} and not words & (TOOL | TARGET):
            return "wrench"
        if width == self.joints and not words & TOOL:
            return _joint_meaning(words)
        if words & TARGET:
            return None
        spatial = _meaning(words, IN_SPACE) if width == 3 and not words & OF_IMU else None
        if spatial in ("force", "torque"):
            return spatial
        if words & TOOL or width == 7:
            return _meaning(words, OF_TOOL)
        return spatial


def _last(name: str) -> str:
    """Return the last part of a path in a file that tells a quantity."""
    parts = name.rstrip("/").split("/")
    return next((part for part in reversed(parts) if part.lower() not in CONTAINERS), parts[-1])


def _words(name: str) -> set[str]:
    """Return the words of a name in lower case."""
    return {*re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", name).lower())}


def names_command(stem: str) -> bool:
    """Return whether a quantity was commanded: by a word of its name, or as `q_d`, `O_dP_EE_c`."""
    return bool(_words(stem) & TARGET) or bool(re.search(r"[a-z]_[dc]$", stem, re.IGNORECASE))


def _meaning(words: set[str], meanings: Mapping[str, set[str]]) -> str | None:
    """Return the first meaning that has one of the words."""
    return next((meaning for meaning, known in meanings.items() if words & known), None)


def _joint_meaning(words: set[str]) -> str | None:
    kind = _meaning(words, MEANINGS)
    if kind is None or kind == "effort":
        return kind
    if words & TARGET:
        return "target_moment" if kind == "torque" else f"target_{kind}"
    return {"qdd": None, "torque": "actual_current_as_torque"}.get(kind, f"actual_{kind}")


def _by_stem(names: Iterable[str]) -> dict[str, dict[int, str]]:
    """Return the names of each quantity's columns, by their places."""
    stems = defaultdict[str, dict[int, str]](dict)
    for name in names:
        stem, place = place_of(name)
        stems[stem][place] = name
    return stems


def grouped(names: Sequence[str], joints: int = 6) -> Iterator[tuple[str, ...]]:
    """Yield the names of single columns that belong together (joints; pose; x, y, z), others alone.

    In the order of the joints' names, or else of their numbers.
    """
    for places in _by_stem(names).values():
        ordered = tuple(places[place] for place in sorted(places))
        yield from [ordered] if len(ordered) in (3, 6, joints) else ((name,) for name in ordered)


def with_names(columns: Sequence[str], joints: Sequence[str]) -> list[str]:
    """Return columns with the names of joints for their numbers, where these name an arm's joints.

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


def place_of(name: str) -> tuple[str, int]:
    """Return a column's name without unit, joint, number or axis, and its place; -1 for none."""
    name = UNIT.sub("", name)
    for place, joint in enumerate(JOINT_NAMES):
        if joint.search(name):
            return joint.sub("", name), place
    if numbered := re.fullmatch(r"(.*?)[ _.]*[(\[]?[jJ]?(\d)[)\]]?", name):
        return numbered[1], int(numbered[2])
    if numbered := re.fullmatch(NUMBERED + r"[ _.](.{2,})", name):  # Joint1_Pos, J1 pos, A1.pos
        return numbered[1] + numbered[3], int(numbered[2])
    if part := re.fullmatch(r"(?:(.*)[ _./])?([ftmnFTM])([xyz])", name):  # Fx, wrench_tz
        return f"{part[1] or ''}_{part[2]}", "xyz".index(part[3])
    if axis := re.fullmatch(r"(.*?)_?([xyz])", name):
        return axis[1], "xyz".index(axis[2])
    return name, -1


OF_UR = 6  # joints of the maker's arms
MORE = (7, 8, 9)  # joints, a gripper's fingers among them


class OfJoints(NamedTuple):
    """Columns with one value for each joint: their title, their kind of quantity, their number."""

    title: str
    kind: str
    joints: int


def joints_of(path: Path, arrays: Mapping[str, np.ndarray]) -> int:
    """Return of how many joints a file holds the positions: six, or more by their names.

    Raises InputError where they are more than an arm's.
    """
    found = [*_of_joints(arrays)]
    counts = {block.joints for block in found if block.kind == "q"}
    more = max(counts & {*MORE}, default=None)
    if more is None or OF_UR in counts:
        return OF_UR
    if more <= MOST_JOINTS:
        return more
    position = next(block for block in found if block.kind == "q" and block.joints == more)
    others = ", ".join(b.title for b in found if b.joints == more and b is not position)
    raise InputError(
        f"{path} holds {more} joints: {position.title} are positions"
        + (f", and beside them are {others}" if others else "")
        + f"; arms have up to {MOST_JOINTS}. Describe the arm by its URDF (`ur5 describe`), and "
        "write the entry by hand, without a gripper's joints (docs/robots.md)"
    )


def _of_joints(arrays: Mapping[str, np.ndarray]) -> Iterator[OfJoints]:
    """Yield arrays with a column for each joint, and single columns that are numbered."""
    wide = [name for name, values in arrays.items() if values.ndim == 2 and 1 not in values.shape]
    for name in wide:
        if kind := _kind(name):
            yield OfJoints(name, kind, min(arrays[name].shape))
    for stem, places in _by_stem(name for name in arrays if name not in wide).items():
        order = sorted(places)
        whole = order == list(range(order[0], order[0] + len(order))) and order[0] in (0, 1)
        if whole and (kind := _kind(stem)):
            yield OfJoints(f"{places[order[0]]} … {places[order[-1]]}", kind, len(order))


def _kind(name: str) -> str | None:
    """Return the kind of a quantity of joints by its name."""
    words = _words(_last(name))
    return None if words & TOOL else _meaning(words, MEANINGS)
