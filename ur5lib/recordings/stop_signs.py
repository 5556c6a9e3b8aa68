"""Stop signs: what in a recording contradicts the study so much that no forces may be stated."""

from collections.abc import Iterator
from itertools import islice

import numpy as np
import pandas as pd

from ur5lib.channels import MOST_JOINTS, columns
from ur5lib.recordings.arm_checks import (
    described,
    exchanged_joints,
    foreign_arm,
    foreign_torque,
    tool_off_flange,
)
from ur5lib.recordings.block_means import block_means
from ur5lib.recordings.checks import MOVES, misread_velocities, recorded
from ur5lib.recordings.current_checks import (
    foreign_currents,
    is_driven,
    moving,
    strange_currents,
    undeclared_load,
)
from ur5lib.recordings.quality import Finding, contradiction
from ur5lib.robots.description import Payload, Robot, robot_names
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import period

CHECKED = {"time", "segment", "interpolated"}.union(  # columns, as far as recorded
    columns("actual_TCP_pose"),
    *(columns(f"actual_{name}", MOST_JOINTS) for name in ("q", "qd", "current")),
    *(columns(f"target_{name}", MOST_JOINTS) for name in ("q", "qd", "current", "moment")),
)
LED = 3  # joints that move at least where a hand leads an arm; a strong push turns one
FEWEST = 30  # blocks of a recording that can contradict an arm
FRAMES = 20  # in which a joint moves, from which its channels are compared
CLOSER = 0.5  # a pair closer by this factor than the targets; in right recordings, none is by 0.95
SMOOTHER = 0.3  # actual_current is at least 15 times as rough as target_current in right recordings
EXCHANGED = {  # which quantities are exchanged, by the pair that fits like targets
    ("actual_q", "target_qd"): ("q",),
    ("target_q", "actual_qd"): ("qd",),
    ("actual_q", "actual_qd"): ("q", "qd"),
}


def stop_signs(
    robot: pd.DataFrame,
    arm: Robot,
    configured: Payload | None,
    declared: Payload | None,
    fitted: bool,
) -> list[Finding]:
    """Return the stop signs of a recording.

    robot: a repaired table, of which CHECKED is enough; arm: under the recording's gravity;
    configured: the payload that the controller was given; declared: the one that the study gives;
    fitted: whether the recording has the role `fit`.
    """
    channels = [*_motion(robot), *_current(robot)]
    exchanged = [contradiction("exchanged channels", name=name) for name in channels]
    contradictions = _contradictions(robot, arm, configured, declared, fitted)
    return [*exchanged, *islice(contradictions, 1)]  # others follow from the first


def _contradictions(
    robot: pd.DataFrame,
    arm: Robot,
    configured: Payload | None,
    declared: Payload | None,
    fitted: bool,
) -> Iterator[Finding]:
    """Yield what contradicts the arm and what it carries, the strongest evidence first."""
    step = period(robot["time"].to_numpy())
    yield from misread_velocities(robot, step)
    means = block_means(robot, step)
    if len(means.q) < FEWEST:
        return
    yield from foreign_torque(means, arm, [configured, declared])
    yield from tool_off_flange(robot, arm)
    loaded = arm.carrying(declared)
    yield from foreign_currents(means, loaded)
    moves, driven = int(moving(means).sum()), is_driven(robot)
    # a known torque has shown arm and joints; a push against an arm at rest looks like gravity
    if means.torque is None and (fitted or moves):
        yield from exchanged_joints(means, loaded)
        others = (described(name).mounted(arm.gravity) for name in robot_names())
        yield from foreign_arm(means, loaded, [other.carrying(declared) for other in others])
    # a torque sensor beyond the gear shows no friction, by which these know a current
    if moves >= (1 if driven else LED) and not arm.senses_torque():
        yield from strange_currents(robot, means, loaded, step, driven)
    if fitted:  # elsewhere, the fit finds an undeclared load
        yield from undeclared_load(means, arm.carrying(configured), loaded)


def _received(robot: pd.DataFrame, name: str) -> Array:
    """Return a channel of the frames that were received."""
    return channel(robot, name)[~robot["interpolated"].to_numpy()]


def _motion(robot: pd.DataFrame) -> tuple[str, ...]:
    """Return which of q and qd are exchanged: another pair is closer than that of the targets."""
    if not recorded(robot, "actual_q", "actual_qd", "target_q", "target_qd"):
        return ()
    measured, target = (np.abs(_received(robot, f"{kind}_qd")) for kind in ("actual", "target"))
    moves = (measured > MOVES) & (target > MOVES)
    moving = moves.sum(axis=0) >= FRAMES
    if not moving.any():
        return ()
    own = _apart(robot, moves, "target_q", "target_qd")[moving]
    others = {pair: _apart(robot, moves, *pair)[moving] for pair in EXCHANGED}
    best = min(others, key=lambda pair: float(np.median(others[pair])))
    return EXCHANGED[best] if np.mean(others[best] < CLOSER * own) > 0.5 else ()


def _apart(robot: pd.DataFrame, moves: Mask, position: str, velocity: str) -> Array:
    """Return the median difference (6,) [rad/s] between a position's slope and a velocity.

    moves: (N, 6), the frames that count; NaN for joints without any.
    """
    step = np.diff(robot["time"].to_numpy()[~robot["interpolated"].to_numpy()])[:, None]
    rate = _received(robot, velocity)
    slope = np.diff(_received(robot, position), axis=0) / step
    apart = np.where(moves[1:], np.abs(slope - (rate[1:] + rate[:-1]) / 2), np.nan)
    apart[:, ~moves[1:].any(axis=0)] = 0.0
    return np.asarray(np.nanmedian(apart, axis=0))


def _current(robot: pd.DataFrame) -> Iterator[str]:
    if recorded(robot, "actual_current", "target_current"):
        kinds = ("actual", "target")
        measured, target = (roughness(_received(robot, f"{kind}_current")) for kind in kinds)
        known = (measured > 0) | (target > 0)
        if known.any() and np.mean(measured[known] < SMOOTHER * target[known]) > 0.5:
            yield "current"


def roughness(values: Array) -> Array:
    """Return the median size (6,) of third differences of (N, 6): noise more than motion."""
    return np.asarray(np.nanmedian(np.abs(np.diff(values, 3, axis=0)), axis=0))
