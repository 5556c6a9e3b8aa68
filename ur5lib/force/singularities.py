"""Where the arm is singular, and which forces then leave no trace in the joint torques."""

from dataclasses import dataclass

import numpy as np
from scipy.stats import qmc

from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

Limits = list[tuple[float, float]]

KINDS = ("shoulder", "elbow", "wrist")


def manipulability(jacobian: Array) -> Array:
    """sqrt det(J J^T) = |det J|, (N,) [Yoshikawa 1985]. jacobian: (N, 6, 6)."""
    return np.abs(np.linalg.det(jacobian))


def smallest_singular_value(jacobian: Array) -> Array:
    """sigma_min of J, (N,): mixed units, as metres and radians count alike."""
    return np.asarray(np.linalg.svd(jacobian, compute_uv=False)[:, -1], np.float64)


@dataclass(frozen=True)
class UnseenForce:
    """The force at the origin of frame 6 that the joints feel least.

    direction: (N, 3), base axes, sign open; lever: (N,), torque by force [Nm/N], 0 when unseen.
    """

    direction: Array
    lever: Array


def unseen_force(jacobian: Array) -> UnseenForce:
    """From the Jacobian's linear part: the left singular vector of its least singular value."""
    left, values, _ = np.linalg.svd(jacobian[:, :3])
    return UnseenForce(left[:, :, -1], values[:, -1])


def unseen_wrench(jacobian: Array) -> Array:
    """Unit wrench (N, 6) with the least joint torque |J^T F|: none at all at a singularity."""
    return np.linalg.svd(jacobian)[0][:, :, -1]


def singular_distances(robot: Robot, q: Array) -> Array:
    """How far (N, 3) joint positions (N, 6) are from shoulder, elbow and wrist singularity.

    det J = ± a2 a3 s3 s5 (a2 c2 + a3 c23 + d5 s234) for arms of this geometry. The first column is
    the last factor [m]: the wrist's distance to the plane of axes 1 and 2; the others |s3|, |s5|.
    """
    dh = robot.denavit_hartenberg
    second, third, fourth = q[:, 1], q[:, 1] + q[:, 2], q[:, 1:4].sum(axis=1)
    reach = dh[1].a * np.cos(second) + dh[2].a * np.cos(third) + dh[4].d * np.sin(fourth)
    return np.abs(np.stack([reach, np.sin(q[:, 2]), np.sin(q[:, 4])], axis=1))


def sample_joints(limits: Limits, count: int) -> Array:
    """Joint positions (count, 6) evenly over joint ranges [rad], by Halton's sequence."""
    low, high = np.array(limits).T
    return low + (high - low) * qmc.Halton(len(limits), scramble=False).random(count)


@dataclass(frozen=True)
class SingularityMap:
    """Of joint positions q (M, 6): sigma_min, manipulability (M,), distances (M, 3).

    share: of the positions that are singular, by kind.
    """

    q: Array
    sigma_min: Array
    manipulability: Array
    distances: Array
    share: dict[str, float]


def map_singularities(
    robot: Robot, q: Array, jacobian: Array, min_singular_value: float
) -> SingularityMap:
    """Which of the positions q (M, 6), with Jacobians (M, 6, 6), are singular, and of which kind.

    Below `min_singular_value` a position counts as singular; of the kind whose distance is
    smallest, the shoulder's as a share of the stretched arm.
    """
    sigma = smallest_singular_value(jacobian)
    distances = singular_distances(robot, q)
    stretched = sum(abs(link.a) for link in robot.denavit_hartenberg)
    kind = np.argmin(distances / [stretched, 1, 1], axis=1)
    singular = sigma < min_singular_value
    share = {name: float((singular & (kind == i)).mean()) for i, name in enumerate(KINDS)}
    return SingularityMap(q, sigma, manipulability(jacobian), distances, share)
