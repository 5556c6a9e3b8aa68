"""Motion of a point that the last frame carries, by the geometric Jacobian of its origin."""

import numpy as np

from ur5lib.timeseries.arrays import Array


def point_jacobian(R6: Array, J: Array, point: Array) -> Array:
    """Return J_v of a point of the last frame, (N, 3, n): J_v − [R p]× J_w."""
    return J[:, :3] + np.cross(J[:, 3:], (R6 @ point)[:, :, None], axis=1)


def jacobian_derivative(J_v: Array, J_w: Array) -> Array:
    """Return ∂J_v,i/∂q_j = J_w,min(i,j) × J_v,max(i,j), (N, 3, i, j), of any point of link n."""
    i = np.arange(J_v.shape[2])
    first, last = np.minimum(i[:, None], i), np.maximum(i[:, None], i)
    return np.cross(J_w[:, :, first], J_v[:, :, last], axis=1)


def point_velocity(rotation: Array, jacobian: Array, qd: Array, point: Array) -> Array:
    """Return J_g q̇ of a point of the last frame, (N, 6) [m/s, rad/s], base frame.

    rotation: R (N, 3, 3); jacobian: J_g (N, 6, n) of its origin; qd: (N, n) [rad/s];
    point: (3,) [m], in that frame.
    """
    linear = point_jacobian(rotation, jacobian, point)
    return np.matvec(np.concatenate([linear, jacobian[:, 3:]], axis=1), qd)


def point_acceleration(
    rotation: Array, jacobian: Array, qd: Array, qdd: Array, point: Array
) -> Array:
    """Return J_g q̈ + J̇_g q̇ of a point of the last frame, (N, 6) [m/s², rad/s²], without gravity.

    Base frame. Arguments as in `point_velocity`, and qdd: (N, n) [rad/s²]. No angles are used, so
    their singularities do not matter.
    """
    linear, angular = point_jacobian(rotation, jacobian, point), jacobian[:, 3:]
    linear_rate = np.matvec(jacobian_derivative(linear, angular), qd[:, None])
    # ∂J_w,i/∂q_j = J_w,j × J_w,i for j < i, else 0: (N, 3, i, j)
    turned = np.cross(angular[:, :, None, :], angular[:, :, :, None], axis=1)
    angular_rate = np.matvec(np.tril(turned, k=-1), qd[:, None])
    J = np.concatenate([linear, angular], axis=1)
    J_rate = np.concatenate([linear_rate, angular_rate], axis=1)
    return np.matvec(J, qdd) + np.matvec(J_rate, qd)
