"""Blocks: columns of a file that belong together, and their meaning by name."""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from ur5lib.channels import SUFFIXES
from ur5lib.recordings.entries import OPPOSITE
from ur5lib.recordings.rosbag import JOINTS
from ur5lib.timeseries.arrays import Array

TARGET = {"target", "desired", "des", "ref", "reference", "cmd", "command", "commanded", "setpoint"}
TOOL = {"tcp", "tool", "cartesian", "transform", "tf", "eef"}
OF_IMU = {"imu", "mag", "magnetometer"}  # mx is a magnetic field there
NAMELESS = "column "  # and its number: a column of a table without a header
MEANINGS = {  # of a block with a column for each joint, by a word of its name
    "q": {"q", "position", "positions", "pos", "angle", "angles"},
    "qd": {"qd", "dq", "qdot", "velocity", "velocities", "vel", "speed", "speeds"},
    "qdd": {"qdd", "ddq", "acceleration", "accelerations", "acc"},
    "current": {"i", "current", "currents"},
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

    def is_target(self) -> bool:
        """Return whether it was commanded, not measured, by its name."""
        return (self.meaning() or "").startswith("target")

    def meaning(self) -> str | None:
        """Return the meaning of the name: RTDE channel, kind of joint or spatial quantity."""
        stem = place_of(self.names[0])[0] if len(self.names) > 1 else self.names[0]
        last = stem.rstrip("/").rsplit("/", 1)[-1]
        width = self.rows.shape[1]
        if last in SUFFIXES and len(SUFFIXES[last]) == width:
            return last
        words = {*re.findall(r"[a-z]+", re.sub(r"(?<=[a-z])(?=[A-Z])", "_", last).lower())}
        if width == 6 and words & {"wrench", "ft"} and not words & TOOL:
            return "wrench"
        if width == self.joints and not words & TOOL:
            return _of_joints(words)
        spatial = _meaning(words, IN_SPACE) if width == 3 and not words & OF_IMU else None
        if spatial in ("force", "torque"):
            return spatial
        if words & TOOL or width == 7:
            return _meaning(words, OF_TOOL)
        return spatial


def _meaning(words: set[str], meanings: Mapping[str, set[str]]) -> str | None:
    """Return the first meaning that has one of the words."""
    return next((meaning for meaning, known in meanings.items() if words & known), None)


def _of_joints(words: set[str]) -> str | None:
    kind = _meaning(words, MEANINGS)
    if kind is None or kind == "effort":
        return kind
    if words & TARGET:
        return "target_moment" if kind == "torque" else f"target_{kind}"
    return {"qdd": None, "torque": "actual_current_as_torque"}.get(kind, f"actual_{kind}")


def grouped(names: Sequence[str], joints: int = 6) -> Iterator[tuple[str, ...]]:
    """Yield the names of single columns that belong together (joints; pose; x, y, z), others alone.

    In the order of the joints' names, or else of their numbers.
    """
    stems: dict[str, dict[int, str]] = {}
    for name in names:
        stem, place = place_of(name)
        stems.setdefault(stem, {})[place] = name
    for places in stems.values():
        ordered = tuple(places[place] for place in sorted(places))
        yield from [ordered] if len(ordered) in (3, 6, joints) else ((name,) for name in ordered)


def names_joints(name: str) -> bool:
    """Return whether a column's name contains the name of a joint, not only a number."""
    return any(joint in name for joint in JOINTS)


def place_of(name: str) -> tuple[str, int]:
    """Return a column's name without unit, joint, number or axis, and its place; -1 for none."""
    name = re.sub(r" *[\[(][^\])]*[A-Za-z]{1,2}[\])]$", "", name)
    for place, joint in enumerate(JOINTS):
        if joint in name:
            return name.replace(joint, ""), place
    if numbered := re.fullmatch(r"(.*?)[ _.]*[(\[]?[jJ]?(\d)[)\]]?", name):
        return numbered[1], int(numbered[2])
    if numbered := re.fullmatch(r"(.*?)[jJ]oint[ _.]?(\d)[ _.](.{2,})", name):  # Joint1_Pos
        return numbered[1] + numbered[3], int(numbered[2])
    if part := re.fullmatch(r"(?:(.*)[ _./])?([ftmnFTM])([xyz])", name):  # Fx, wrench_tz
        return f"{part[1] or ''}_{part[2]}", "xyz".index(part[3])
    if axis := re.fullmatch(r"(.*?)_?([xyz])", name):
        return axis[1], "xyz".index(axis[2])
    return name, -1
