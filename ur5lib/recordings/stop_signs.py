"""Stop signs: what in a recording contradicts the study so much that no forces may be stated."""

from collections.abc import Iterator
from itertools import islice

import pandas as pd

from ur5lib.recordings.arm_checks import (
    described,
    exchanged_joints,
    foreign_arm,
    foreign_torque,
    tool_off_flange,
)
from ur5lib.recordings.block_means import block_means
from ur5lib.recordings.checks import exchanged_channels, misread_velocities
from ur5lib.recordings.current_checks import (
    foreign_currents,
    is_driven,
    moving,
    strange_currents,
    undeclared_load,
)
from ur5lib.recordings.quality import Finding
from ur5lib.robots.description import Payload, Robot, robot_names
from ur5lib.tables import columns
from ur5lib.timeseries.segments import period

CHECKED = {"time", "segment", "interpolated"}.union(  # columns, as far as recorded
    *map(columns, ("actual_q", "actual_qd", "actual_current", "actual_TCP_pose")),
    *map(columns, ("target_q", "target_qd", "target_current", "target_moment")),
)
LED = 3  # joints that move at least where a hand leads an arm; a strong push turns one
FEWEST = 30  # blocks of a recording that can contradict an arm


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
    exchanged = [*exchanged_channels(robot)]
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
    if fitted or moves:  # a push against an arm at rest looks like gravity
        yield from exchanged_joints(means, loaded)
        if means.torque is None:
            others = (described(name).mounted(arm.gravity) for name in robot_names())
            yield from foreign_arm(means, loaded, [other.carrying(declared) for other in others])
    if moves >= (1 if driven else LED):
        yield from strange_currents(robot, means, loaded, step, driven)
    if fitted:  # elsewhere, the fit finds an undeclared load
        yield from undeclared_load(means, arm.carrying(configured), loaded)
