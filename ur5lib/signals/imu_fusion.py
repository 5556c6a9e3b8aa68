"""Joint motion from encoders and an IMU by a Kalman smoother."""

import numpy as np

from ur5lib.signals.imu_model import BIASES, LinearImu
from ur5lib.signals.noise import innovation_test, moving_mean
from ur5lib.signals.smoothing import MOTION, SmoothedMotion, encoder_system
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.kalman import LinearSystem, smooth

BIAS = np.repeat([0.5, 0.1], 3)  # m/s², rad/s: what a sensor's bias may be
BIAS_WALK = np.repeat([1e-3, 1e-4], 3)  # m/s²/√s, rad/s/√s: and how it wanders
IMU_WINDOW = 0.5  # s, over which the noise is taken as constant
QUIET = 0.05  # share of windows


def smooth_with_imu(
    time: Array,
    segment: Labels,
    q: Array,
    qd: Array,
    readings: Array,
    model: LinearImu,
    encoders: SmoothedMotion,
) -> SmoothedMotion:
    """Motion from joints and an IMU, whose biases are carried from segment to segment.

    As smooth_encoders, whose result `encoders` is; readings: (N, 6) specific force [m/s²] and
    angular rate [rad/s], NaN where missing; model: what they should be.
    """
    predicted, explained = model.predict(encoders.state, encoders.covariance)
    noise = imu_noise(time, segment, readings - predicted, explained)
    joints = encoder_system(time, segment, q, qd, encoders.encoders)
    system = add_imu(joints, time, readings, model, noise)
    state, covariance, innovations = smooth(system)
    test = innovation_test(innovations, segment)
    return SmoothedMotion(state, covariance, innovations, test, encoders.encoders, noise)


def add_imu(
    joints: LinearSystem, time: Array, readings: Array, model: LinearImu, noise: Array
) -> LinearSystem:
    """The joints' system with an IMU's biases and readings; noise: (N, 6), standard deviations."""
    states, rows = MOTION + BIASES, joints.z.shape[1]
    F, Q = (np.zeros((len(time), states, states)) for _ in range(2))
    F[:, :MOTION, :MOTION], Q[:, :MOTION, :MOTION] = joints.F, joints.Q
    F[1:, MOTION:, MOTION:] = np.eye(BIASES)
    Q[1:, MOTION:, MOTION:] = np.diff(time)[:, None, None] * np.diag(BIAS_WALK**2)
    Q[0, MOTION:, MOTION:] = np.diag(BIAS**2)
    H = np.zeros((len(time), rows + BIASES, states))
    H[:, :rows, :MOTION], H[:, rows:] = joints.H, np.nan_to_num(model.H)
    z = np.concatenate([joints.z, readings - model.offset], axis=1)
    return LinearSystem(F, Q, H, z, np.concatenate([joints.R, noise**2], axis=1))


def imu_noise(time: Array, segment: Labels, residual: Array, explained: Array) -> Array:
    """Standard deviation of a sensor's readings about each sample, (N, M).

    residual: (N, M), readings minus what the encoders predict, NaN where missing; explained:
    (N, M), variance of that prediction. An arm in motion shakes its sensor in ways its joints do
    not tell, so the noise changes with time: mean square in a window, less what is explained, and
    no less than in the quietest twentieth of all windows.
    """
    square = (residual - np.nanmedian(residual, axis=0)) ** 2
    count = round(IMU_WINDOW / float(np.median(np.diff(time))))
    square = moving_mean(square, segment, count)
    quietest = np.nanquantile(np.where(np.isfinite(residual), square, np.nan), QUIET, axis=0)
    return np.sqrt(np.fmax(square - moving_mean(explained, segment, count), quietest))
