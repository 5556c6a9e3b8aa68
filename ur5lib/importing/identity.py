"""The arm of a file and the order of its joints: by names, a pose, or gravity."""

import re
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ur5lib.errors import InputError
from ur5lib.importing.contents import Contents, Evidence
from ur5lib.importing.motion import ImportedMotion
from ur5lib.importing.serial import arms_of
from ur5lib.recordings import readings
from ur5lib.recordings.block_means import BlockMeans
from ur5lib.recordings.readings import IN_ORDER, OR_FREE, SURE, Order, Reading, exchanged
from ur5lib.recordings.rosbag import JOINT_NAMES
from ur5lib.recordings.stop_signs import described
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array

FITS = 0.004  # m; a calibrated arm misses its nominal kinematics by less
WORSE = 3.0  # times the distance of the best; readings farther away are excluded
POSTURES = 12  # postures that are compared
UNNAMED = "unnamed joints"  # the finding for a bag whose messages do not name an arm's joints
PARTS = ("shoulder pan", "shoulder lift", "elbow", "wrist 1", "wrist 2", "wrist 3")


class Placed(NamedTuple):
    """A reading, and the root mean square distance [m] of its flange from the recorded pose."""

    arm: str
    order: Order
    miss: float


def fitting(
    q: Array, position: Array, arms: Sequence[Robot], orders: Sequence[Order]
) -> tuple[list[Placed], bool]:
    """Return the readings about as good as the best, and whether the pose is that of the flange.

    q: (N, 6) [rad], columns as in the file; position: (N, 3) [m], in the base frame. Otherwise, the
    pose is that of a tool with a constant offset from the flange; none where that fits neither.
    """
    rows = np.unique(np.linspace(0, len(q) - 1, POSTURES).astype(int))
    for tool in (False, True):
        ranked = _misses(q[rows], position[rows], arms, orders, tool)
        best = ranked[0].miss
        if best <= FITS:
            return [each for each in ranked if each.miss <= WORSE * best + 1e-4], not tool
    return [], False


def _misses(
    q: Array, position: Array, arms: Sequence[Robot], orders: Sequence[Order], tool: bool
) -> list[Placed]:
    """Return the readings, the best first. tool: whether an offset from the flange is fitted."""
    poses = []
    for arm in arms:
        postures = q[:, np.array(orders)].swapaxes(0, 1)
        rotation, origin = link_frames(arm, postures.reshape(-1, 6))
        away = position - origin[:, 6].reshape(*postures.shape[:2], 3)
        if tool:
            axes = rotation[:, 6].reshape(*postures.shape[:2], 3, 3)
            turned = np.einsum("knij,kni->knj", axes, away)
            away = turned - turned.mean(axis=1, keepdims=True)
        miss = np.sqrt((away**2).sum(axis=2).mean(axis=1))
        poses += [Placed(arm.name, order, float(m)) for order, m in zip(orders, miss, strict=True)]
    return sorted(poses, key=lambda pose: pose.miss)


@dataclass(frozen=True)
class Case:
    """What identifies an arm: a file's motion, and means over blocks with all its efforts."""

    moving: ImportedMotion
    means: BlockMeans

    @property
    def file(self) -> Contents:
        """Return the file."""
        return self.moving.file

    @property
    def evidence(self) -> Evidence:
        """Return the evidence, to which is added."""
        return self.moving.file.evidence


def identified(case: Case, names: Sequence[str], trusted: bool = False) -> Reading:
    """Return the arm and the column of each joint.

    names: possible arms, empty for all described ones; trusted: whether the joints' names are right
    even where gravity contradicts them. Raises InputError with the alternatives and a remedy where
    they are ambiguous.
    """
    arms = _possible(case.file, names)
    by_name = names_order(case.moving)
    orders = [IN_ORDER] if by_name else readings.ALL_ORDERS
    by_pose = _by_pose(case, arms, orders)
    weighed = case.means.currents and (by_name or not by_pose)
    likely = readings.likeliest(case.means, arms, OR_FREE) if weighed else []
    if by_name:
        _expect_agreement(likely, case, arms, trusted)
    if by_pose:
        return _of_pose(case, by_pose)
    if by_name:
        order = IN_ORDER
    elif likely:
        order = _by_gravity(case, likely)
    else:
        raise InputError(
            f"{case.file.path}: the joints' order is unknown: the file has neither efforts or "
            "currents nor a TCP pose under a known name, nor names of joints; name its columns "
            "(`actual_current_0`, `shoulder_pan_position`)"
        )
    likely = readings.readings(case.means, arms, [order], OR_FREE)
    return _sure_arm(case, likely, bool(names))


def ambiguous(file: Contents, what: str, best: str, rival: str, remedy: str) -> InputError:
    """Return the error for a property of a file that two readings explain equally well."""
    return InputError(
        f"{file.path}: {what} is ambiguous: {best} and {rival} explain it as well; {remedy}"
    )


def names_order(moving: ImportedMotion) -> bool:
    """Return whether names determine the joints' order: a driver's, or RTDE's."""
    if moving.file.format == "rosbag":
        return not any(finding.finding == UNNAMED for finding in moving.file.findings)
    first, *others = moving.position.names
    named = first == "actual_q_0" or any(joint.search(first) for joint in JOINT_NAMES)
    return named and len(others) == 5


def _expect_agreement(
    likely: Sequence[Reading], case: Case, arms: Sequence[Robot], trusted: bool
) -> None:
    """Raise InputError where gravity contradicts the names, unless these are trusted."""
    gap = 0.0
    if likely:
        units = {unit: OR_FREE[unit] for unit in likely[0].units}
        named = readings.readings(case.means, arms, [IN_ORDER], units)[0]
        gap = likely[0].score - named.score
    title = case.moving.position.title
    if gap < SURE:
        case.evidence.proven.append(f"the joints' order, by their names in {title}")
        return
    other = f"{in_words(likely[0].order)} (far better by gravity)"
    if not trusted and gap > 3 * SURE:
        remedy = "check the names and the units against the recorder; --trust-names insists on them"
        raise ambiguous(case.file, "the joints' order", "that of the names", other, remedy)
    case.evidence.assumed.append(f"the joints' order, by their names in {title}, not {other}")


def _by_pose(case: Case, arms: Sequence[Robot], orders: Sequence[Order]) -> list[Placed]:
    """Return the readings whose flange agrees with a recorded pose, none without a pose."""
    file, moving, evidence = case.file, case.moving, case.evidence
    pose = next((block for block in file.blocks if block.meaning() == "actual_TCP_pose"), None)
    if pose is None or len(pose.rows) != len(moving.position.rows):
        return []
    if not np.allclose(file.clocks[pose.clock], moving.time, atol=1e-3):
        return []
    q, position = moving.in_si()["actual_q"], pose.rows[:, :3]
    good, bare = fitting(q, position, arms, orders)
    if not good:
        if others := fitting(q, position, _possible(file), orders)[0]:
            raise InputError(
                f"{file.path}: the arm is not {' or '.join(arm.name for arm in arms)}: "
                f"{pose.title} is the flange of `robot: {others[0].arm}`, or a tool on it, within "
                f"{1000 * others[0].miss:.1f} mm; name that arm"
            )
        evidence.left_out.append(pose.names)
        evidence.assumed.append(
            f"{pose.title} is no pose of the flange, or of a tool on it, in m and the base frame; "
            "left out"
        )
    elif len({reading.order for reading in good}) == 1:
        best = good[0]
        place = "the flange" if bare else "a tool fixed to the flange"
        evidence.proven.append(
            f"the joints' order, {in_words(best.order)}: it puts {place} of {best.arm} within "
            f"{1000 * best.miss:.1f} mm of {pose.title}"
        )
    return good


def _possible(file: Contents, names: Sequence[str] = ()) -> list[Robot]:
    """Return the arms with as many joints as a file; names: as of `arms_of`."""
    return [described(name) for name in arms_of(file, names)]


def _of_pose(case: Case, good: Sequence[Placed]) -> Reading:
    """Return the reading that fits a pose; among several, the one that gravity prefers."""
    arms, orders = ({getattr(reading, key) for reading in good} for key in ("arm", "order"))
    robots = [described(arm) for arm in sorted(arms)]
    likely = readings.readings(case.means, robots, [*orders], OR_FREE)
    allowed = {(reading.arm, reading.order) for reading in good}
    likely = [reading for reading in likely if (reading.arm, reading.order) in allowed]
    if rival := _rival(likely):
        order = _base_to_wrist(case, likely, rival.order)
        likely = [reading for reading in likely if reading.order == order]
    if len(arms) == 1:
        case.evidence.proven.append(f"robot {likely[0].arm}: no other described arm fits the pose")
        return likely[0]
    return _sure_arm(case, likely, False)


def _by_gravity(case: Case, likely: Sequence[Reading]) -> Order:
    """Return the order that explains the efforts; base to wrist where they do not decide."""
    order = likely[0].order
    base = readings.base_first(case.means, order)
    if base is False:
        order = exchanged(order, 0, 5)
    rival = _rival(likely)
    if rival is None and base is not None:
        case.evidence.proven.append(
            f"the joints' order, {in_words(order)}: in no other does gravity explain the efforts "
            "as well; joint 1 bears the larger rotor"
        )
        return order
    return _base_to_wrist(case, likely, rival.order if rival else exchanged(order, 0, 5))


def _base_to_wrist(case: Case, likely: Sequence[Reading], rival: Order) -> Order:
    """Return the order from base to wrist, assumed. Raises InputError where others are likelier."""
    reversed_ends = readings.base_first(case.means, IN_ORDER) is False
    in_order = max((one.score for one in likely if one.order == IN_ORDER), default=-np.inf)
    if likely[0].score - in_order < SURE and not reversed_ends:
        case.evidence.assumed.append(
            "the joints' order, base to wrist: what moves shows no other to be likelier"
        )
        return IN_ORDER
    raise ambiguous(
        case.file,
        "the joints' order",
        in_words(likely[0].order),
        in_words(rival),
        "record a motion that turns all joints, or a TCP pose, or name the joints",
    )


def _rival(likely: Sequence[Reading]) -> Reading | None:
    """Return the likeliest reading with another order than the best, if it is about as likely."""
    rival = next((one for one in likely if one.order != likely[0].order), None)
    return rival if rival and likely[0].score - rival.score < SURE else None


def _sure_arm(case: Case, likely: Sequence[Reading], named_by_user: bool) -> Reading:
    """Return the likeliest reading. Raises InputError where another arm is about as likely."""
    file, evidence, best = case.file, case.evidence, likely[0]
    rival = next((reading for reading in likely if reading.arm != best.arm), None)
    if rival is None and named_by_user:
        evidence.assumed.append(f"robot {best.arm}, as given{_likelier(case, best)}")
    elif named := _named(file, likely):
        evidence.assumed.append(
            f"robot {named.arm}, by name of file or folder: the efforts fit others about as well"
        )
        return named
    elif rival and best.score - rival.score < SURE:
        raise ambiguous(
            file,
            "the arm",
            f"`robot: {best.arm}`",
            f"`robot: {rival.arm}`",
            f"name it, as with --robot {best.arm}",
        )
    else:
        evidence.proven.append(f"robot {best.arm}: no other described arm fits the efforts as well")
    return best


def _likelier(case: Case, given: Reading) -> str:
    """Return that another described arm explains the efforts far better than a given one, if so."""
    arms = _possible(case.file)
    best = readings.readings(case.means, arms, [given.order], OR_FREE)[0]
    if best.score - given.score < SURE:
        return ""
    return f", although `robot: {best.arm}` explains the efforts far better: check it, and the tool"


def _named(file: Contents, likely: Sequence[Reading]) -> Reading | None:
    """Return the only likely arm's reading in the name of the file, or of its folder, if any."""
    near = [reading for reading in likely if likely[0].score - reading.score < SURE]
    for name in (file.path.name, file.path.absolute().parent.name):
        words = {*re.split(r"[^a-z0-9]+", name.lower())}
        named = [reading for reading in near if reading.arm in words]
        if len(named) == 1 and len(near) > 1:
            return named[0]
    return None


def in_words(order: Order) -> str:
    """Return the names of the joints in the order of the file's columns."""
    return ", ".join(PARTS[order.index(column)] for column in range(6))
