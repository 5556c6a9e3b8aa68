"""Checks of measured torques: that they change, and are those of an arm's weight."""

from collections.abc import Iterator

import numpy as np

from ur5lib.checks.block_means import BlockMeans, size
from ur5lib.checks.currents import moving_joints
from ur5lib.records.codes import CauseCode
from ur5lib.records.phrases import number, numbered
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import link_tail
from ur5lib.robots.statics import STANDARD_GRAVITY, gravity_regressor

# Ratio to the torque that carries equal links of the described weight, or its inverse. It is 0.5 to
# 2.3 in right recordings of six arms.
MAX_SIZE_RATIO = 10.0
# The same of described links, which may be guesses. A tenth of an arm's weight explains no unit.
MAX_SIZE_RATIO_OF_LINKS = 100.0
# Share of the torque that carries an arm stretched out. Friction may be many times a smaller one.
MIN_SHARE_BORNE = 0.25
SMALLEST_CHANGE = 1e-9  # Nm; a logged torque changes by more


def foreign_size(means: BlockMeans, arm: Robot) -> Iterator[Finding]:
    """Find torques far too large or too small for an arm of the described links or weight."""
    ratio, known = size_ratio(means, arm), arm.tells_gravity()
    most = MAX_SIZE_RATIO_OF_LINKS if known else MAX_SIZE_RATIO
    if ratio is not None and not 1 / most < ratio < most:
        yield _foreign_size(ratio, arm, known)


def _foreign_size(ratio: float, arm: Robot, by_links: bool) -> Finding:
    if by_links:
        detail = (
            f"actual_torque is {number(ratio, '.2g')} times what would hold the "
            f"{number(sum(arm.masses), '.3g')} kg of the links of {arm.name}; correct its unit or "
            "columns, or say `links: unknown` in the description if the masses there are guesses"
        )
        return contradiction(CauseCode.FOREIGN_SIZE_OF_LINKS, "unit", detail)
    detail = (
        f"actual_torque is {number(ratio, '.2g')} times what would hold an arm of "
        f"{number(arm.weight, 'g')} kg; correct its unit or columns, `gear_ratio` and `effort` of "
        f"{arm.name}, or its `weight`"
    )
    return contradiction(CauseCode.FOREIGN_SIZE, "unit", detail)


def size_ratio(means: BlockMeans, arm: Robot) -> float | None:
    """Return the size of torques relative to those that carry the arm: its links or, where these
    are unknown, half of its weight in equal links with their centres midway; None where they weigh
    little on all joints, or its weight is unknown.
    """
    torque = means.effort
    if arm.tells_gravity():
        return float(np.linalg.norm(torque) / size(means.gravity(arm)))
    if arm.weight is None:
        return None
    tails = np.array([rotation.T @ far for rotation, far in map(link_tail, arm.link_poses())])
    link = arm.weight / 2 / len(tails) * np.column_stack([np.ones(len(tails)), -tails / 2])
    held = np.einsum("mjkp,kp->mj", gravity_regressor(arm, means.q), link)
    stretched = arm.weight / 2 * STANDARD_GRAVITY * np.linalg.norm(tails, axis=1).sum() / 2
    if np.sqrt((held**2).mean(axis=0)).max() < MIN_SHARE_BORNE * stretched:
        return None
    return float(np.linalg.norm(torque) / size(held))


def constant_torques(means: BlockMeans) -> Iterator[Finding]:
    """Find torques that stay the same while their joints move."""
    changes = np.ptp(means.effort, axis=0) > SMALLEST_CHANGE
    if still := (1 + np.flatnonzero(moving_joints(means) & ~changes)).tolist():
        detail = (
            f"actual_torque does not change on {numbered(still)} while the motion does; correct "
            "the columns, or leave actual_torque out"
        )
        yield contradiction(CauseCode.CONSTANT_TORQUES, "torques", detail)
