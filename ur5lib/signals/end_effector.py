"""Acceleration of a point of the end effector, from the joints and from the IMU."""

import numpy as np

from ur5lib.signals.imu_model import jacobian_derivative, point_jacobian
from ur5lib.timeseries.arrays import Array


def point_velocity(rotation: Array, jacobian: Array, qd: Array, point: Array) -> Array:
    """Return J_g q̇ of a point of frame 6, (N, 6) [m/s, rad/s], base frame.

    rotation: R_6 (N, 3, 3); jacobian: J_g (N, 6, 6) of its origin; qd: (N, 6) [rad/s];
    point: (3,) [m], in frame 6.
    """
    linear = point_jacobian(rotation, jacobian, point)
    return _apply(np.concatenate([linear, jacobian[:, 3:]], axis=1), qd)


def point_acceleration(
    rotation: Array, jacobian: Array, qd: Array, qdd: Array, point: Array
) -> Array:
    """Return J_g q̈ + J̇_g q̇ of a point of frame 6, (N, 6) [m/s², rad/s²], without gravity.

    Base frame. Arguments as in `point_velocity`, and qdd: (N, 6) [rad/s²]. No angles are used, so
    their singularities do not matter.
    """
    linear, angular = point_jacobian(rotation, jacobian, point), jacobian[:, 3:]
    linear_rate = _apply(jacobian_derivative(linear, angular), qd[:, None])
    angular_rate = _apply(_axis_derivative(angular), qd[:, None])
    J = np.concatenate([linear, angular], axis=1)
    J_rate = np.concatenate([linear_rate, angular_rate], axis=1)
    return _apply(J, qdd) + _apply(J_rate, qd)


def felt_acceleration(
    rotation: Array, accelerometer: Array, angular_acceleration: Array, up: Array
) -> Array:
    """Return R a + g0 and R α (Equation 5.11, sign corrected: erratum 3), (N, 6), base frame.

    rotation: of the IMU's axes (N, 3, 3); accelerometer: (N, 3) [m/s²], without bias;
    angular_acceleration: (N, 3) [rad/s²], the gyroscope's derivative; up: -g0 (3,) [m/s²].
    """
    linear = _apply(rotation, accelerometer) - up
    return np.concatenate([linear, _apply(rotation, angular_acceleration)], axis=1)


def _axis_derivative(axes: Array) -> Array:
    """Return ∂J_w,i/∂q_j = J_w,j × J_w,i for j < i, else 0: (N, 3, i, j). axes: J_w (N, 3, 6)."""
    turned = np.cross(axes[:, :, None, :], axes[:, :, :, None], axis=1)
    return np.tril(turned, k=-1)


def _apply(matrix: Array, vector: Array) -> Array:
    """Multiply matrices (..., R, C) by vectors (..., C)."""
    return (matrix @ vector[..., None])[..., 0]
