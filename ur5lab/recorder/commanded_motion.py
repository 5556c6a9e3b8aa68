"""A commanded motion, read from a file, and the reasons to refuse it."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from ur5lab.collisions import TABLE_NAME, collisions
from ur5lib.errors import InputError
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.sampling import interpolated

CHECKED_STEP = 0.02  # rad; between checked samples of a path
MIN_POINTS = 2
EXPECTED_LINES = "give six joint angles [rad], or a time [s] and six angles, in every line"
FULL_SPEED, FULL_ACCELERATION = 1.0, 2.0  # rad/s, rad/s²; of movej at speed factor 1
START_TOLERANCE = 0.01  # rad; within it, the arm is at the start
DEFAULT_POSITION_LIMIT = 4 * np.pi  # rad; limit of joints without a published one


@dataclass(frozen=True)
class CommandedMotion:
    """A motion of all joints: way-points, or a trajectory if it has times.

    q: (N, 6) [rad]; time: (N,) [s] of a trajectory, which the arm follows by servoj; None for
    way-points, to each of which it moves by movej and stops; speed: factor of the full speed or of
    the trajectory's speed, above 0 and at most 1.
    """

    q: Array
    time: Array | None
    speed: float

    def duration(self) -> float | None:
        """Return the duration of a trajectory [s], None for way-points."""
        return None if self.time is None else float(self.time[-1] - self.time[0]) / self.speed

    def fastest(self) -> Array:
        """Return the largest speeds of the joints (6,) [rad/s]."""
        if self.time is None:
            return np.full(6, FULL_SPEED * self.speed)
        steps = np.diff(self.q, axis=0) / np.diff(self.time)[:, None]
        return np.asarray(np.abs(steps).max(axis=0) * self.speed)

    def at_rate(self, rate: float) -> Array:
        """Return the angles (M, 6) [rad] of a trajectory at a rate [Hz], slowed by the factor
        `speed`.
        """
        assert self.time is not None
        elapsed = (self.time - self.time[0]) / self.speed
        at = np.arange(0, elapsed[-1], 1 / rate)
        return interpolated(at, elapsed, self.q)


def read_motion(path: Path, speed: float) -> CommandedMotion:
    """Return the motion in a CSV: lines of six angles [rad] are way-points, with a time [s] before
    them a trajectory.

    Raises InputError with file and line for anything else.
    """
    try:
        numbers = np.loadtxt(path, delimiter=",", ndmin=2)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}: {error}; {EXPECTED_LINES}") from error
    if numbers.shape[1] not in (6, 7) or not np.isfinite(numbers).all():
        raise InputError(f"{path} has {numbers.shape[1]} columns or empty cells; {EXPECTED_LINES}")
    q = numbers[:, -6:]
    if numbers.shape[1] == 6:
        return CommandedMotion(q, None, speed)
    if len(q) < MIN_POINTS or (np.diff(numbers[:, 0]) <= 0).any():
        raise InputError(f"{path}: the times of a trajectory must increase from line to line")
    return CommandedMotion(q, numbers[:, 0], speed)


def refusals(
    motion: CommandedMotion, robot: Robot, start: Array, table: float | None
) -> Iterator[str]:
    """Yield the reasons to refuse a motion, one sentence each; nothing if it may be executed.

    start: the arm's present posture (6,) [rad]; table: height of the table in the base frame [m],
    None if there is none.
    """
    path = dense_path(np.vstack([start, motion.q]))
    furthest, limits = np.abs(path).max(axis=0), position_limits(robot)
    for joint in np.flatnonzero(furthest > limits):
        yield (
            f"joint {joint + 1} turns to {furthest[joint]:.2f} rad, beyond its limit of "
            f"{limits[joint]:.2f}; change the path"
        )
    fastest, limits = motion.fastest(), np.array(robot.velocity_limits())
    for joint in np.flatnonzero(fastest > limits):
        yield (
            f"joint {joint + 1} turns at {fastest[joint]:.2f} rad/s, faster than its limit of "
            f"{limits[joint]:.2f}; lower --speed"
        )
    for sample, one, other in collisions(robot, path, table):
        where = ", ".join(f"{angle:.2f}" for angle in path[sample])
        hit = f"{one} hits the {other}" if other == TABLE_NAME else f"{one} hits {other}"
        yield f"{hit} at q = ({where}) rad; change the path, or `table_m` in the study"


def dense_path(q: Array) -> Array:
    """Return a path (M, 6) [rad] of straight lines between angles (N, 6) [rad], in small steps."""
    parts = [
        np.linspace(begin, end, 2 + int(np.abs(end - begin).max() / CHECKED_STEP))
        for begin, end in pairwise(q)
    ]
    return np.concatenate(parts)


def position_limits(robot: Robot) -> Array:
    """Return the largest angles of the joints (6,) [rad], to either side."""
    ends = [high for _, high in robot.position_limits()]
    return np.nan_to_num(ends, nan=DEFAULT_POSITION_LIMIT, posinf=DEFAULT_POSITION_LIMIT)
