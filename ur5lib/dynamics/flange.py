"""Motion of the flange, and derivatives of its kinematics: arrays in, arrays out."""

from functools import partial

import numpy as np
import torch

from ur5lib.dynamics import kinematics
from ur5lib.dynamics.arm import ArmTensors, PullBack, build_arm, with_pull_back
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian
from ur5lib.timeseries.arrays import Array

TWIST_POSTURES = 20  # number of random postures that show an arm's twists
RANK_TOLERANCE = 1e-6  # m and rad; what counts as zero


def independent_twists(robot: Robot) -> int:
    """Return the number of independent twists of the flange: the largest rank of J_g, at most 6."""
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (TWIST_POSTURES, len(robot.joints)))
    return int(np.linalg.matrix_rank(geometric_jacobian(robot, q), tol=RANK_TOLERANCE).max())


def singular_value(arm: ArmTensors, q: Array, twists: int) -> Array:
    """Return the smallest singular value (N,) of J_g that is not always zero, rows in m and rad.

    arm: under any link model; q: (N, n) [rad]; twists: their number, see `independent_twists`.
    """
    return _smallest(arm, twists, torch.from_numpy(q)).numpy()


def differentiable_singular_value(arm: ArmTensors, q: Array, twists: int) -> tuple[Array, PullBack]:
    """Return `singular_value` (N,) and the pull-back of its derivative with respect to q."""
    return with_pull_back(partial(_smallest, arm, twists), q)


def _smallest(arm: ArmTensors, twists: int, q: torch.Tensor) -> torch.Tensor:
    return torch.linalg.svdvals(kinematics.jacobian(arm, q))[:, twists - 1]


def point_acceleration(robot: Robot, q: Array, qd: Array, qdd: Array, point: Array) -> Array:
    """Return linear and angular acceleration (N, 6) [m/s², rad/s²], base frame, of a point on frame
    n.

    q, qd, qdd: (N, n) [rad, rad/s, rad/s²]; point: (3,) [m], in frame n.
    """
    position, velocity, acceleration = map(torch.from_numpy, (q, qd, qdd))
    arm, place = build_arm(robot, robot.chosen_model), torch.from_numpy(point)
    return kinematics.acceleration(arm, position, velocity, acceleration, point=place).numpy()
