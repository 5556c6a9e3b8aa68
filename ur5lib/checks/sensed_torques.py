"""Checks of measured torques: that they change, and are those of an arm's weight."""

from collections.abc import Iterator

import numpy as np

from ur5lib.channels import MEASURED_CURRENT
from ur5lib.checks.block_means import BlockMeans, size
from ur5lib.checks.currents import moving_joints
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import link_tail
from ur5lib.robots.statics import STANDARD_GRAVITY, gravity_regressor

# times the torque that holds equal links of the described weight, or part of it; of right
# recordings of six arms, 0.5 to 2.3
MAX_SIZE_RATIO = 10.0
# of what holds an arm stretched out; of less, friction may be many times as large
MIN_SHARE_BORNE = 0.25
SMALLEST_CHANGE = 1e-9  # Nm, of a torque that is logged


def foreign_size(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find torques that are no arm's of the described weight."""
    ratio = size_ratio(means, arm)
    if ratio is not None and not 1 / MAX_SIZE_RATIO < ratio < MAX_SIZE_RATIO:
        code = "foreign size of links" if arm.tells_gravity() else "foreign size"
        weight = sum(arm.masses) if arm.tells_gravity() else arm.weight
        yield contradiction(code, arm=arm.name, weight=weight, ratio=ratio)


def size_ratio(means: BlockMeans, arm: Robot) -> float | None:
    """Return the size of torques relative to what holds the arm: its links or, where nobody knows
    them, half of its weight in equal links with their centres midway; None where it bears little,
    or its weight is unknown.
    """
    tails = np.array([rotation.T @ far for rotation, far in map(link_tail, arm.link_poses())])
    if arm.tells_gravity():
        weight, held = sum(arm.masses), means.gravity(arm)
    elif arm.weight is not None:
        weight = arm.weight / 2
        link = weight / len(tails) * np.column_stack([np.ones(len(tails)), -tails / 2])
        held = np.einsum("mjkp,kp->mj", gravity_regressor(arm, means.q), link)
    else:
        return None
    stretched = weight * STANDARD_GRAVITY * np.linalg.norm(tails, axis=1).sum() / 2
    if np.sqrt((held**2).mean(axis=0)).max() < MIN_SHARE_BORNE * stretched:
        return None
    return float(np.linalg.norm(means.currents[MEASURED_CURRENT]) / size(held))


def constant_torques(means: BlockMeans) -> Iterator[Finding]:
    """Find torques that stay the same while their joints move."""
    changes = np.ptp(means.currents[MEASURED_CURRENT], axis=0) > SMALLEST_CHANGE
    if still := (1 + np.flatnonzero(moving_joints(means) & ~changes)).tolist():
        yield contradiction("constant torques", joints=still)
