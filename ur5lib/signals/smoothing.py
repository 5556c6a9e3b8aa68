"""Joint motion by an extended Kalman filter and a Rauch-Tung-Striebel smoother."""

from dataclasses import dataclass

import numpy as np

from ur5lib.signals.noise import (
    EncoderNoise,
    InnovationTest,
    encoder_noise,
    innovation_test,
    jerk_covariance,
)
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.kalman import LinearSystem, smooth
from ur5lib.timeseries.segments import starts

MOTION = 18  # entries of the state: q, q̇, q̈
UNKNOWN = np.repeat([10.0, 10.0, 100.0], 6)  # rad, rad/s, rad/s²: std at the start of a segment


@dataclass(frozen=True)
class SmoothedMotion:
    """State at each sample, given all measurements, with its covariance.

    state: (N, 18), q [rad], q̇ [rad/s], q̈ [rad/s²] side by side, or (N, 24) with the biases of
    accelerometer [m/s²] and gyroscope [rad/s]; covariance: (N, 18, 18) or (N, 24, 24);
    innovations: (N, M), normalised, of q, q̇ and the IMU, NaN where nothing was measured; test: of
    the innovations; encoders: their noise; imu: (N, 6), noise of the readings, or None.
    """

    state: Array
    covariance: Array
    innovations: Array
    test: InnovationTest
    encoders: EncoderNoise
    imu: Array | None = None

    @property
    def q(self) -> Array:
        """Return the positions (N, 6) [rad]."""
        return self.state[:, :6]

    @property
    def qd(self) -> Array:
        """Return the velocities (N, 6) [rad/s]."""
        return self.state[:, 6:12]

    @property
    def qdd(self) -> Array:
        """Return the accelerations (N, 6) [rad/s²]."""
        return self.state[:, 12:18]

    @property
    def biases(self) -> Array:
        """Return the biases of accelerometer [m/s²] and gyroscope [rad/s], (N, 6); else (N, 0)."""
        return self.state[:, MOTION:]

    @property
    def std(self) -> Array:
        """Return the standard deviations of the state, in its order and units."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2))


def smooth_encoders(time: Array, segment: Labels, q: Array, qd: Array) -> SmoothedMotion:
    """Estimate the motion from joint positions and velocities alone.

    time: (N,) [s], increasing; segment: (N,) labels, each smoothed on its own; q, qd: (N, 6) [rad,
    rad/s], NaN where missing. Raises ValueError if a joint has no data.
    """
    noise = encoder_noise(time, segment, q, qd)
    state, covariance, innovations = smooth(encoder_system(time, segment, q, qd, noise))
    return SmoothedMotion(
        state, covariance, innovations, innovation_test(innovations, segment), noise
    )


def encoder_system(
    time: Array, segment: Labels, q: Array, qd: Array, noise: EncoderNoise
) -> LinearSystem:
    """Return the system of a jerk on each joint; q is measured, and q̇ with a lag: q̇ − lag q̈."""
    step = np.diff(time, prepend=time[0])
    steady, joint = np.eye(6), np.arange(6)
    # F: q⁺ = q + T q̇ + T²/2 q̈, q̇⁺ = q̇ + T q̈, q̈⁺ = q̈
    F = np.kron(np.eye(3), steady) + np.zeros((len(time), 1, 1))  # (N, 18, 18)
    F[:, :6, 6:12] = F[:, 6:12, 12:] = step[:, None, None] * steady
    F[:, :6, 12:] = step[:, None, None] ** 2 / 2 * steady
    # Q: the covariance that the jerk of each joint adds to its q, q̇, q̈
    driven_by_jerk = np.zeros((len(time), 3, 6, 3, 6))
    each = jerk_covariance(step)[:, :, :, None] * noise.jerk[:, None, None, :] ** 2  # (N, 3, 3, 6)
    driven_by_jerk[:, :, joint, :, joint] = each.transpose(3, 0, 1, 2)
    Q = driven_by_jerk.reshape(F.shape)
    # a new segment starts the filter again
    fresh = starts(segment)
    F[fresh], Q[fresh] = 0, np.diag(UNKNOWN**2)
    # z = [q, q̇ − lag q̈] + v, cov v = diag(R)
    H = np.eye(12, MOTION)
    H[6:, 12:] = -np.diag(noise.lag)
    R = np.concatenate([noise.position, noise.velocity]) ** 2
    z = np.concatenate([q, qd], axis=1)
    return LinearSystem(F, Q, np.broadcast_to(H, (len(z), *H.shape)), z, np.tile(R, (len(z), 1)))
