"""Joint motion by a Kalman filter and a Rauch-Tung-Striebel smoother."""

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.linalg import solve_discrete_lyapunov

from ur5lib.smoothing.noise import EncoderNoise, encoder_noise, measures, motion_step, quantum
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.kalman import InnovationTest, LinearSystem, System, innovation_test, smooth
from ur5lib.timeseries.segments import starts

STATES_PER_JOINT = 6  # θ, θ̇, θ̈, δ, δ̇, δ̈
LINK_FROM_STATES = np.hstack([np.eye(3), np.eye(3)])  # [q, q̇, q̈] = this @ states
TIME_TICK = 1e-6  # s; steps of time are rounded to it, and none is shorter
TIME_DECIMALS = 6
UNIT_VIBRATION_STEP = 0.1  # time step of a vibration with ω = 1
# Standard deviations of q, q̇, q̈ [rad, rad/s, rad/s²] at the start of a segment.
INITIAL_STD = np.array([10.0, 10.0, 100.0])


@dataclass(frozen=True)
class SmoothedMotion:
    """State of n joints at each sample, given all measurements, with its standard deviations.

    state, std: (N, 3 n), q [rad], q̇ [rad/s], q̈ [rad/s²] side by side, or (N, 3 n + 6) with the
    biases of accelerometer [m/s²] and gyroscope [rad/s]; motor_qd: (N, n) [rad/s], velocities on
    the motor's side, without vibrations; innovations: (N, M), normalised, of q, q̇ and the IMU, NaN
    where nothing was measured; test: of the innovations; encoders: their noise; imu: (N, 6), noise
    of the IMU's readings, None without an IMU.
    """

    state: Array
    std: Array
    motor_qd: Array
    innovations: Array
    test: InnovationTest
    encoders: EncoderNoise
    imu: Array | None = None

    @property
    def joints(self) -> int:
        """Return the number of joints, n."""
        return self.motor_qd.shape[1]

    @property
    def q(self) -> Array:
        """Return the positions (N, n) [rad]."""
        return self.state[:, : self.joints]

    @property
    def qd(self) -> Array:
        """Return the velocities (N, n) [rad/s]."""
        return self.state[:, self.joints : 2 * self.joints]

    @property
    def qdd(self) -> Array:
        """Return the accelerations (N, n) [rad/s²]."""
        return self.state[:, 2 * self.joints : 3 * self.joints]


class KnownJoints(NamedTuple):
    """The joints' motion by the encoders alone, with which the fusion with an IMU begins.

    state, std: (N, 3 n), as in SmoothedMotion; shared: (N, n) [rad²/s³], covariance of q̇ and q̈;
    noise: of the encoders.
    """

    state: Array
    std: Array
    shared: Array
    noise: EncoderNoise


@dataclass(frozen=True)
class SmoothedJoints(SmoothedMotion):
    """A SmoothedMotion by encoders alone; shared: (N, n) [rad²/s³], covariance of q̇ and q̈."""

    shared: Array = field(kw_only=True)

    def known(self) -> KnownJoints:
        """Return the part of the motion that `smooth_with_imu` uses."""
        return KnownJoints(self.state, self.std, self.shared, self.encoders)


def smooth_encoders(
    time: Array, segment: Labels, q: Array, qd: Array, noise: EncoderNoise | None = None
) -> SmoothedJoints:
    """Estimate the motion from joint positions and velocities alone.

    time: (N,) [s], increasing; segment: (N,) labels, each smoothed on its own; q, qd: (N, n) [rad,
    rad/s], NaN where missing; noise: None: estimated from q and qd. Raises ValueError if a joint
    has no data.
    """
    noise = noise or encoder_noise(time, segment, q, qd)
    count, joints = q.shape
    state, std = np.empty((2, count, 3, joints))
    innovations, (shared, motor_qd) = np.empty((count, 2, joints)), np.empty((2, count, joints))
    for rows, states, normalised in smooth(encoder_system(time, segment, q, qd, noise), count):
        # x_link = [I I] [θ, δ]
        covariance = LINK_FROM_STATES @ states.covariance @ LINK_FROM_STATES.T
        state[rows], innovations[rows] = np.matvec(LINK_FROM_STATES, states.mean).mT, normalised.mT
        std[rows] = np.sqrt(np.diagonal(covariance, axis1=2, axis2=3)).mT
        shared[rows], motor_qd[rows] = covariance[:, :, 1, 2], states.mean[:, :, 1]
    flat = innovations.reshape(count, -1)
    test = innovation_test(flat, segment)
    shared *= widening(test, joints) ** 2
    state, std = state.reshape(count, -1), std.reshape(count, -1)
    widen(std, test, q)
    return SmoothedJoints(state, std, motor_qd, flat, test, noise, shared=shared)


def widen(std: Array, test: InnovationTest, q: Array) -> None:
    """Widen standard deviations (N, 3 n) in place, because errors are not white as assumed.

    Errors that last for several samples average out less than white ones, by the factor that the
    colour of a joint's innovations measures. A rounding error lasts as long as the joint rests.
    """
    joints = q.shape[1]
    std *= np.tile(widening(test, joints), 3)
    # an error anywhere within ± half a step: step / √12
    rounding = np.array([quantum(joint) for joint in q.T]) / np.sqrt(12)
    std[:, :joints] = np.hypot(std[:, :joints], rounding)


def widening(test: InnovationTest, joints: int) -> Array:
    """Return the factor (n,) on each joint's standard deviations; test: of innovations."""
    return np.sqrt(np.maximum(test.colour[:joints], test.colour[joints : 2 * joints]))


def encoder_system(
    time: Array, segment: Labels, q: Array, qd: Array, noise: EncoderNoise
) -> System:
    """Return the system of n independent joints, each with a motion θ and a vibration δ.

    x = [θ, θ̇, θ̈, δ, δ̇, δ̈], each driven by a jerk (`motion_step`); q = θ + δ is measured, and θ̇
    with a lag.
    """
    step, fresh, count = np.diff(time, prepend=time[0]), starts(segment), len(time)
    steps, which = np.unique(np.round(step, TIME_DECIMALS), return_inverse=True)
    steps = np.maximum(steps, TIME_TICK)[:, None]
    F_of, driven_of = motion_step(steps, noise.frequency, noise.damping)  # of each step and joint
    H_joint = measures(noise.lag)

    def part(rows: slice) -> LinearSystem:
        # x⁺ = F x + w, cov w = Q: what both jerks of each joint add
        F, driven = F_of[which[rows]].copy(), driven_of[which[rows]]
        intensity = np.stack([noise.jerk[rows], noise.vibration[rows]], axis=2)
        driven = driven * intensity[:, :, None]
        Q = driven @ driven.mT
        # a new segment starts the filter again
        first = np.flatnonzero(fresh[rows])
        F[first], Q[first] = 0, _initial_covariance(noise, first + rows.indices(count)[0])
        # z = [θ + δ, θ̇ − lag θ̈] + v, cov v = diag(R)
        z = np.stack([q[rows], qd[rows]], axis=2)  # (N, n, 2)
        R = np.stack([noise.position[rows], noise.velocity[rows]], axis=2) ** 2
        return LinearSystem(F, Q, np.broadcast_to(H_joint, (*z.shape, STATES_PER_JOINT)), z, R)

    return part


def _initial_covariance(noise: EncoderNoise, fresh: Labels) -> Array:
    """Return the covariances (N, n, 6, 6) of the joints' states at the starts of segments.

    A vibration has the covariance that its jerk sustains, P = F P Fᵀ + Q. It is solved for ω = 1
    and scaled: P of δ's k-th and l-th derivatives is proportional to ω^(k + l − 5).
    """
    covariance = np.zeros((len(fresh), len(noise.frequency), STATES_PER_JOINT, STATES_PER_JOINT))
    covariance[..., :3, :3] = np.diag(INITIAL_STD**2)
    for joint, (frequency, damping) in enumerate(zip(noise.frequency, noise.damping, strict=True)):
        F, driven = motion_step(UNIT_VIBRATION_STEP, 1.0, damping)
        # P = F P Fᵀ + Q for ω = 1
        unit = solve_discrete_lyapunov(F[3:, 3:], np.outer(driven[3:, 1], driven[3:, 1]))
        power = frequency ** (np.arange(3) - 2.5)
        intensity = noise.vibration[fresh, joint, None, None]
        covariance[:, joint, 3:, 3:] = unit * np.outer(power, power) * intensity**2
    return covariance
