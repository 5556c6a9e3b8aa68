"""A target_moment that is a command of another kind, where measured efforts are the arm's.

A controller may be given torques less gravity, which it adds itself, or a share of them. Such a
command says nothing against the arm: where gravity confirms what is measured, it is not used.
"""

import numpy as np
import pandas as pd

from ur5lib.channels import MOST_JOINTS, columns
from ur5lib.checks.block_means import BlockMeans, block_means, combination
from ur5lib.recordings.less_gravity import MIN_CHANGE
from ur5lib.records.codes import Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

MIN_BLOCKS = 30
MAX_SHARE_OF_GRAVITY = 0.3  # in a command less gravity
SURE = 3.0  # standard errors
SCALE_RANGE = (0.75, 1.33)  # of gravity in a torque of the arm; a load changes it by less
MAX_RATIO_OF_SCALES = 1.15  # joint by joint, of one scale


def without_command(
    robot: pd.DataFrame, period: float, arm: Robot
) -> tuple[pd.DataFrame, list[Finding]]:
    """Return a repaired table without `target_moment` if that is a command of another kind, and a
    warning that says which.

    period: [s]; arm: under the recording's gravity.
    """
    if "target_moment_0" not in robot or not arm.tells_gravity():
        return robot, []
    means = block_means(robot, period)
    if len(means.q) < MIN_BLOCKS or means.torque is None or not _is_of_arm(means, arm):
        return robot, []
    shares, errors = _gravity_in(means, means.torque, arm)
    kind = _kind(shares, errors)
    if not kind:
        return robot, []
    detail = (
        f"target_moment is {kind}, by gravity on joints that bear it: a command of the controller, "
        f"not compared with {arm.name}, of which {means.measured.channel} has the torque"
    )
    kept = robot.drop(columns=[n for n in columns("target_moment", MOST_JOINTS) if n in robot])
    return kept, [Finding("robot", Found.ODD_TARGET, "warning", 1, detail)]


def _kind(shares: Array, errors: Array) -> str:
    """Return in words which command a torque is, by the shares (k,) of gravity in it; "" where it
    may be the arm's.
    """
    if not len(shares):
        return ""
    if (np.abs(shares) + SURE * errors < MAX_SHARE_OF_GRAVITY).all():
        return Found.LESS_GRAVITY.words
    least, most = SCALE_RANGE
    away = (shares - SURE * errors > most) | ((shares > 0) & (shares + SURE * errors < least))
    alike = shares.max() < MAX_RATIO_OF_SCALES * shares.min()
    return f"scaled by {number(float(np.median(shares)), '.2g')}" if away.all() and alike else ""


def _is_of_arm(means: BlockMeans, arm: Robot) -> bool:
    """Return whether gravity shows in the measured efforts what the arm's have."""
    constants = np.array(arm.maker_torque_constants())
    if not (means.has_efforts() and np.isfinite(constants).all()):
        return False
    shares = _gravity_in(means, means.effort * constants, arm)[0]
    ratios = np.abs(np.log(shares.clip(1e-3)))
    return bool(len(shares) and (ratios < np.log(SCALE_RANGE[1])).all())


def _gravity_in(means: BlockMeans, torque: Array, arm: Robot) -> tuple[Array, Array]:
    """Return the coefficients (k,) of gravity in a torque (M, n) of the joints that bear it,
    without friction and inertia, and their standard errors.
    """
    gravity = means.gravity(arm)
    bearing = np.flatnonzero(np.ptp(gravity, axis=0) > MIN_CHANGE).tolist()
    fits = [
        combination(
            np.column_stack([gravity[:, joint], means.friction(joint), means.qdd]),
            torque[:, joint],
            [1.0],
        )
        for joint in bearing
    ]
    shares, errors = np.array(fits).reshape(-1, 2).T
    return shares, errors
