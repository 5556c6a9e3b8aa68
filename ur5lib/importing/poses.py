"""Poses: columns that the kinematics of an arm put at its flange, in whatever form they are."""

import re
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from ur5lib.checks.readings import Order
from ur5lib.checks.tool import on_flange
from ur5lib.importing.blocks import AXES, ColumnBlock
from ur5lib.importing.evidence import Row
from ur5lib.importing.spellings import ROTATION_NAMES, without_unit
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array

if TYPE_CHECKING:
    from scipy.spatial.transform import Rotation

MAX_DISTANCE = 0.004  # m; a calibrated arm misses its nominal kinematics by less
MAX_REACH = 20.0  # m
MIN_TRAVEL = 0.05  # m, of a flange that tells its arm
MAX_POSE_SHARE = 0.03  # of what positions travel, that an arm described roughly may miss
MAX_POSE_RATIO = 3.0  # times the distance of the best; readings farther away are excluded
COMPARED_POSTURES = 12  # postures that are compared
MAX_TURN = np.radians(2.0)  # by which the turns of a pose may differ from the flange's
MIN_TURN = np.radians(10.0)  # of the flange, that tells the form of its rotation
POSE = "actual_TCP_pose"
MEANINGS = (None, "", POSE, "position", "target_TCP_pose")  # by name, of what may be a pose
PLACES = {3: (0, 1, 2), 6: (0, 1, 2), 7: (0, 1, 2), 16: (12, 13, 14)}  # of x, y, z among columns
ROTATION_VECTOR = "a rotation vector"
QUATERNIONS = {"a quaternion x, y, z, w": (0, 1, 2, 3), "a quaternion w, x, y, z": (1, 2, 3, 0)}
ANGLES = {  # axes as scipy has them
    "angles about the fixed axes x, y, z (roll, pitch, yaw; W, P, R)": "xyz",
    "angles about the turning axes z, y, x (A, B, C)": "ZYX",
    "angles about the turning axes z, y, z": "ZYZ",
}


class PosedReading(NamedTuple):
    """An arm and an order of its joints, with the root mean square distance [m] of their flange
    from the recorded pose.
    """

    arm: str
    order: Order
    miss: float


class PosedReadings(NamedTuple):
    """The readings with a distance from the recorded pose like that of the best, the best first;
    empty if it is not the pose of a flange.

    bare: whether the pose is the flange's, else that of a tool with a constant offset from it;
    beaten: the best of the other readings, None without others; proof: sentence that proves the
    joints' order, "" without one; best: the nearest, if good or not, None without any.
    """

    good: list[PosedReading]
    bare: bool = True
    beaten: PosedReading | None = None
    proof: str = ""
    best: PosedReading | None = None

    def is_near(self, position: Array) -> bool:
        """Return whether the best is near for what positions (N, 3) [m] travel, as of an arm that
        is described roughly.
        """
        travel = np.linalg.norm(np.ptp(position[np.isfinite(position).all(axis=1)], axis=0))
        return self.best is not None and bool(self.best.miss < MAX_POSE_SHARE * travel)

    def orders(self) -> list[Order]:
        """Return the different orders of the joints, the best first."""
        return [*dict.fromkeys(reading.order for reading in self.good)]

    def arms(self) -> list[str]:
        """Return the names of the arms, the best first."""
        return [*dict.fromkeys(reading.arm for reading in self.good)]

    def within(self, title: str) -> str:
        """Return in words how near the best arm's flange, or a tool on it, is to the columns."""
        assert self.best is not None, "there are readings"
        whose, best = "the flange" if self.bare else "a tool", self.best
        return f"it puts {whose} of {best.arm} within {1000 * best.miss:.1f} mm of {title}"

    def next_best(self) -> str:
        """Return in words how far the next reading is, "" without one."""
        other = self.beaten
        return f", {other.arm} within {1000 * other.miss:.3g} mm" if other else ""

    def row(self, unit: str, turn: str) -> tuple[Row, dict[str, str]]:
        """Return the row of evidence, and the words of its candidates: arms, and none."""
        best, arms = self.good[0], {one.arm: one.miss for one in reversed(self.good)}
        arms |= {self.beaten.arm: self.beaten.miss} if self.beaten else {}
        odds = {arm: -0.5 * (miss / MAX_DISTANCE) ** 2 for arm, miss in arms.items()}
        numbers = {"unit": unit, "miss": 1000 * best.miss, "arm": best.arm, "turn": turn}
        words = {arm: f"the flange of {arm}" for arm in arms} | {"none": "no pose"}
        return Row("pose", odds | {"none": -np.inf}, "pose", numbers, exact=True), words


class Pose(NamedTuple):
    """Columns that may be a pose: position (N, 3) and rotation (N, k), k 3, 4, 9, or 0 without one,
    in the file's numbers; blocks: of which they are.
    """

    blocks: tuple[ColumnBlock, ...]
    position: Array
    rotation: Array

    @property
    def title(self) -> str:
        """Return the name of the block, or the first and the last of the columns' names."""
        names = [name for block in self.blocks for name in block.names]
        return names[0] if len(names) == 1 else f"{names[0]} … {names[-1]}"

    def in_metres(self) -> tuple[str, Array]:
        """Return the unit of the position, m or mm, by how far it reaches, and its rows (N, 3)
        [m].
        """
        in_mm = float(np.nanmax(np.abs(self.position), initial=0.0)) > MAX_REACH
        return ("mm", self.position / 1e3) if in_mm else ("m", self.position)

    def is_named(self) -> bool:
        """Return whether its columns are named as a pose."""
        return len(self.blocks) > 1 or self.blocks[0].meaning() == POSE or _is_bare(self.blocks[0])


def _is_bare(block: ColumnBlock) -> bool:
    return tuple(map(without_unit, block.names)) == AXES


def poses(blocks: Sequence[ColumnBlock], clock: str) -> list[Pose]:
    """Return what may be a pose among the blocks on a clock, those that are named so first."""
    own = [b for b in blocks if b.clock == clock and b.meaning() in MEANINGS]
    named = [pose for pose in _by_axes(own) if np.ptp(np.nan_to_num(pose.position), axis=0).any()]
    taken = {id(block) for pose in named for block in pose.blocks}
    whole = [_of_block(b) for b in own if id(b) not in taken and b.rows.shape[1] in PLACES]
    return sorted([*named, *whole], key=lambda pose: pose.blocks[0].meaning() != POSE)


def _of_block(block: ColumnBlock) -> Pose:
    rows, place = block.rows, PLACES[block.rows.shape[1]]
    turn = [0, 1, 2, 4, 5, 6, 8, 9, 10] if rows.shape[1] == 16 else range(3, rows.shape[1])
    return Pose((block,), rows[:, place], rows[:, [*turn]])


def _by_axes(blocks: Sequence[ColumnBlock]) -> Iterator[Pose]:
    """Yield poses of columns that are named by their axes, as X, Y, Z, W, P, R."""
    columns = {
        without_unit(name).lower(): (block, k)
        for block in blocks
        for k, name in enumerate(block.names if len(block.names) == block.rows.shape[1] else ())
    }
    for stem in [name[:-1] for name in columns if name.endswith("x")]:
        axes = [stem + axis for axis in AXES]
        if not {*axes} <= {*columns}:
            continue
        turned = stem.replace("position", "orientation").replace("translation", "rotation")
        turns = (
            [part + one for one in spelled]
            for part in dict.fromkeys((turned, stem, re.sub(r"[^._/]*$", "", stem)))
            for spelled in ROTATION_NAMES
        )
        others = {*columns} - {*axes}
        rotation = next((names for names in turns if others.issuperset(names)), [])
        parts = [columns[name] for name in [*axes, *rotation]]
        rows = np.stack([block.rows[:, k] for block, k in parts], axis=1)
        whole = {id(block): block for block, _ in parts}
        yield Pose(tuple(whole.values()), rows[:, :3], rows[:, 3:])


def fitting(
    q: Array, position: Array, arms: Sequence[Robot], orders: Sequence[Order]
) -> PosedReadings:
    """Return the readings that put the flange, or a tool on it, at the recorded positions.

    q: (N, n) [rad], columns as in the file; position: (N, 3) [m], in the base frame.
    """
    whole = np.flatnonzero(np.isfinite(q).all(axis=1) & np.isfinite(position).all(axis=1))
    if not len(whole):
        return PosedReadings([])
    rows = whole[np.unique(np.linspace(0, len(whole) - 1, COMPARED_POSTURES).astype(int))]
    at = position[rows]
    if not MIN_TRAVEL < np.linalg.norm(np.ptp(at, axis=0)) < MAX_REACH:
        return PosedReadings([])
    places = [
        (arm.name, order, on_flange(at, q[rows][:, order], arm)) for arm in arms for order in orders
    ]
    for tool in (False, True):
        placed = [PosedReading(arm, order, _size(own, tool)) for arm, order, own in places]
        placed.sort(key=lambda reading: reading.miss)
        most = MAX_POSE_RATIO * placed[0].miss + 1e-4
        good = [reading for reading in placed if reading.miss <= most]
        if placed[0].miss <= MAX_DISTANCE:
            beaten = next(iter(placed[len(good) :]), None)
            return PosedReadings(good, not tool, beaten, best=placed[0])
    return PosedReadings([], bare=False, best=placed[0])


def _size(offset: Array, tool: bool) -> float:
    """Return the root mean square [m] of places (N, 3) on the flange; tool: without a constant
    one.
    """
    own = offset - offset.mean(axis=0) if tool else offset
    return float(np.sqrt((own**2).sum(axis=1).mean()))


def form_of_rotation(pose: Pose, q: Array, arm: Robot) -> str:
    """Return in words the form in which a pose gives how the flange of an arm, or a tool on it,
    turns; "" where none fits, or it turns too little. q: (N, n) [rad], in the arm's order.
    """
    from scipy.spatial.transform import Rotation  # slow to import; few files need it

    whole = np.isfinite(q).all(axis=1) & np.isfinite(pose.rotation).all(axis=1)
    rows = np.flatnonzero(whole)
    rows = rows[np.unique(np.linspace(0, len(rows) - 1, 3 * COMPARED_POSTURES).astype(int))]
    flange = Rotation.from_matrix(link_frames(arm, q[rows])[0][:, -1])
    if (flange * flange[0].inv()).magnitude().max() < MIN_TURN:
        return ""
    off = {form: _off(flange, turn) for form, turn in _forms(pose.rotation[rows])}
    best = min(off, key=lambda form: off[form], default="")
    return best if best and off[best] < MAX_TURN else ""


def _forms(rotation: Array) -> Iterator[tuple[str, "Rotation"]]:
    """Yield the forms in which columns (N, k) may give a rotation, and what it is then."""
    from scipy.spatial.transform import Rotation

    if rotation.shape[1] == 9:
        columns = rotation.reshape(-1, 3, 3).transpose(0, 2, 1)
        yield "a homogeneous matrix, column by column", Rotation.from_matrix(columns)
    if rotation.shape[1] == 4:
        for form, order in QUATERNIONS.items():
            rows = rotation[:, order]
            if np.linalg.norm(rows, axis=1).min() > 0.5:
                yield form, Rotation.from_quat(rows)
    if rotation.shape[1] == 3:
        for unit, size in {"rad": 1.0, "deg": np.pi / 180}.items():
            yield f"{ROTATION_VECTOR} in {unit}", Rotation.from_rotvec(size * rotation)
            for form, axes in ANGLES.items():
                yield f"{form} in {unit}", Rotation.from_euler(axes, size * rotation)


def _off(flange: "Rotation", turn: "Rotation") -> float:
    """Return by how much [rad] a turn differs at most from that of the flange and a tool on it."""
    tool = flange.inv() * turn
    return float((tool * tool.mean().inv()).magnitude().max())
