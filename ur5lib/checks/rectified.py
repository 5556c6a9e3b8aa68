"""Check that currents, or motors' torques, have a sign: that they are no sizes."""

from collections.abc import Iterator

import numpy as np

from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.channels import MIN_MOVING_SPEED
from ur5lib.checks.delays import CURRENT_NOISE
from ur5lib.records.codes import CauseCode
from ur5lib.records.phrases import numbered
from ur5lib.records.quality import Finding, contradiction
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_columns
from ur5lib.timeseries.arrays import Array

MIN_BLOCKS_EACH_WAY = 5  # a joint turns each way in this many blocks
# A difference of log-likelihoods. In right recordings, no effort of one sign is likelier as a
# size.
MIN_LEAD_OF_SIZES = 3.0
MIN_UNSIGNED_JOINTS = 2  # one alone may be its offset


def rectified_efforts(means: BlockMeans, arm: Robot, name: str) -> Iterator[Finding]:
    """Find efforts recorded as sizes, without sign. arm: with what it carries; name: of their
    channel.
    """
    if joints := unsigned_joints(means, means.effort, arm):
        detail = (
            f"{name} holds sizes without a sign: motion and friction of "
            f"{numbered(joint + 1 for joint in joints)} change their direction, but no value its "
            "sign; record it with its sign"
        )
        yield contradiction(CauseCode.RECTIFIED_EFFORTS, "rectified", detail)


def unsigned_joints(means: BlockMeans, effort: Array, arm: Robot) -> list[int]:
    """Return the joints, from 0, with efforts (M, n) that are likelier with the sign of the
    velocity.

    Empty if any effort changes its sign, or for a single joint. Friction changes its sign with the
    velocity; gravity does not, so that an effort of one sign that carries an arm is less likely so.
    """
    joints = [j for j, qd in enumerate(means.qd.T) if _turns_both_ways(qd)]
    moving = {j: effort[np.abs(means.qd[:, j]) > MIN_MOVING_SPEED, j] for j in joints}
    if any(own.min() < 0 < own.max() for own in moving.values()):
        return []
    gravity = gravity_columns(arm, means.q)
    leads = {j: _lead_of_sizes(means, effort[:, j], gravity[j], j) for j in joints}
    unsigned = [j for j in joints if leads[j] > MIN_LEAD_OF_SIZES]
    return unsigned if len(unsigned) >= MIN_UNSIGNED_JOINTS else []


def _turns_both_ways(qd: Array) -> bool:
    ways = [np.sum(qd > MIN_MOVING_SPEED), np.sum(qd < -MIN_MOVING_SPEED)]
    return bool(min(ways) >= MIN_BLOCKS_EACH_WAY)


def _lead_of_sizes(means: BlockMeans, effort: Array, gravity: Array, joint: int) -> float:
    """Return by how much the log-likelihood of an effort (M,) grows with the sign of its joint's
    velocity.
    """
    moves = np.abs(means.qd[:, joint]) > MIN_MOVING_SPEED
    offset = np.ones(len(effort))
    columns = np.column_stack([means.friction(joint), gravity, means.qdd[:, joint], offset])
    basis, _ = np.linalg.qr(columns[moves])
    ways = np.stack([effort, effort * np.sign(means.qd[:, joint])], axis=1)[moves]
    left = ways - basis @ (basis.T @ ways)
    as_read, turned = np.log((left**2).mean(axis=0) + CURRENT_NOISE**2)
    return float(moves.sum() * means.independent / 2 * (as_read - turned))
