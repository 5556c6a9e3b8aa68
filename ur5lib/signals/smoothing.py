"""Joint motion by a Kalman filter and a Rauch-Tung-Striebel smoother."""

from dataclasses import dataclass, field

import numpy as np

from ur5lib.signals.noise import (
    EncoderNoise,
    InnovationTest,
    encoder_noise,
    innovation_test,
    jerk_covariance,
)
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.kalman import LinearSystem, System, smooth
from ur5lib.timeseries.segments import starts

MOTION = 18  # entries of the motion: q, q̇, q̈
UNKNOWN = np.array([10.0, 10.0, 100.0])  # rad, rad/s, rad/s²: std at the start of a segment


@dataclass(frozen=True)
class SmoothedMotion:
    """State at each sample, given all measurements, with its standard deviations.

    state, std: (N, 18), q [rad], q̇ [rad/s], q̈ [rad/s²] side by side, or (N, 24) with the biases of
    accelerometer [m/s²] and gyroscope [rad/s]; innovations: (N, M), normalised, of q, q̇ and the
    IMU, NaN where nothing was measured; test: of the innovations; encoders: their noise; imu:
    (N, 6), noise of the readings, or None.
    """

    state: Array
    std: Array
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


@dataclass(frozen=True)
class SmoothedJoints(SmoothedMotion):
    """The same from the encoders alone; shared: (N, 6) [rad²/s³], covariance of q̇ and q̈."""

    shared: Array = field(kw_only=True)


def smooth_encoders(time: Array, segment: Labels, q: Array, qd: Array) -> SmoothedJoints:
    """Estimate the motion from joint positions and velocities alone.

    time: (N,) [s], increasing; segment: (N,) labels, each smoothed on its own; q, qd: (N, 6) [rad,
    rad/s], NaN where missing. Raises ValueError if a joint has no data.
    """
    noise = encoder_noise(time, segment, q, qd)
    count = len(time)
    state, std = np.empty((2, count, 3, 6))
    innovations, shared = np.empty((count, 2, 6)), np.empty((count, 6))
    for rows, (mean, covariance), off in smooth(encoder_system(time, segment, q, qd, noise), count):
        state[rows], innovations[rows] = mean.mT, off.mT
        std[rows] = np.sqrt(np.diagonal(covariance, axis1=2, axis2=3)).mT
        shared[rows] = covariance[:, :, 1, 2]
    flat = innovations.reshape(count, -1)
    both = state.reshape(count, -1), std.reshape(count, -1)
    return SmoothedJoints(*both, flat, innovation_test(flat, segment), noise, shared=shared)


def encoder_system(
    time: Array, segment: Labels, q: Array, qd: Array, noise: EncoderNoise
) -> System:
    """Return the system of six joints, each a part of its own: q, q̇, q̈, driven by a jerk.

    q is measured, and q̇ with a lag: q̇ − lag q̈.
    """
    step, fresh = np.diff(time, prepend=time[0]), starts(segment)
    measures = np.tile(np.eye(2, 3), (6, 1, 1))
    measures[:, 1, 2] = -noise.lag
    variance = np.stack([noise.position, noise.velocity], axis=1) ** 2

    def part(rows: slice) -> LinearSystem:
        own = step[rows]
        # F: q⁺ = q + T q̇ + T²/2 q̈, q̇⁺ = q̇ + T q̈, q̈⁺ = q̈
        F = np.tile(np.eye(3), (len(own), 6, 1, 1))
        F[:, :, 0, 1] = F[:, :, 1, 2] = own[:, None]
        F[:, :, 0, 2] = own[:, None] ** 2 / 2
        # Q: the covariance that the jerk of each joint adds to its q, q̇, q̈
        Q = jerk_covariance(own)[:, None] * noise.jerk[rows, :, None, None] ** 2
        # a new segment starts the filter again
        F[fresh[rows]], Q[fresh[rows]] = 0, np.diag(UNKNOWN**2)
        # z = [q, q̇ − lag q̈] + v, cov v = diag(R)
        z = np.stack([q[rows], qd[rows]], axis=2)  # (N, 6, 2)
        H = np.broadcast_to(measures, (*z.shape, 3))
        return LinearSystem(F, Q, H, z, np.broadcast_to(variance, z.shape))

    return part
