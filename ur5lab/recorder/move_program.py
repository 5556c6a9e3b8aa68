"""A file of URScript's moves, as the thesis commands them, planned into one trajectory.

Section 4.4.1: `movej([...])` in joint space, `movel(p[...])` in task space, a waiting time between
the commands, and a start at the first way-point. Everything is planned before anything moves, so
that a whole file is checked like any other trajectory.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from ur5lab.inverse_kinematics import inverse_kinematics
from ur5lab.recorder.commanded_motion import MIN_POINTS, CommandedMotion, position_limits
from ur5lib.errors import InputError
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import (
    MIN_SINGULAR_VALUE,
    geometric_jacobian,
    link_frames,
)
from ur5lib.robots.urscript import (
    MOVE_ARGUMENTS,
    Command,
    ToolPose,
    parse,
    read_calls,
    six,
    speed_and_acceleration,
)
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.profiles import duration, trapezoid

SAMPLE_PERIOD = 0.008  # s; of a plan
NEGLIGIBLE_WAY = 1e-9  # rad, m; shorter moves take no time
GOAL_TOLERANCE = 1e-3  # rad; between the end of a straight line and its commanded angles
ACCEPTED_CALLS = (
    "write movej([six angles]), movej(p[pose]), movel(p[pose]), movel([six angles]) or sleep(t)"
)


@dataclass(frozen=True)
class Move:
    """One command of a program to move.

    place: file and line; goal: angles (6,) [rad], or the pose of frame 6; straight: whether frame 6
    moves along a straight line (movel); acceleration, speed: of the joint with the longest way
    [rad/s², rad/s], or of frame 6 [m/s², m/s]; seconds: duration that replaces both, 0 for none;
    blend: radius [m] about the goal in which the next move begins; rest: pause after it [s].
    """

    place: str
    goal: Array | ToolPose
    straight: bool
    acceleration: float
    speed: float
    seconds: float
    blend: float
    rest: float = 0.0


def is_program(path: Path) -> bool:
    """Return whether a file contains calls, as of movej, instead of numbers. Raises InputError if
    it is no text.
    """
    return any("(" in line for _, line in read_calls(path, "moves"))


def read_program(path: Path) -> list[Move]:
    """Return the moves in a file. Raises InputError with file and line for anything else."""
    moves: list[Move] = []
    for number, line in read_calls(path, "moves"):
        place = f"{path}, line {number}"
        try:
            command = parse(line)
            if command.name == "sleep" and moves:
                rest = moves[-1].rest + _not_negative(*command.arguments(t=0.01))
                moves[-1] = replace(moves[-1], rest=rest)
            else:
                moves.append(_move(command, place))
        except (KeyError, TypeError, ValueError) as error:
            raise InputError(f"{place}: {line[:60]!r} is no move; {ACCEPTED_CALLS}") from error
    if len(moves) < MIN_POINTS:
        raise InputError(f"{path}: found {len(moves)} move(s); give at least two")
    return moves


def planned_motion(
    moves: Sequence[Move], robot: Robot, present: Array, speed: float, wait: float
) -> CommandedMotion:
    """Return the trajectory of a file's moves, beginning at the goal of the first one.

    present: posture (6,) [rad], which selects the solution nearest to it if the first goal is a
    pose; speed: factor of the commanded speeds, not of pauses; wait: least time [s] between the
    beginnings of two moves, the thesis's waiting time. Raises InputError where a pose is out of
    reach or a straight line passes a singularity.
    """
    corners = [_goal_angles(moves[0], robot, present)]
    legs = [corners[0][None]]
    for move in moves[1:]:
        legs.append(_leg(move, robot, corners[-1]))
        corners.append(legs[-1][-1])
    starts = [0]
    for move, leg, following in zip(moves, legs, legs[1:], strict=False):
        rest, waited = (round(seconds * speed / SAMPLE_PERIOD) for seconds in (move.rest, wait))
        early = 0 if rest else _overlap(robot, leg, following, move.blend)
        starts.append(starts[-1] + max(len(leg) - 1 + rest - early, waited))
    q = np.tile(corners[0], (starts[-1] + len(legs[-1]), 1))
    for start, leg in zip(starts, legs, strict=True):
        # Each move adds its displacement; where two overlap, they round the corner.
        q[start : start + len(leg)] += leg - leg[0]
        q[start + len(leg) :] += leg[-1] - leg[0]
    time: Array = SAMPLE_PERIOD * np.arange(len(q), dtype=np.float64)
    return CommandedMotion(q, time, speed)


def _move(command: Command, place: str) -> Move:
    goal, a, v, t, r = command.arguments(**MOVE_ARGUMENTS[command.name])
    if not 0 < min(a, v) <= max(a, v) < np.inf:
        raise ValueError
    goal = goal if isinstance(goal, ToolPose) else six(goal)
    return Move(place, goal, command.name == "movel", a, v, _not_negative(t), _not_negative(r))


def _not_negative(value: float) -> float:
    if not 0 <= value < np.inf:
        raise ValueError
    return value


def _goal_angles(move: Move, robot: Robot, near: Array) -> Array:
    """Return the angles (6,) [rad] of a goal; for a pose, the solution nearest to `near` (6,)."""
    if not isinstance(move.goal, ToolPose):
        return move.goal
    rotation, position = _pose(move.goal)
    candidates = inverse_kinematics(robot, rotation[None], position[None])[0]
    candidates = candidates[np.isfinite(candidates).all(axis=1)]
    # whole turns bring each joint close to `near`, within its limits
    candidates = near + (candidates - near + np.pi) % (2 * np.pi) - np.pi
    beyond = np.abs(candidates) > position_limits(robot)
    candidates -= 2 * np.pi * np.sign(candidates) * beyond
    if not len(candidates):
        raise InputError(f"{move.place}: the pose is out of the reach of {robot.name}; change it")
    return np.asarray(candidates[np.abs(candidates - near).max(axis=1).argmin()])


def _pose(goal: ToolPose) -> tuple[Array, Array]:
    position, turn = np.split(np.array(goal.values), 2)
    return Rotation.from_rotvec(turn).as_matrix(), position


def _leg(move: Move, robot: Robot, origin: Array) -> Array:
    """Return a move's angles (M, 6) at each SAMPLE_PERIOD, from `origin` to its goal."""
    if not move.straight:
        way = _goal_angles(move, robot, origin) - origin
        return origin + np.outer(_progress(move, np.abs(way).max()), way)
    begin, start = (frames[0, 6] for frames in link_frames(robot, origin[None]))
    if isinstance(move.goal, ToolPose):
        end, goal = _pose(move.goal)
    else:
        end, goal = (frames[0, 6] for frames in link_frames(robot, move.goal[None]))
    turn = Rotation.from_matrix(end @ begin.T).as_rotvec()
    longest = max(np.linalg.norm(goal - start), np.linalg.norm(turn))
    progress = _progress(move, float(longest))
    rotations = Rotation.from_rotvec(np.outer(progress, turn)).as_matrix() @ begin
    q = _along(move, robot, origin, rotations, start + np.outer(progress, goal - start))
    if not isinstance(move.goal, ToolPose) and np.abs(q[-1] - move.goal).max() > GOAL_TOLERANCE:
        where = ", ".join(f"{angle:.2f}" for angle in q[-1])
        raise InputError(
            f"{move.place}: the straight line ends at ({where}) rad, another posture of the same "
            "pose; give the pose, or use movej"
        )
    return q


def _progress(move: Move, longest: float) -> Array:
    """Return the share of a move that is done (M,), 0 to 1, each SAMPLE_PERIOD; longest: its way
    [rad] or [m].
    """
    if longest < NEGLIGIBLE_WAY:
        return np.zeros(1)
    speed, acceleration = move.speed, move.acceleration
    if move.seconds:
        speed, acceleration = speed_and_acceleration(longest, move.seconds)
    way = np.array([longest])
    end = duration(way, speed, acceleration)[2]
    time: Array = SAMPLE_PERIOD * np.arange(int(np.ceil(end / SAMPLE_PERIOD)) + 1, dtype=np.float64)
    return trapezoid(time, way, speed, acceleration)[0] / longest


def _along(move: Move, robot: Robot, origin: Array, rotations: Array, positions: Array) -> Array:
    """Return the angles (M, 6) that put frame 6 at the poses, in the configuration of `origin`
    (6,).

    Raises InputError where the arm cannot follow.
    """
    candidates = inverse_kinematics(robot, rotations, positions)
    _expect_regular(move, robot, origin[None])
    distance = np.abs(np.exp(1j * candidates[0]) - np.exp(1j * origin)).max(axis=1)
    q = np.unwrap(candidates[:, np.nanargmin(distance)], axis=0)
    if not np.isfinite(q).all():
        raise InputError(
            f"{move.place}: the straight line leaves the reach of {robot.name}; change it, or use "
            "movej"
        )
    _expect_regular(move, robot, q)
    return q + 2 * np.pi * np.round((origin - q[0]) / (2 * np.pi))


def _expect_regular(move: Move, robot: Robot, q: Array) -> None:
    """Raise InputError where angles (M, 6) [rad] are near a singularity."""
    least = np.linalg.svd(geometric_jacobian(robot, q), compute_uv=False)[:, -1]
    worst = least.argmin()
    if least[worst] < MIN_SINGULAR_VALUE:
        where = ", ".join(f"{angle:.2f}" for angle in q[worst])
        raise InputError(
            f"{move.place}: the straight line passes a singularity at q = ({where}) rad (smallest "
            f"singular value {least[worst]:.3f}, below {MIN_SINGULAR_VALUE}); "
            "change it, or use movej"
        )


def _overlap(robot: Robot, leg: Array, following: Array, blend: float) -> int:
    """Return the number of samples by which two moves overlap: while frame 6 is within the blend
    radius [m] on both, and at most half of either move.
    """
    ahead, behind = (link_frames(robot, part)[1][:, 6] for part in (leg[::-1], following))
    outside = [
        np.flatnonzero(np.linalg.norm(part - part[0], axis=1) > blend) for part in (ahead, behind)
    ]
    inside = [far[0] - 1 if len(far) else len(leg) for far in outside]
    return int(min(*inside, len(leg) // 2, len(following) // 2))
