"""Joint motion by an extended Kalman filter and a Rauch-Tung-Striebel smoother."""

from dataclasses import dataclass

import numpy as np
from filterpy.kalman import ExtendedKalmanFilter

from ur5lib.signals.imu_model import BIASES, MOTION, LinearImu
from ur5lib.signals.noise import (
    EncoderNoise,
    InnovationTest,
    encoder_noise,
    imu_noise,
    innovation_test,
    jerk_covariance,
)
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import starts

UNKNOWN = np.repeat([10.0, 10.0, 100.0], 6)  # rad, rad/s, rad/s²: a joint nothing is known of
BIAS = np.repeat([0.5, 0.1], 3)  # m/s², rad/s: what a sensor's bias may be
BIAS_WALK = np.repeat([1e-3, 1e-4], 3)  # m/s²/√s, rad/s/√s: and how it wanders


@dataclass(frozen=True)
class SmoothedMotion:
    """What all measurements tell of each moment, and how sure they are of it.

    state: (N, 18), q [rad], q̇ [rad/s], q̈ [rad/s²] side by side, or (N, 24) with the biases of
    accelerometer [m/s²] and gyroscope [rad/s]; covariance: (N, 18, 18) or (N, 24, 24).
    innovations: (N, M), normalised, of q, q̇ and the IMU, NaN where nothing was measured; test:
    what they say of the noise; encoders: noise; imu: (N, 6) noise of the readings, or None.
    """

    state: Array
    covariance: Array
    innovations: Array
    test: InnovationTest
    encoders: EncoderNoise
    imu: Array | None = None

    @property
    def q(self) -> Array:
        """(N, 6) [rad]."""
        return self.state[:, :6]

    @property
    def qd(self) -> Array:
        """(N, 6) [rad/s]."""
        return self.state[:, 6:12]

    @property
    def qdd(self) -> Array:
        """(N, 6) [rad/s²]."""
        return self.state[:, 12:18]

    @property
    def biases(self) -> Array:
        """Of accelerometer [m/s²] and gyroscope [rad/s], (N, 6); (N, 0) without them."""
        return self.state[:, MOTION:]

    @property
    def std(self) -> Array:
        """Standard deviations of the state, in its order and units."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))


@dataclass(frozen=True)
class LinearSystem:
    """x_k = F_k x_{k-1} + w, z_k = H_k x_k + v, of all samples at once.

    F, Q: (N, X, X), into each sample from the one before; H: (N, M, X); z: (N, M), NaN where
    nothing was measured; R: (N, M), variances.
    """

    F: Array
    Q: Array
    H: Array
    z: Array
    R: Array


def smooth_encoders(time: Array, segment: Labels, q: Array, qd: Array) -> SmoothedMotion:
    """Motion from joint positions and velocities alone.

    time: (N,) [s], increasing; segment: (N,) labels: nothing is carried from one to the next;
    q, qd: (N, 6) [rad, rad/s], NaN where missing. Raises ValueError where a joint has no data.
    """
    noise = encoder_noise(time, segment, q, qd)
    state, covariance, innovations = smooth(encoder_system(time, segment, q, qd, noise))
    return SmoothedMotion(
        state, covariance, innovations, innovation_test(innovations, segment), noise
    )


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


def encoder_system(
    time: Array, segment: Labels, q: Array, qd: Array, noise: EncoderNoise
) -> LinearSystem:
    """White jerk drives each joint; q is measured as it is, q̇ late: q̇ − lag q̈."""
    step = np.diff(time, prepend=time[0])
    steady, joint = np.eye(6), np.arange(6)
    F = np.kron(np.eye(3), steady) + np.zeros((len(time), 1, 1))
    F[:, :6, 6:12] = F[:, 6:12, 12:] = step[:, None, None] * steady
    F[:, :6, 12:] = step[:, None, None] ** 2 / 2 * steady
    driven_by_jerk = np.zeros((len(time), 3, 6, 3, 6))
    each = jerk_covariance(step)[:, :, :, None] * noise.jerk[:, None, None, :] ** 2
    driven_by_jerk[:, :, joint, :, joint] = each.transpose(3, 0, 1, 2)
    Q = driven_by_jerk.reshape(F.shape)
    # At its start a segment knows nothing of the one before.
    fresh = starts(segment)
    F[fresh], Q[fresh] = 0, np.diag(UNKNOWN**2)
    H = np.eye(12, MOTION)
    H[6:, 12:] = -np.diag(noise.lag)
    R = np.concatenate([noise.position, noise.velocity]) ** 2
    z = np.concatenate([q, qd], axis=1)
    return LinearSystem(F, Q, np.broadcast_to(H, (len(z), *H.shape)), z, np.tile(R, (len(z), 1)))


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


def smooth(system: LinearSystem) -> tuple[Array, Array, Array]:
    """States (N, X) given all measurements, covariances (N, X, X), normalised innovations (N, M).

    Raises numpy.linalg.LinAlgError where a state is known without error, which nothing is.
    """
    prior, posterior, innovations = _filter(system)
    return *_smooth_back(system.F, prior, posterior), innovations


def _filter(system: LinearSystem) -> tuple[list[Array], list[Array], Array]:
    """filterpy's EKF through all samples: priors, posteriors and innovations.

    Priors and posteriors are each a mean (N, X) and a covariance (N, X, X).
    """
    size = system.F.shape[2]
    ekf = ExtendedKalmanFilter(size, system.z.shape[1])
    ekf.x, ekf.P = np.zeros(size), np.zeros((size, size))
    prior, posterior = ([np.empty(system.F.shape[:2]), np.empty(system.F.shape)] for _ in range(2))
    innovations = np.full_like(system.z, np.nan)
    measured = np.isfinite(system.z)
    for k, seen in enumerate(measured):
        ekf.F, ekf.Q = system.F[k], system.Q[k]
        ekf.predict()
        prior[0][k], prior[1][k] = ekf.x, ekf.P
        if seen.any():
            H = system.H[k, seen]
            ekf.update(system.z[k, seen], lambda _, H=H: H, H.dot, R=np.diag(system.R[k, seen]))
            innovations[k, seen] = ekf.y / np.sqrt(np.diagonal(ekf.S))
        posterior[0][k], posterior[1][k] = ekf.x, ekf.P
    return prior, posterior, innovations


def _smooth_back(F: Array, prior: list[Array], posterior: list[Array]) -> tuple[Array, Array]:
    """Rauch, Tung and Striebel's pass from the last sample to the first."""
    state, covariance = posterior[0].copy(), posterior[1].copy()
    gain = np.linalg.solve(prior[1][1:], F[1:] @ covariance[:-1]).swapaxes(1, 2)
    for k in range(len(state) - 2, -1, -1):
        state[k] += gain[k] @ (state[k + 1] - prior[0][k + 1])
        covariance[k] += gain[k] @ (covariance[k + 1] - prior[1][k + 1]) @ gain[k].T
    return state, covariance
