"""Poses, Jacobians and torques of gravity in NumPy, for those that do not load torch.

`ur5lib/dynamics` computes them, too, with derivatives, and motion as well; the tests compare both.
Loading torch takes longer than reading a recording.
"""

import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import link_tail, rigid_bodies
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import in_chunks

POSTURES = 200  # so many random postures load each joint that gravity can load
BEARING_SHARE = 0.03  # a joint is loaded from this share of its largest torque on

STANDARD_GRAVITY = 9.81  # m/s²
MIN_SINGULAR_VALUE = 0.03  # of a usable J_g, with rows in m and rad
# Smallest singular value, over the largest, of torques per mass and first moment that counts.
SMALLEST_SINGULAR_VALUE = 1e-3


def link_frames(robot: Robot, q: Array) -> tuple[Array, Array]:
    """Return rotations (N, n + 1, 3, 3) and origins (N, n + 1, 3) [m] of frames 0 to n.

    q: (N, n) [rad]. In the base frame (Equation 2.19).
    """
    rotations, origins = [np.tile(np.eye(3), (len(q), 1, 1))], [np.zeros((len(q), 3))]
    for angle, pose in zip(q.T, robot.link_poses(), strict=True):
        rows = _turned_about_z(rotations[-1], angle).reshape(-1, 3)  # one product for all samples
        rotation, translation = link_tail(pose)
        origins.append(origins[-1] + (rows @ translation).reshape(-1, 3))
        rotations.append((rows @ rotation).reshape(-1, 3, 3))
    return np.stack(rotations, axis=1), np.stack(origins, axis=1)


def gravity_torque(robot: Robot, model: str, q: Array) -> Array:
    """Return the torque (N, n) [Nm] against gravity, payload included; q: (N, n) [rad].

    τ_j = −z_j · Σ_k≥j (c_k − o_j) × m_k g
    """
    rotation, origin = link_frames(robot, q)
    bodies = rigid_bodies(robot, model)
    centers = np.einsum("nkij,kj->nki", rotation[:, 1:], bodies.center_of_mass) + origin[:, 1:]
    weights = bodies.mass[:, None] * np.array(robot.gravity)
    # Σ_k≥j c_k × m_k g
    moment = np.cumsum(np.cross(centers, weights)[:, ::-1], axis=1)[:, ::-1]
    # Σ_k≥j m_k g
    carried = np.cumsum(weights[::-1], axis=0)[::-1]
    about_joints = moment - np.cross(origin[:, :-1], carried)
    return -np.einsum("nji,nji->nj", rotation[:, :-1, :, 2], about_joints)


def bearing_joints(robot: Robot) -> list[int]:
    """Return the joints, from 1, that gravity loads in some posture; all if the links are unknown.

    The load is at least BEARING_SHARE of their largest torque, enough to show their torque
    constant.
    """
    count = len(robot.joints)
    if robot.links == "unknown":
        return [*range(1, count + 1)]
    postures = np.random.default_rng(0).uniform(-np.pi, np.pi, size=(POSTURES, count))
    torque = np.abs(gravity_torque(robot, robot.fullest_model(), postures)).max(axis=0)
    return (np.flatnonzero(torque > BEARING_SHARE * np.array(robot.torque_limits())) + 1).tolist()


def load_torque(robot: Robot, q: Array) -> Array:
    """Return the torque (N, n, 4) against gravity of a load in frame n; q: (N, n) [rad].

    Last axis: per mass [Nm/kg], then per first moment [Nm/(kg m)].
    """
    return gravity_regressor(robot, q)[:, :, -1]


def gravity_regressor(robot: Robot, q: Array) -> Array:
    """Return the torque (N, n, n, 4) against gravity of each link (third axis); q: (N, n) [rad].

    Last axis: per mass [Nm/kg], then per first moment in the link's frame [Nm/(kg m)].
    """
    rotation, origin = link_frames(robot, q)
    gravity = np.array(robot.gravity)
    torque = np.zeros((*q.shape, q.shape[1], 4))
    for joint in range(q.shape[1]):
        axis, links = rotation[:, joint, :, 2], slice(joint + 1, None)
        across = np.cross(gravity, axis)  # g·(z × c) = (g × z)·c
        arms = origin[:, links] - origin[:, [joint]]
        torque[:, joint, joint:, 0] = -np.einsum("ni,nki->nk", across, arms)
        torque[:, joint, joint:, 1:] = -np.einsum("ni,nkij->nkj", across, rotation[:, links])
    return torque


def gravity_columns(robot: Robot, q: Array) -> list[Array]:
    """Return for each joint the columns (N, c) of which its possible gravity torque is a linear
    combination; q: (N, n) [rad].

    One column for described links; for unknown links, an orthonormal basis of the torques of any
    links.
    """
    if robot.tells_gravity():
        return [*gravity_torque(robot, robot.chosen_model, q).T[..., None]]
    by_link, joints = gravity_regressor(robot, q), range(q.shape[1])
    carried = [np.concatenate([*by_link[:, j, j:].swapaxes(0, 1)], axis=1) for j in joints]
    parts = [np.linalg.svd(own, full_matrices=False)[:2] for own in carried]
    # over all joints: an upright axis has only rounding errors
    largest = max(sizes.max(initial=0.0) for _, sizes in parts)
    return [basis[:, sizes > SMALLEST_SINGULAR_VALUE * largest] for basis, sizes in parts]


def _turned_about_z(rotation: Array, angle: Array) -> Array:
    """Return R Rot_z (N, 3, 3) of rotations R (N, 3, 3) and angles (N,) [rad]."""
    c, s = np.cos(angle)[:, None], np.sin(angle)[:, None]
    x, y, turned = rotation[:, :, 0], rotation[:, :, 1], rotation.copy()
    turned[:, :, 0], turned[:, :, 1] = c * x + s * y, c * y - s * x
    return turned


def geometric_jacobian(robot: Robot, q: Array) -> Array:
    """Return J_g (N, 6, n) of the last frame's origin, base frame, linear rows first.

    q: (N, n) [rad].
    """
    return _jacobian(*link_frames(robot, q))


def flange_kinematics(robot: Robot, q: Array) -> tuple[Array, Array, Array]:
    """Return R_n (N, 3, 3), o_n (N, 3) [m] and J_g (N, 6, n), base frame. q: (N, n) [rad]."""

    def side_by_side(q: Array) -> Array:
        rotations, origins = link_frames(robot, q)
        parts = rotations[:, -1], origins[:, -1], _jacobian(rotations, origins)
        return np.concatenate([part.reshape(len(q), -1) for part in parts], axis=1)

    rotation, origin, jacobian = np.split(in_chunks(side_by_side, q), [9, 12], axis=1)
    return rotation.reshape(-1, 3, 3), origin, jacobian.reshape(len(q), 6, -1)


def _jacobian(rotations: Array, origins: Array) -> Array:
    axes = rotations[:, :-1, :, 2]
    linear = np.cross(axes, origins[:, -1:] - origins[:, :-1])
    return np.concatenate([linear, axes], axis=2).mT
