"""Joint motion from encoders and an IMU by a Kalman smoother."""

import numpy as np

from ur5lib.signals.imu_model import BIASES, LinearImu
from ur5lib.signals.noise import innovation_test, moving_mean
from ur5lib.signals.smoothing import MOTION, SmoothedMotion, encoder_system
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.kalman import LinearSystem, smooth

BIAS = np.repeat([0.5, 0.1], 3)  # m/s², rad/s: prior standard deviation of the biases
BIAS_WALK = np.repeat([1e-3, 1e-4], 3)  # m/s²/√s, rad/s/√s: their random walk
IMU_WINDOW = 0.5  # s, over which the noise is taken as constant
QUIET = 0.05  # share of windows, the quietest


def smooth_with_imu(
    time: Array,
    segment: Labels,
    q: Array,
    qd: Array,
    readings: Array,
    model: LinearImu,
    encoders: SmoothedMotion,
) -> SmoothedMotion:
    """Estimate the motion from joints and an IMU, whose biases continue across segments.

    Arguments as in smooth_encoders; readings: (N, 6) specific force [m/s²] and angular rate
    [rad/s], NaN where missing; model: the IMU's equation; encoders: result of smooth_encoders.
    """
    # local noise of the IMU from its residuals under the encoders' motion
    predicted, explained = model.predict(encoders.state, encoders.covariance)
    noise = imu_noise(time, segment, readings - predicted, explained)
    # smoother of q, q̇, q̈ and both biases
    joints = encoder_system(time, segment, q, qd, encoders.encoders)
    system = add_imu(joints, time, readings, model, noise)
    state, covariance, innovations = smooth(system)
    test = innovation_test(innovations, segment)
    return SmoothedMotion(state, covariance, innovations, test, encoders.encoders, noise)


def add_imu(
    joints: LinearSystem, time: Array, readings: Array, model: LinearImu, noise: Array
) -> LinearSystem:
    """Add an IMU's biases and readings to the joints' system; noise: (N, 6), their std."""
    states, rows = MOTION + BIASES, joints.z.shape[1]
    # motion as for the joints alone
    F, Q = (np.zeros((len(time), states, states)) for _ in range(2))  # (N, 24, 24)
    F[:, :MOTION, :MOTION], Q[:, :MOTION, :MOTION] = joints.F, joints.Q
    # biases: random walk, unknown at the first sample
    F[1:, MOTION:, MOTION:] = np.eye(BIASES)
    Q[1:, MOTION:, MOTION:] = np.diff(time)[:, None, None] * np.diag(BIAS_WALK**2)
    Q[0, MOTION:, MOTION:] = np.diag(BIAS**2)
    # z = [encoders, readings - offset]
    H = np.zeros((len(time), rows + BIASES, states))  # (N, 18, 24)
    H[:, :rows, :MOTION], H[:, rows:] = joints.H, np.nan_to_num(model.H)
    z = np.concatenate([joints.z, readings - model.offset], axis=1)
    return LinearSystem(F, Q, H, z, np.concatenate([joints.R, noise**2], axis=1))


def imu_noise(time: Array, segment: Labels, residual: Array, explained: Array) -> Array:
    """Estimate the standard deviation of a sensor's readings around each sample, (N, M).

    residual: (N, M), readings minus the encoders' prediction, NaN where missing; explained: (N, M),
    variance of that prediction. Vibration that the joints do not measure changes with time, so the
    noise is local: mean square in a window minus the explained variance, and at least that of the
    quietest twentieth of all windows.
    """
    square = (residual - np.nanmedian(residual, axis=0)) ** 2
    count = round(IMU_WINDOW / float(np.median(np.diff(time))))
    square = moving_mean(square, segment, count)
    quietest = np.nanquantile(np.where(np.isfinite(residual), square, np.nan), QUIET, axis=0)
    return np.sqrt(np.fmax(square - moving_mean(explained, segment, count), quietest))
