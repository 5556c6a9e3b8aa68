"""Checks of measured torques: that they are those of their joints, and of an arm's weight."""

from collections.abc import Iterator
from itertools import combinations

import numpy as np

from ur5lib.channels import MEASURED_CURRENT
from ur5lib.checks.arm import Pair
from ur5lib.checks.block_means import BlockMeans, size
from ur5lib.checks.currents import MIN_LEAD_OF_EXCHANGE, moving_joints
from ur5lib.checks.delays import CURRENT_NOISE
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import link_tail
from ur5lib.robots.statics import STANDARD_GRAVITY, gravity_columns, gravity_regressor

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
        yield contradiction("foreign size", arm=arm.name, weight=arm.weight, ratio=ratio)


def size_ratio(means: BlockMeans, arm: Robot) -> float | None:
    """Return the size of torques relative to what holds half of an arm's weight in equal links with
    their centres midway; None where it bears little, or its weight is unknown.
    """
    if arm.weight is None:
        return None
    tails = np.array([rotation.T @ far for rotation, far in map(link_tail, arm.link_poses())])
    link = arm.weight / 2 / len(tails) * np.column_stack([np.ones(len(tails)), -tails / 2])
    held = np.einsum("mjkp,kp->mj", gravity_regressor(arm, means.q), link)
    stretched = arm.weight / 2 * STANDARD_GRAVITY * np.linalg.norm(tails, axis=1).sum() / 2
    if np.sqrt((held**2).mean(axis=0)).max() < MIN_SHARE_BORNE * stretched:
        return None
    return float(np.linalg.norm(means.currents[MEASURED_CURRENT]) / size(held))


def constant_torques(means: BlockMeans) -> Iterator[Finding]:
    """Find torques that stay the same while their joints move."""
    changes = np.ptp(means.currents[MEASURED_CURRENT], axis=0) > SMALLEST_CHANGE
    if still := (1 + np.flatnonzero(moving_joints(means) & ~changes)).tolist():
        yield contradiction("constant torques", joints=still)


def exchanged_torques(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find two joints, each of which explains the other's torque better than its own."""
    gains = gains_of_exchanged_torques(means, arm)
    pair = max(gains, key=lambda one: gains[one], default=None)
    if pair is not None and gains[pair] > MIN_LEAD_OF_EXCHANGE:
        yield contradiction("exchanged torques", joint=pair[0] + 1, other=pair[1] + 1)


def gains_of_exchanged_torques(means: BlockMeans, arm: Robot) -> dict[Pair, float]:
    """Return how much likelier the torques of two joints that move, from 0, are exchanged.

    A joint's torque is explained by its own friction, gravity and inertia.
    """
    torques, offset = means.currents[MEASURED_CURRENT], np.ones((len(means.q), 1))
    variances = []
    for joint, gravity in enumerate(gravity_columns(arm, means.q)):
        columns = np.hstack([means.friction(joint), gravity, means.qdd[:, [joint]], offset])
        basis, _ = np.linalg.qr(columns)
        residual = torques - basis @ (basis.T @ torques)
        variances.append((residual**2).mean(axis=0) + CURRENT_NOISE**2)
    by_joint = means.log_likelihood(np.array(variances))  # (n, n), row: of the joint that explains
    moving = np.flatnonzero(moving_joints(means)).tolist()
    return {
        (j, k): float(by_joint[j, k] + by_joint[k, j] - by_joint[j, j] - by_joint[k, k])
        for j, k in combinations(moving, 2)
    }
