"""Measurement equation of an inertial measurement unit on frame 6."""

from dataclasses import dataclass

import numpy as np

from ur5lib.timeseries.arrays import Array

MOTION = 18  # states of six joints: q, q̇, q̈
BIASES = 6  # states of the IMU: biases of accelerometer and gyroscope


@dataclass(frozen=True)
class LinearImu:
    """Specific force [m/s²] and angular rate [rad/s], sensor axes: offset + H [q, q̇, q̈, b_a, b_g].

    offset: (N, 6); H: (N, 6, 24).
    """

    offset: Array
    H: Array

    def predict(self, motion: Array, std: Array, shared: Array) -> tuple[Array, Array]:
        """Predict readings (N, 6) without biases, and their variances (N, 6).

        motion, std: (N, 18), q, q̇ and q̈ side by side, and their standard deviations; shared:
        (N, 6), covariance of q̇ and q̈.
        """
        H = self.H[..., :MOTION]
        by_qd, by_qdd = H[..., 6:12], H[..., 12:]  # nothing depends on q
        variance = np.matvec(H**2, std**2) + 2 * np.matvec(by_qd * by_qdd, shared)
        return self.offset + np.matvec(H, motion), variance


def linearise_imu(
    R6: Array, J: Array, qd: Array, point: Array, axes: Array, up: Array
) -> LinearImu:
    """Linearise the sensor's equation about the measured motion, for all samples at once.

    R6: (N, 3, 3), frame 6 seen from the base; J: (N, 6, 6), geometric Jacobian of its origin, base
    frame; qd: (N, 6) [rad/s], measured; point: (3,) [m], the sensor in frame 6 (Equation 5.9);
    axes: R_m (3, 3), its axes in frame 6; up: −g0 (3,) [m/s²], base frame.

    f = R_mᵀ R_6ᵀ (J_v q̈ + J̇_v q̇ − g0) + b_a and ω = R_mᵀ R_6ᵀ J_w q̇ + b_g. Positions are those
    measured: their errors change f by some 0.001 m/s², far less than its noise.
    """
    J_v, J_w = point_jacobian(R6, J, point), J[:, 3:]  # (N, 3, 6)
    J_v_rate = np.einsum("ncij,nj->nci", jacobian_derivative(J_v, J_w), qd)  # J̇_v (N, 3, 6)
    to_sensor = axes.T @ R6.swapaxes(1, 2)  # R_mᵀ R_6ᵀ (N, 3, 3)
    # J̇_v q̇ is quadratic in q̇: about the measured q̇₀ it is −J̇_v q̇₀ + 2 J̇_v q̇
    H = np.zeros((len(J), 6, MOTION + BIASES))
    H[:, :3, 6:12] = to_sensor @ (2 * J_v_rate)
    H[:, :3, 12:18] = to_sensor @ J_v
    H[:, 3:, 6:12] = to_sensor @ J_w
    H[:, :, MOTION:] = np.eye(BIASES)
    # offset = R_mᵀ R_6ᵀ (−J̇_v q̇₀ − g0)
    free = -(J_v_rate @ qd[..., None])[..., 0] + up
    offset = np.zeros((len(J), 6))
    offset[:, :3] = (to_sensor @ free[..., None])[..., 0]
    return LinearImu(offset, H)


def point_jacobian(R6: Array, J: Array, point: Array) -> Array:
    """Return J_v of a point of frame 6, (N, 3, 6): J_v − [R_6 p]× J_w."""
    return J[:, :3] + np.cross(J[:, 3:], (R6 @ point)[:, :, None], axis=1)


def jacobian_derivative(J_v: Array, J_w: Array) -> Array:
    """Return ∂J_v,i/∂q_j = J_w,min(i,j) × J_v,max(i,j), (N, 3, i, j), of any point of link 6."""
    i = np.arange(6)
    first, last = np.minimum(i[:, None], i), np.maximum(i[:, None], i)
    return np.cross(J_w[:, :, first], J_v[:, :, last], axis=1)
