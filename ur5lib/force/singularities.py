"""Singularities of the arm, and the forces that cause no joint torques there."""

import numpy as np
from scipy.stats import qmc

from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array, Mask

Limits = list[tuple[float, float]]

SINGULARITY_KINDS = ("shoulder", "elbow", "wrist")


def smallest_singular_value(jacobian: Array) -> Array:
    """Return sigma_min of J, (N,), in mixed units: metres and radians count alike."""
    return np.asarray(np.linalg.svd(jacobian, compute_uv=False)[:, -1], np.float64)


def singular_distances(robot: Robot, q: Array) -> Array:
    """Return distances (N, 3) of positions (N, 6) from shoulder, elbow and wrist singularity.

    det J = ± a2 a3 s3 s5 (a2 c2 + a3 c23 + d5 s234) for arms of this geometry. The first column is
    the last factor [m], the wrist's distance from the plane of axes 1 and 2; the others are |s3|
    and |s5|.
    """
    dh = robot.denavit_hartenberg
    second, third, fourth = q[:, 1], q[:, 1] + q[:, 2], q[:, 1:4].sum(axis=1)
    # a2 c2 + a3 c23 + d5 s234, up to signs that do not matter here
    reach = dh[1].a * np.cos(second) + dh[2].a * np.cos(third) + dh[4].d * np.sin(fourth)
    return np.abs(np.stack([reach, np.sin(q[:, 2]), np.sin(q[:, 4])], axis=1))


def sample_joints(limits: Limits, count: int) -> Array:
    """Return joint positions (count, 6) evenly over joint ranges [rad], by Halton's sequence."""
    low, high = np.array(limits).T
    return low + (high - low) * qmc.Halton(len(limits), scramble=False).random(count)


def singular_shares(robot: Robot, q: Array, singular: Mask) -> dict[str, float]:
    """Return the share of positions q (M, 6) with each kind of singularity; singular: (M,).

    A position's kind is that with the smallest distance, the shoulder's relative to the length of
    the stretched arm.
    """
    stretched = sum(abs(link.a) for link in robot.denavit_hartenberg)
    kind = np.argmin(singular_distances(robot, q) / [stretched, 1, 1], axis=1)
    return {
        name: float((singular & (kind == i)).mean()) for i, name in enumerate(SINGULARITY_KINDS)
    }
