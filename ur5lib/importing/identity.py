"""The arm of a file and the order of its joints: as told, by names, by a pose, by gravity."""

import re
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ur5lib.importing.contents import Contents
from ur5lib.importing.motion import ImportedMotion
from ur5lib.recordings.block_means import BlockMeans
from ur5lib.recordings.readings import (
    CLEAR_LEAD,
    OR_FREE,
    Order,
    Reading,
    effort_per_torque,
    readings,
    usual_orders,
)
from ur5lib.recordings.rosbag import JOINT_NAMES
from ur5lib.recordings.stop_signs import described
from ur5lib.robots.description import Robot, robot_names
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array

MAX_DISTANCE = 0.004  # m; a calibrated arm misses its nominal kinematics by less
WORSE_POSE = 3.0  # times the distance of the best; readings farther away are excluded
POSTURES = 12  # postures that are compared
SURE_OF_NUMBERS = 3 * CLEAR_LEAD  # lead from which on numbers outdo the numbers of columns
UNNAMED = "unnamed joints"  # the finding for a bag whose messages do not name an arm's joints
UNDESCRIBED = "my_arm"  # in an entry for an arm that has no description yet
PARTS = ("shoulder pan", "shoulder lift", "elbow", "wrist 1", "wrist 2", "wrist 3")
MAKERS_TOLERANCE = 0.1  # share by which a joint's constant may differ from the maker's
MIN_GRAVITY_CHANGE = 1.0  # Nm, root mean square, of a joint that tells its constant


class Placed(NamedTuple):
    """A reading, and the root mean square distance [m] of its flange from the recorded pose."""

    arm: str
    order: Order
    miss: float


class Identity(NamedTuple):
    """A file's arm, None where it has no description, and the column of each of its joints."""

    arm: str
    robot: Robot | None
    order: Order


@dataclass(frozen=True)
class Case:
    """What identifies an arm: a file's motion, and means over blocks with all its efforts."""

    moving: ImportedMotion
    means: BlockMeans | None

    @property
    def file(self) -> Contents:
        """Return the file."""
        return self.moving.file


def identified(case: Case) -> Identity:
    """Return the arm and the column of each joint; what is not proven is assumed, or a question."""
    file = case.file
    names = [file.stated.robot] if file.stated.robot else arms_of(file)
    own = tuple(range(file.joints))
    if not names:
        file.evidence.check.append(
            f"robot {UNDESCRIBED}: no described arm has {file.joints} joints; describe yours, "
            "`ur5 describe arm.urdf`, and name it with --robot"
        )
        return Identity(UNDESCRIBED, None, own)
    every = [described(name) for name in arms_of(file)]
    placed = _by_pose(case, every, usual_orders(file.joints))
    likely = readings(case.means, every, usual_orders(file.joints), OR_FREE) if case.means else []
    order = _order(case, likely, placed, names)
    arm = _arm(case, [one for one in likely if one.order == order], placed, names)
    return Identity(arm, described(arm), order)


def arms_of(file: Contents) -> list[str]:
    """Return the described arms with as many joints as a file."""
    return [name for name in robot_names() if len(described(name).joints) == file.joints]


def fitting(
    q: Array, position: Array, arms: Sequence[Robot], orders: Sequence[Order]
) -> tuple[list[Placed], bool]:
    """Return the readings about as good as the best, and whether the pose is that of the flange.

    q: (N, n) [rad], columns as in the file; position: (N, 3) [m], in the base frame. Otherwise, the
    pose is that of a tool with a constant offset from the flange; none where that fits neither.
    """
    rows = np.unique(np.linspace(0, len(q) - 1, POSTURES).astype(int))
    for tool in (False, True):
        ranked = _misses(q[rows], position[rows], arms, orders, tool)
        if (best := ranked[0].miss) <= MAX_DISTANCE:
            return [each for each in ranked if each.miss <= WORSE_POSE * best + 1e-4], not tool
    return [], False


def _misses(
    q: Array, position: Array, arms: Sequence[Robot], orders: Sequence[Order], tool: bool
) -> list[Placed]:
    """Return the readings, the best first. tool: whether an offset from the flange is fitted."""
    poses = []
    for arm in arms:
        postures = q[:, np.array(orders)].swapaxes(0, 1)
        rotation, origin = link_frames(arm, postures.reshape(-1, q.shape[1]))
        away = position - origin[:, -1].reshape(*postures.shape[:2], 3)
        if tool:
            axes = rotation[:, -1].reshape(*postures.shape[:2], 3, 3)
            turned = np.einsum("knij,kni->knj", axes, away)
            away = turned - turned.mean(axis=1, keepdims=True)
        miss = np.sqrt((away**2).sum(axis=2).mean(axis=1))
        poses += [Placed(arm.name, order, float(m)) for order, m in zip(orders, miss, strict=True)]
    return sorted(poses, key=lambda pose: pose.miss)


def _by_pose(case: Case, arms: Sequence[Robot], orders: Sequence[Order]) -> list[Placed]:
    """Return the readings whose flange agrees with a recorded pose, none without a pose."""
    file, moving = case.file, case.moving
    pose = file.meant("actual_TCP_pose", moving.position.clock)
    if pose is None or pose.rows.shape[1] < 3:
        return []
    q, position = moving.in_si()["actual_q"], pose.rows[:, :3]
    whole = np.isfinite(q).all(axis=1) & np.isfinite(position).all(axis=1)
    if not whole.any() or np.ptp(q[whole], axis=0).max() < 0.05:
        return []
    good, bare = fitting(q[whole], position[whole], arms, orders)
    if not good:
        file.evidence.exclude(pose, "no pose of the flange, or of a tool on it, in m, base frame")
    elif len({reading.order for reading in good}) == 1:
        place = "the flange" if bare else "a tool fixed to the flange"
        file.evidence.proven.append(
            f"the joints' order, {in_words(good[0].order)}: it puts {place} of {good[0].arm} "
            f"within {1000 * good[0].miss:.1f} mm of {pose.title}"
        )
    return good


def _order(
    case: Case, likely: Sequence[Reading], placed: Sequence[Placed], names: Sequence[str]
) -> Order:
    """Return the columns of the joints: by names, which numbers may doubt; else by numbers."""
    own, posed = tuple(range(case.file.joints)), {one.order for one in placed}
    scores = {one.order: one.score for one in reversed(likely) if one.arm in names}
    best = max(scores, key=lambda order: scores[order], default=own)
    lead = scores[best] - scores[own] if scores else 0.0
    if names_order(case.moving):
        _doubt_names(case, best, lead, posed)
        return own
    if len(posed) == 1:
        return posed.pop()
    evidence, title = case.file.evidence, case.moving.position.title
    rest = [score for order, score in scores.items() if order != own]
    if lead > SURE_OF_NUMBERS:
        evidence.check.append(
            f"the joints' order, {in_words(best)}, in {title}: gravity explains the efforts so, "
            f"not from base to wrist (log-likelihood greater by {lead:.3g}), and no name tells it"
        )
        return best
    if scores and scores[own] - max(rest) > CLEAR_LEAD:
        evidence.proven.append(
            "the joints' order, base to wrist: gravity explains the efforts worse in those that "
            f"logs have besides (log-likelihood less by {scores[own] - max(rest):.3g})"
        )
    else:
        evidence.check.append(
            f"the joints' order, base to wrist, in {title}: what moves shows no other to be "
            "likelier, and no name tells it"
        )
    return own


def _doubt_names(case: Case, best: Order, lead: float, posed: Collection[Order]) -> None:
    """Note whether a pose or gravity contradicts the order that names tell."""
    evidence, named = case.file.evidence, f"by their names in {case.moving.position.title}"
    own = tuple(range(case.file.joints))
    if posed and own not in posed:
        evidence.check.append(f"the joints' order, {named}: the pose fits another")
    elif lead > SURE_OF_NUMBERS and not posed:
        evidence.check.append(
            f"the joints' order, {named}; gravity explains the efforts better with "
            f"{in_words(best)} (log-likelihood greater by {lead:.3g})"
        )
    else:
        evidence.proven.append(f"the joints' order, {named}")


def names_order(moving: ImportedMotion) -> bool:
    """Return whether names determine the joints' order: a driver's, RTDE's, or the user."""
    file, block = moving.file, moving.position
    if file.format == "rosbag":
        return not any(finding.finding == UNNAMED for finding in file.findings)
    first = block.names[0]
    if file.header.entry or (block.stated and len(block.names) > 1):
        return True
    rtde = re.search(r"(actual|act)_?q", first, re.IGNORECASE)
    return len(block.names) > 1 and bool(rtde or any(j.search(first) for j in JOINT_NAMES))


def _arm(
    case: Case, likely: Sequence[Reading], placed: Sequence[Placed], names: Sequence[str]
) -> str:
    """Return the arm: as told, by the name of file or folder, by the pose, or the likeliest."""
    file, evidence = case.file, case.file.evidence
    posed = [*dict.fromkeys(one.arm for one in placed)]
    told = file.stated.robot or _named(file, [*names])
    if told:
        how = "as given" if file.stated.robot else "by the name of file or folder"
        evidence.assumed.append(f"robot {told}, {how}")
        _doubt(case, told, likely, posed)
        return told
    if len(posed) == 1:
        evidence.proven.append(f"robot {posed[0]}: no other described arm fits the pose")
        return posed[0]
    left = [one for one in likely if not posed or one.arm in posed]
    if not left:
        evidence.check.append(
            f"robot {names[0]}: nothing in the file tells it; name it with --robot"
        )
        return (posed or [*names])[0]
    best, rival = left[0], left[1] if len(left) > 1 else None
    lead = best.score - rival.score if rival else np.inf
    constants = _constants(case, best)
    if lead >= CLEAR_LEAD and constants and all(constant.agrees for constant in constants):
        evidence.proven.append(
            f"robot {best.arm}: {' and '.join(one.text for one in constants)}; the next, "
            + (f"{rival.arm}, has a log-likelihood less by {lead:.3g}" if rival else "none")
        )
        return best.arm
    others = (
        f"; {rival.arm} is {'about as likely' if lead < CLEAR_LEAD else 'next'}" if rival else ""
    )
    needs = f" with {' and '.join(one.text for one in constants)}" if constants else ""
    evidence.check.append(
        f"robot {best.arm}: the likeliest of the described arms by the efforts{needs}{others}; "
        "name the right one, as with --robot ur5e, or describe it (`ur5 describe`)"
    )
    return best.arm


def _doubt(case: Case, told: str, likely: Sequence[Reading], posed: Sequence[str]) -> None:
    """Note where a pose or gravity contradicts the arm that is told."""
    if posed and told not in posed:
        case.file.evidence.check.append(
            f"robot {told}: the recorded pose is the flange of {posed[0]}, or a tool on it"
        )
    own = next((one.score for one in likely if one.arm == told), None)
    if own is not None and likely[0].score - own > CLEAR_LEAD:
        case.file.evidence.check.append(
            f"robot {told}: {likely[0].arm} explains the efforts far better (log-likelihood "
            f"greater by {likely[0].score - own:.3g}); check it, the tool and the mounting"
        )


class Constant(NamedTuple):
    """What a joint's efforts tell of its constant, beside the known one."""

    text: str
    agrees: bool


def _constants(case: Case, reading: Reading) -> list[Constant]:
    """Return the constants of the joints that bear most, of the first effort with a unit."""
    arm, means = described(reading.arm), case.means
    if means is None:
        return []
    known = [(n, u) for n, u in zip(means.currents, reading.units, strict=True) if u != "neither"]
    if not known:
        return []
    (effort, unit), *_ = known
    ordered = means.part(columns=reading.order)
    bears = np.std(ordered.gravity(arm), axis=0)
    expected = np.array(arm.maker_torque_constants()) if unit != "Nm" else np.ones(len(bears))
    found = []
    for joint in np.argsort(-bears)[:2].tolist():
        slope, error = effort_per_torque(ordered, effort, arm, joint)
        if bears[joint] < MIN_GRAVITY_CHANGE or not slope > 0:
            continue
        constant = (1e3 if unit == "mA" else 1.0) / slope
        spread = np.hypot(2 * constant * error / slope, 2 * MAKERS_TOLERANCE * expected[joint])
        name = "Nm per Nm" if unit == "Nm" else "Nm/A"
        text = f"joint {joint + 1} has {constant:.3g} {name} (known: {expected[joint]:.3g})"
        found.append(Constant(text, bool(abs(constant - expected[joint]) < spread)))
    return found


def _named(file: Contents, names: Sequence[str]) -> str | None:
    """Return the only arm in the name of the file, or of its folder, if any."""
    for name in (file.path.name, file.path.absolute().parent.name):
        parts = {*re.split(r"[^a-z0-9]+", name.lower())}
        named = [arm for arm in names if arm in parts]
        if len(named) == 1:
            return named[0]
    return None


def in_words(order: Order) -> str:
    """Return the joints in the order of the file's columns."""
    own = PARTS if len(order) == len(PARTS) else [f"joint {k + 1}" for k in range(len(order))]
    return ", ".join(own[order.index(column)] for column in range(len(order)))
