"""Joint motion from encoders and an IMU on frame 6 by a Kalman smoother."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from ur5lib.robots.end_effector import jacobian_derivative, point_jacobian
from ur5lib.smoothing.encoders import (
    LINK_FROM_STATES,
    STATES_PER_JOINT,
    KnownJoints,
    SmoothedMotion,
    encoder_system,
    widen,
)
from ur5lib.smoothing.noise import moving_mean
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.kalman import LinearSystem, System, innovation_test, smooth
from ur5lib.timeseries.segments import chunks

MOTION_STATES = 18  # q, q̇, q̈ of six joints
BIAS_STATES = 6  # biases of accelerometer and gyroscope
BIAS_STD = np.repeat([0.5, 0.1], 3)  # m/s², rad/s; prior deviations of the biases
BIAS_WALK = np.repeat([1e-3, 1e-4], 3)  # m/s²/√s, rad/s/√s; random walk of the biases
IMU_WINDOW = 0.5  # s; the noise is taken as constant over it
QUIET_WINDOW_SHARE = 0.05  # this share of the windows, the quietest, sets the least noise
JOINT_STATES = 6 * STATES_PER_JOINT  # entries of the state before the biases
ALL_STATES = JOINT_STATES + BIAS_STATES
# The matrix from motions, vibrations and biases to q, q̇, q̈ and biases.
OUTPUTS_FROM_STATES = block_diag(np.kron(LINK_FROM_STATES, np.eye(6)), np.eye(BIAS_STATES))


@dataclass(frozen=True)
class LinearImu:
    """An IMU's readings as a linear function of the motion, offset + H [q, q̇, q̈, b_a, b_g].

    Specific force [m/s²] and angular rate [rad/s], sensor axes; b_a, b_g: biases. offset: (N, 6);
    H: (N, 6, 24).
    """

    offset: Array
    H: Array

    def predict(self, motion: Array, std: Array, shared: Array) -> tuple[Array, Array]:
        """Predict readings (N, 6) without biases, and their variances (N, 6).

        motion, std: (N, 18), q, q̇ and q̈ side by side, and their standard deviations; shared:
        (N, 6), covariance of q̇ and q̈.
        """
        H = self.H[..., :MOTION_STATES]
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
    f = R_mᵀ R_6ᵀ (J_v q̈ + J̇_v q̇ − g0) + b_a and ω = R_mᵀ R_6ᵀ J_w q̇ + b_g. Positions are the
    measured ones: their errors change f by some 0.001 m/s², far less than its noise.
    """
    J_v, J_w = point_jacobian(R6, J, point), J[:, 3:]  # (N, 3, 6)
    J_v_rate = np.einsum("ncij,nj->nci", jacobian_derivative(J_v, J_w), qd)  # J̇_v (N, 3, 6)
    to_sensor = axes.T @ R6.swapaxes(1, 2)  # R_mᵀ R_6ᵀ (N, 3, 3)
    # J̇_v q̇ is quadratic in q̇: about the measured q̇₀ it is −J̇_v q̇₀ + 2 J̇_v q̇
    H = np.zeros((len(J), 6, MOTION_STATES + BIAS_STATES))
    H[:, :3, 6:12] = to_sensor @ (2 * J_v_rate)
    H[:, :3, 12:18] = to_sensor @ J_v
    H[:, 3:, 6:12] = to_sensor @ J_w
    H[:, :, MOTION_STATES:] = np.eye(BIAS_STATES)
    # offset = R_mᵀ R_6ᵀ (−J̇_v q̇₀ − g0)
    specific_force = -(J_v_rate @ qd[..., None])[..., 0] + up
    offset = np.zeros((len(J), 6))
    offset[:, :3] = (to_sensor @ specific_force[..., None])[..., 0]
    return LinearImu(offset, H)


Model = Callable[[slice], LinearImu]
"""Returns an IMU's equation at some samples: a kilobyte each, too much for all at once."""


def smooth_with_imu(
    time: Array,
    segment: Labels,
    q: Array,
    qd: Array,
    readings: Array,
    model: Model,
    encoders: KnownJoints,
) -> SmoothedMotion:
    """Estimate the motion from joints and an IMU, with biases that continue across segments.

    Arguments as in smooth_encoders; readings: (N, 6) specific force [m/s²] and angular rate
    [rad/s], NaN where missing; model: the IMU's equation; encoders: from smooth_encoders.
    """
    # local noise of the IMU from its residuals under the encoders' motion
    residual, explained = np.empty_like(readings), np.empty_like(readings)
    for rows in chunks(len(time)):
        predicted, explained[rows] = model(rows).predict(
            encoders.state[rows], encoders.std[rows], encoders.shared[rows]
        )
        residual[rows] = readings[rows] - predicted
    noise = imu_noise(time, segment, residual, explained)
    # smoother of q, q̇, q̈ and both biases
    joints = encoder_system(time, segment, q, qd, encoders.noise)
    system = add_imu(joints, time, readings, model, noise)
    state, std = np.empty((2, len(time), MOTION_STATES + BIAS_STATES))
    innovations, motor_qd = np.empty((len(time), 12 + BIAS_STATES)), np.empty((len(time), 6))
    for rows, (mean, covariance), normalised in smooth(system, len(time)):
        state[rows], innovations[rows] = mean[:, 0] @ OUTPUTS_FROM_STATES.T, normalised[:, 0]
        motor_qd[rows] = mean[:, 0, 6:12]
        covariance = OUTPUTS_FROM_STATES @ covariance[:, 0] @ OUTPUTS_FROM_STATES.T
        std[rows] = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
    test = innovation_test(innovations, segment)
    widen(std[:, :MOTION_STATES], test, q)
    return SmoothedMotion(state, std, motor_qd, innovations, test, encoders.noise, noise)


def add_imu(joints: System, time: Array, readings: Array, model: Model, noise: Array) -> System:
    """Add an IMU's biases and readings to the joints, in one part; noise: (N, 6), their std."""
    step = np.diff(time, prepend=time[0])

    def part(rows: slice) -> LinearSystem:
        encoders, imu = joints(rows), model(rows)
        count, (begin, *_) = len(encoders.z), rows.indices(len(time))
        # motion as for the joints alone
        F, Q = np.zeros((2, count, ALL_STATES, ALL_STATES))
        F[:, :JOINT_STATES, :JOINT_STATES] = joint_matrix(encoders.F)
        Q[:, :JOINT_STATES, :JOINT_STATES] = joint_matrix(encoders.Q)
        # biases: random walk, unknown at the first sample
        F[:, JOINT_STATES:, JOINT_STATES:] = np.eye(BIAS_STATES)
        Q[:, JOINT_STATES:, JOINT_STATES:] = step[rows, None, None] * np.diag(BIAS_WALK**2)
        if begin == 0:
            F[0, JOINT_STATES:, JOINT_STATES:] = 0
            Q[0, JOINT_STATES:, JOINT_STATES:] = np.diag(BIAS_STD**2)
        # z = [encoders, readings - offset]
        H = np.zeros((count, 12 + BIAS_STATES, ALL_STATES))
        H[:, :12, :JOINT_STATES] = joint_matrix(encoders.H)
        H[:, 12:] = np.nan_to_num(imu.H) @ OUTPUTS_FROM_STATES
        z, R = (values.mT.reshape(count, 12) for values in (encoders.z, encoders.R))
        z = np.concatenate([z, readings[rows] - imu.offset], axis=1)
        R = np.concatenate([R, noise[rows] ** 2], axis=1)
        return LinearSystem(F[:, None], Q[:, None], H[:, None], z[:, None], R[:, None])

    return part


def joint_matrix(parts: Array) -> Array:
    """Return matrices (N, 6 A, 6 B) of independent joints (N, 6, A, B).

    The first six rows and columns belong to the first state of all joints, and so on.
    """
    count, joints, *size = parts.shape
    matrix = np.zeros((count, size[0], joints, size[1], joints))
    joint = np.arange(joints)
    matrix[:, :, joint, :, joint] = parts.swapaxes(0, 1)
    return matrix.reshape(count, joints * size[0], joints * size[1])


def imu_noise(time: Array, segment: Labels, residual: Array, explained: Array) -> Array:
    """Estimate the standard deviation of a sensor's readings around each sample, (N, M).

    residual: (N, M), readings minus the encoders' prediction, NaN where missing; explained: (N, M),
    variance of that prediction. Vibrations that the joints do not measure change with time;
    therefore the noise is estimated in a window around each sample: the mean square of the residual
    minus the explained variance, but at least the QUIET_WINDOW_SHARE quantile of all windows' mean
    squares.
    """
    # local mean square, less what the encoders' motion explains, at least that of quiet windows
    square = (residual - np.nanmedian(residual, axis=0)) ** 2
    count = round(IMU_WINDOW / float(np.median(np.diff(time))))
    square = moving_mean(square, segment, count)
    quietest = np.nanquantile(
        np.where(np.isfinite(residual), square, np.nan), QUIET_WINDOW_SHARE, axis=0
    )
    return np.sqrt(np.fmax(square - moving_mean(explained, segment, count), quietest))
