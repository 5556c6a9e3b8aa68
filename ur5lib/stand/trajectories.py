"""Target trajectories: position, velocity and acceleration of the joints over time."""

from collections.abc import Iterator
from itertools import cycle, pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ur5lib.errors import InputError
from ur5lib.robots.description import Robot
from ur5lib.robots.urscript import parse, read_calls, six
from ur5lib.stand.plan import Fourier, Joints, Movej, Series, Standstill
from ur5lib.timeseries.arrays import Array, Six
from ur5lib.timeseries.profiles import duration, fourier_terms, rest_conditions, trapezoid

INITIAL_REST = 1.0  # s; every recording begins with this long a rest
MIN_COMMAND_TIME = 0.008  # s; a command lasts at least this long, even without motion


class Targets(NamedTuple):
    """Targets of the drives, each (N, n): q [rad], qd [rad/s], qdd [rad/s²]."""

    q: Array
    qd: Array
    qdd: Array


def plan_targets(plan: Movej | Fourier | Series | Standstill, robot: Robot, time: Array) -> Targets:
    """Return the targets of a trajectory at times (N,) [s].

    Raises InputError when it exceeds the joints' limits or its file of way-points is wrong.
    """
    match plan:
        case Standstill():
            still = np.zeros((len(time), len(plan.posture)))
            targets = Targets(still + plan.posture, still, still)
        case Movej():
            targets = _movej_targets(plan, time - INITIAL_REST)
        case Fourier():
            targets = _fourier_targets(plan, robot, time - INITIAL_REST)
        case Series():
            targets = _series_targets(
                plan.posture, plan.period_s, np.array(plan.coefficients), time - INITIAL_REST
            )
    _expect_within_limits(targets, robot)
    return targets


def read_way_points(path: str | Path) -> list[Six]:
    """Read way-points [rad] from a text file with one command `movej([six angles])` per line.

    This is the file format of the thesis (Section 4.4.1). Raises InputError for anything else.
    """
    lines = read_calls(Path(path), "way-points")
    points = [_way_point(line, f"{path}, line {k}") for k, line in lines]
    if len(points) < 2:
        raise InputError(f"{path}: found {len(points)} way-point(s); give at least two")
    return points


def _way_point(line: str, place: str) -> Six:
    try:
        command = parse(line)
        if command.name != "movej":
            raise ValueError
        a, b, c, d, e, f = six(*command.arguments(q=None)).tolist()
    except ValueError as error:
        raise InputError(
            f"{place}: {line!r} is not a way-point; write movej([six angles in radians])"
        ) from error
    return (a, b, c, d, e, f)


def _expect_within_limits(targets: Targets, robot: Robot) -> None:
    for joint, fastest in enumerate(robot.velocity_limits()):
        for values, (low, high), unit in (
            (targets.q, robot.motor(joint + 1).positions(), "rad"),
            (targets.qd, (-fastest, fastest), "rad/s"),
        ):
            least, most = float(values[:, joint].min()), float(values[:, joint].max())
            if not low <= least <= most <= high:  # also rejects NaN
                peak, limit = (least, low) if low - least > most - high else (most, high)
                raise InputError(
                    f"the trajectory takes joint {joint + 1} of {robot.name} to {peak:.3g} {unit}, "
                    f"beyond its limit of {limit:.3g}; choose a slower or smaller motion"
                )


# Way-points


def _movej_targets(plan: Movej, time: Array) -> Targets:
    listed = plan.way_points
    points = np.array(read_way_points(listed) if isinstance(listed, str) else listed)
    q, qd, qdd = np.zeros((3, len(time), points.shape[1]))
    q[:] = points[0]
    for start, origin, goal in _legs(plan, points, float(time[-1])):
        move = leg(time - start, origin, goal, plan.speed_rad_s, plan.acceleration_rad_s2)
        later = time >= start
        q[later] = move.q[later]
        qd += move.qd
        qdd += move.qdd
    return Targets(q, qd, qdd)


def leg(time: Array, origin: Array, goal: Array, speed: float, acceleration: float) -> Targets:
    """Return the targets of one movej between two different postures (n,) [rad].

    time: since its start (N,) [s]; speed [rad/s], acceleration [rad/s²]: of the joint with the
    longest way. All joints start and stop together.
    """
    way = goal - origin
    parts = trapezoid(time, way, speed, acceleration)
    place, qd, qdd = (np.outer(part, way) / np.abs(way).max() for part in parts)
    return Targets(origin + place, qd, qdd)


def _legs(plan: Movej, points: Array, end: float) -> Iterator[tuple[float, Array, Array]]:
    """Yield (start [s], origin (n,) [rad], goal (n,) [rad]) of each move that starts before `end`
    [s].
    """
    start = 0.0
    for origin, goal in pairwise(cycle(points)):
        if start >= end:
            return
        way = goal - origin
        if way.any():
            yield start, origin, goal
        moving = duration(way, plan.speed_rad_s, plan.acceleration_rad_s2)[2]
        start += max(moving + plan.pause_s, MIN_COMMAND_TIME)


# Fourier series


def _fourier_targets(plan: Fourier, robot: Robot, time: Array) -> Targets:
    """Return the targets of a random Fourier series that starts at rest, scaled joint by joint to
    the limits.
    """
    fine = np.linspace(0, plan.period_s, 2001)
    # drawn subject to q = posture, qd = qdd = 0 at the start
    start = rest_conditions(plan.period_s, plan.harmonics)
    drawn = np.random.default_rng(plan.draw).normal(size=(2 * plan.harmonics, len(plan.posture)))
    coefficients = drawn - np.linalg.pinv(start) @ (start @ drawn)
    terms = fourier_terms(plan.period_s, plan.harmonics, fine)[:3]
    parts = [term @ coefficients for term in terms]
    limits = [
        np.full(len(robot.joints), plan.amplitude_rad),
        plan.limit_share * np.array(robot.velocity_limits()),
        plan.limit_share * np.array(robot.acceleration_limits()),
    ]
    scales = [limit / np.abs(part).max(axis=0) for limit, part in zip(limits, parts, strict=True)]
    coefficients *= np.minimum.reduce(scales)
    return _series_targets(plan.posture, plan.period_s, coefficients, time)


def _series_targets(posture: Joints, period: float, coefficients: Array, time: Array) -> Targets:
    """Return the targets of a series about a posture (n,) [rad]; it rests before time zero."""
    terms = fourier_terms(period, len(coefficients) // 2, time.clip(min=0))[:3]
    q, qd, qdd = (term @ coefficients for term in terms)
    return Targets(q + posture, qd, qdd)
