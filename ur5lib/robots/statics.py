"""Poses of the links and torques of gravity in NumPy, for checks that do not load torch.

`ur5lib/dynamics` computes the same, and motion as well; the tests compare both.
"""

import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import link_tail, rigid_bodies
from ur5lib.timeseries.arrays import Array


def link_frames(robot: Robot, q: Array) -> tuple[Array, Array]:
    """Return rotations (N, n + 1, 3, 3) and origins (N, n + 1, 3) [m] of frames 0 to n.

    q: (N, n) [rad]. In the base frame (Equation 2.19).
    """
    rotations, origins = [np.tile(np.eye(3), (len(q), 1, 1))], [np.zeros((len(q), 3))]
    for angle, pose in zip(q.T, robot.link_poses(), strict=True):
        near = rotations[-1] @ _turn(angle)
        rotation, translation = link_tail(pose)
        origins.append(origins[-1] + near @ translation)
        rotations.append(near @ rotation)
    return np.stack(rotations, axis=1), np.stack(origins, axis=1)


def gravity_torque(robot: Robot, model: str, q: Array) -> Array:
    """Return the torque (N, n) [Nm] that holds the arm, payload included; q: (N, n) [rad]."""
    rotation, origin = link_frames(robot, q)
    bodies = rigid_bodies(robot, model)
    centers = np.einsum("nkij,kj->nki", rotation[:, 1:], bodies.center_of_mass) + origin[:, 1:]
    weights, joints = bodies.mass[:, None] * np.array(robot.gravity), range(q.shape[1])
    return np.stack(
        [
            sum(_holding(rotation, origin, j, centers[:, k], weights[k]) for k in joints[j:])
            for j in joints
        ],
        axis=1,
    )


def load_torque(robot: Robot, q: Array) -> Array:
    """Return the torque (N, n, 4) that holds a load on the flange, per mass [Nm/kg] and per first
    moment in frame n [Nm/(kg m)]; q: (N, n) [rad].
    """
    rotation, origin = link_frames(robot, q)
    gravity = np.array(robot.gravity)
    torque = np.zeros((*q.shape, 4))
    for joint in range(q.shape[1]):
        torque[:, joint, 0] = _holding(rotation, origin, joint, origin[:, -1], gravity)
        across = np.cross(gravity, rotation[:, joint, :, 2])  # g·(z × c) = (g × z)·c
        torque[:, joint, 1:] = -np.einsum("ni,nij->nj", across, rotation[:, -1])
    return torque


def _turn(angle: Array) -> Array:
    """Return Rot_z (N, 3, 3) of angles (N,) [rad]."""
    c, s, zero, one = np.cos(angle), np.sin(angle), np.zeros_like(angle), np.ones_like(angle)
    rows = [[c, -s, zero], [s, c, zero], [zero, zero, one]]
    return np.moveaxis(np.array(rows), 2, 0)


def _holding(rotation: Array, origin: Array, joint: int, point: Array, weight: Array) -> Array:
    """Return the torque (N,) [Nm] of a joint that holds a weight (3,) [N] at points (N, 3).

    joint: counted from 0.
    """
    lever = np.cross(rotation[:, joint, :, 2], point - origin[:, joint])
    return -lever @ weight
