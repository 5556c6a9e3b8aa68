"""Torques of an arm in motion in NumPy, for checks that do not load torch.

`ur5lib/dynamics` has the same regressor on torch; the tests compare both, and Pinocchio's.
"""

import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import inertial_parameters, link_tail, rigid_bodies
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array

INERTIA_ENTRIES = [(0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2)]  # xx xy yy xz yz zz


def torque(robot: Robot, model: str, q: Array, qd: Array, qdd: Array) -> Array:
    """Return τ = Y π (N, n) [Nm] of a link model in free motion, payload included.

    q, qd, qdd: (N, n) [rad, rad/s, rad/s²].
    """
    parameters = inertial_parameters(robot, rigid_bodies(robot, model))
    return np.asarray(torque_regressor(robot, q, qd, qdd) @ parameters)


def torque_regressor(robot: Robot, q: Array, qd: Array, qdd: Array) -> Array:
    """Return Y (N, n, 11 n) of τ = Y π, with π as in `inertia.inertial_parameters`.

    q, qd, qdd: (N, n) [rad, rad/s, rad/s²]. Motions are computed outwards by Newton and Euler. The
    wrench of each link's parameters, about its joint and in its axes, gives the torques of the
    joints inwards: τ_j = z_j · n_k + (z_j × (o_k - o_j)) · f_k.
    """
    count = q.shape[1]
    rotations, origins = link_frames(robot, q)
    axes, tails = rotations[:, :-1, :, 2], [link_tail(pose)[0] for pose in robot.link_poses()]
    result = np.zeros((len(q), count, 11 * count))
    rate, change = np.zeros((2, len(q), 3))  # ω and ω' of the previous link
    acceleration = np.tile(-np.array(robot.gravity), (len(q), 1))  # of the link's joint
    for k in range(count):
        speed = axes[:, k] * qd[:, [k]]
        change = change + axes[:, k] * qdd[:, [k]] + np.cross(rate, speed)
        rate = rate + speed
        turn = rotations[:, k + 1] @ tails[k].T  # axes of the link
        force, moment = _unit_wrenches(*(_in_axes(turn, v) for v in (acceleration, rate, change)))
        inner = axes[:, : k + 1]
        lever = np.cross(inner, origins[:, [k]] - origins[:, : k + 1])
        result[:, : k + 1, 10 * k : 10 * (k + 1)] = inner @ turn @ moment + lever @ turn @ force
        result[:, k, 10 * count + k] = qdd[:, k]
        reach = origins[:, k + 1] - origins[:, k]
        inwards = np.cross(rate, np.cross(rate, reach))
        acceleration = acceleration + np.cross(change, reach) + inwards
    return result


def _unit_wrenches(acceleration: Array, rate: Array, change: Array) -> tuple[Array, Array]:
    """Return the forces and moments (N, 3, 10) of a link's motion for each inertial parameter.

    f = m a + (ω' + ω ω) × m c and n = m c × a + I ω' + ω × I ω, all (N, 3) in the link's axes.
    """
    across, turning = _cross_matrix(rate), _cross_matrix(change)
    force, moment = np.zeros((2, len(rate), 3, 10))
    force[:, :, 0] = acceleration
    force[:, :, 1:4] = turning + across @ across
    moment[:, :, 1:4] = -_cross_matrix(acceleration)
    moment[:, :, 4:] = _times_inertia(change) + across @ _times_inertia(rate)
    return force, moment


def _in_axes(turn: Array, vector: Array) -> Array:
    """Return vectors (N, 3) in axes that are the columns of turn (N, 3, 3)."""
    return np.einsum("nij,ni->nj", turn, vector)


def _cross_matrix(vector: Array) -> Array:
    """Return S (N, 3, 3) of S x = v × x; vector: v (N, 3)."""
    matrix = np.zeros((len(vector), 3, 3))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        matrix[:, j, i], matrix[:, i, j] = vector[:, k], -vector[:, k]
    return matrix


def _times_inertia(vector: Array) -> Array:
    """Return L (N, 3, 6) of I v = L [I_xx, I_xy, I_yy, I_xz, I_yz, I_zz]; vector: v (N, 3)."""
    matrix = np.zeros((len(vector), 3, 6))
    for entry, (i, j) in enumerate(INERTIA_ENTRIES):
        matrix[:, i, entry] = vector[:, j]
        matrix[:, j, entry] = vector[:, i]
    return matrix
