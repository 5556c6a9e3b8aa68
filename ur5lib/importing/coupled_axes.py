"""Axes that a controller counts together, as J3 from the horizontal: by pose or by gravity."""

from collections.abc import Sequence

import numpy as np

from ur5lib.checks.checked import described
from ur5lib.checks.tool import on_flange
from ur5lib.importing.motion import ImportedMotion
from ur5lib.importing.poses import poses
from ur5lib.robots.description import Robot
from ur5lib.robots.drives import of_the_joints
from ur5lib.robots.newton_euler import torque_regressor
from ur5lib.robots.statics import gravity_torque
from ur5lib.timeseries.arrays import Array, Labels

UPPER, LOWER = 1, 2  # joints 2 and 3, from 0
SIGNS = {-1.0: "J3 + J2", 1.0: "J3 − J2"}  # of J2 in the joint's angle: what the column holds
MAX_MISS, MIN_RATIO = 0.01, 10.0  # m of a pose; times as far without the coupling
# Of the logarithm of the mean square that gravity and friction leave of the effort of joint 3, by
# the arm's links and by any: a wrong description explains the one, a push the other.
MIN_GAIN = 0.5
MIN_TRAVEL = 0.1  # rad of joint 2; a pushed arm at rest yields, and its efforts follow that
ROWS = 400
EFFORTS = ("effort", "actual_current", "actual_current_as_torque", "actual_torque")


def are_coupled(moving: ImportedMotion, name: str) -> bool:
    """Return whether the columns of joints 2 and 3 are coupled, by the pose or else by gravity; the
    account states how. name: of the arm.
    """
    arm, file, counts = described(name), moving.file, moving.in_si()["actual_q"]
    if counts.shape[1] != len(arm.joints) or moving.still or not arm.tells_gravity():
        return False
    q = of_the_joints("actual_q", counts, arm)
    rows = _some(q)
    if not np.nanmax(q[rows, UPPER]) - np.nanmin(q[rows, UPPER]) > MIN_TRAVEL:
        return False
    position = _position(moving)
    if position is not None:
        found = _by_pose(q[rows], position[rows], arm)
    else:
        efforts = [b.rows for b in moving.beside(EFFORTS) if not b.is_nameless()]
        found = _by_gravity(q, efforts, arm)
    if found is None:
        return False
    sign, reason = found
    ratio = f"{{motor: {LOWER + 1}, joint: {UPPER + 1}, ratio: {-sign:g}}}"
    drives = f"`drives: {{positions: coupled, coupling: [{ratio}]}}`"
    remedy = f"it is another arm, or describe this one with {drives}"
    column = f"{SIGNS[sign]} in the column of joint 3"
    file.account.tell("check", "coupled axes", column, "numbers", f"{reason}; {remedy}")
    return True


def _some(rows: Array | Labels) -> Labels:
    """Return the numbers of at most ROWS of the rows, evenly spaced."""
    chosen: Labels = np.unique(np.linspace(0, len(rows) - 1, ROWS).astype(int))
    return chosen


def _position(moving: ImportedMotion) -> Array | None:
    """Return a recorded position (N, 3) [m], None without one."""
    named = (pose for pose in poses(moving.file.blocks, moving.position.clock) if pose.is_named())
    pose = next(named, None)
    return None if pose is None else pose.in_metres()[1]


def _readings(q: Array) -> dict[float, Array]:
    """Return the joints' angles or rates (N, n) as read, 0, and by each coupling, by the sign of
    J2.
    """
    readings = dict[float, Array]()
    for sign in (0.0, *SIGNS):
        readings[sign] = q.copy()
        readings[sign][:, LOWER] += sign * q[:, UPPER]
    return readings


def _by_pose(q: Array, position: Array, arm: Robot) -> tuple[float, str] | None:
    """Return the coupling that puts the flange, or a tool, at positions (N, 3) [m], and why."""
    miss = {sign: _miss(on_flange(position, own, arm)) for sign, own in _readings(q).items()}
    best = min(miss, key=lambda sign: miss[sign])
    if not best or miss[best] > MAX_MISS or miss[0.0] < MIN_RATIO * miss[best]:
        return None
    told = f"so it puts the flange of {arm.name} within {1e3 * miss[best]:.1f} mm of the pose"
    return best, f"{told}, as read within {1e3 * miss[0.0]:.0f} mm"


def _miss(offset: Array) -> float:
    left = offset - offset.mean(axis=0)
    return float(np.sqrt((left**2).sum(axis=1).mean()))


def _by_gravity(q: Array, efforts: Sequence[Array], arm: Robot) -> tuple[float, str] | None:
    """Return the coupling by which gravity of the arm's links, and of any links, explains the
    effort of joint 3 far better, and why.
    """
    rate = np.gradient(q, axis=0)
    for effort in efforts:
        whole = np.flatnonzero(np.isfinite(np.hstack([rate, q, effort])).all(axis=1))
        if len(whole) < ROWS:
            continue
        rows = whole[_some(whole)]
        angles, rates, own = _readings(q[rows]), _readings(rate[rows]), effort[rows, LOWER]
        left = {sign: _left(angles[sign], rates[sign], own, arm) for sign in angles}
        best = min(left, key=lambda sign: left[sign].sum())
        if best and (np.log(left[0.0] / left[best]) > MIN_GAIN).all():
            sizes = np.sqrt([left[best][0], left[0.0][0]])
            told = "so gravity of {} leaves {:.2g} of the effort of joint 3 (unit of the file), "
            return best, (told + "as read {:.2g}").format(arm.name, *sizes)
    return None


def _left(q: Array, rate: Array, effort: Array, arm: Robot) -> Array:
    """Return the mean squares (2,) that gravity and friction leave of the effort (M,) of joint 3:
    of the arm's links, and of any.
    """
    rate, still = rate / (np.abs(rate).max() + 1e-12), np.zeros_like(q)
    friction = [np.tanh(50 * rate[:, LOWER]), *rate.T, np.ones(len(q))]
    known = gravity_torque(arm, arm.chosen_model, q)[:, LOWER]
    anything = torque_regressor(arm, q, still, still)[:, LOWER].T
    squares = []
    for gravity in ([known], anything):
        columns = np.column_stack([*gravity, *friction])
        solution = np.linalg.lstsq(columns, effort, rcond=None)[0]
        squares.append(float(((effort - columns @ solution) ** 2).mean()) + 1e-12)
    return np.array(squares)
