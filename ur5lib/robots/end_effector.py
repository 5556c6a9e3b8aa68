"""Velocity and acceleration of the end effector, from the joints and from the IMU."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.ndimage import gaussian_filter1d
from scipy.spatial.transform import Rotation

from ur5lib.robots.inertia import tensor
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.sampling import differentiate
from ur5lib.timeseries.segments import by_segment, in_chunks

MIN_GAUSSIAN_WIDTH = 0.1  # samples; a Gaussian below changes nothing


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


def felt_acceleration(
    rotation: Array, accelerometer: Array, angular_acceleration: Array, up: Array
) -> Array:
    """Return R a + g0 and R α (Equation 5.11, sign corrected: erratum 3), (N, 6), base frame.

    rotation: of the IMU's axes (N, 3, 3); accelerometer: (N, 3) [m/s²], without bias;
    angular_acceleration: (N, 3) [rad/s²], the gyroscope's derivative; up: -g0 (3,) [m/s²].
    """
    linear = np.matvec(rotation, accelerometer) - up
    return np.concatenate([linear, np.matvec(rotation, angular_acceleration)], axis=1)


@dataclass(frozen=True)
class ToolMotion:
    """Weight and acceleration of a body fixed to frame 6, in the axes of this frame, (N, 3) each.

    pull: R_6ᵀ (g - a) [m/s²] at the origin, force per mass; rate: ω [rad/s]; spin: its derivative α
    [rad/s²].
    """

    pull: Array
    rate: Array
    spin: Array

    def pull_at(self, point: Array) -> Array:
        """Return p - α × r - ω × (ω × r) (N, 3) [m/s²] at a point r (3,) [m] of frame 6."""
        centripetal = np.cross(self.rate, np.cross(self.rate, point))
        return self.pull - np.cross(self.spin, point) - centripetal

    def gyration(self, inertia: Sequence[float]) -> Array:
        """Return I α + ω × I ω (N, 3) [Nm].

        inertia: xx yy zz xy xz yz [kg m²] about the centre of mass, axes of frame 6.
        """
        about = tensor(inertia)
        return self.spin @ about + np.cross(self.rate, self.rate @ about)


def tool_motion(
    rotation: Array, jacobian: Array, qd: Array, qdd: Array, gravity: Array
) -> ToolMotion:
    """Return the motion of frame 6 in its own axes.

    rotation: R_6 (N, 3, 3); jacobian: J_g (N, 6, 6); qd [rad/s], qdd [rad/s²]: (N, 6); gravity:
    (3,) [m/s²], base frame.
    """

    def felt(rotation: Array, jacobian: Array, qd: Array, qdd: Array) -> Array:
        moved = point_acceleration(rotation, jacobian, qd, qdd, np.zeros(3))
        rate = np.matvec(jacobian[:, 3:], qd)
        parts = np.stack([gravity - moved[:, :3], rate, moved[:, 3:]], axis=1)
        return parts @ rotation  # each row times R_6, that is R_6ᵀ v

    return ToolMotion(*in_chunks(felt, rotation, jacobian, qd, qdd).swapaxes(0, 1))


def expected_values(values: Array, segment: Labels, period: float, clock_std: float) -> Array:
    """Return the expectation of values (N, M) at times with a normal error: a Gaussian filter.

    clock_std: standard error of the times [s]. Motion faster than the clock's error, such as a
    vibration, has an expectation of zero: subtracting it unfiltered would add noise.
    """
    width = clock_std / period
    if width < MIN_GAUSSIAN_WIDTH:
        return values
    return by_segment(
        partial(gaussian_filter1d, sigma=width, axis=0, mode="nearest"), values, segment
    )


def euler_acceleration(
    rotation: Array,
    jacobian: Array,
    qd: Array,
    qdd: Array,
    segment: Labels,
    period: float,
    printed: bool,
) -> Array:
    """Return Ẍ = J_a q̈ + J̇_a q̇ (Equation 2.35), with the second derivatives of φ, ϑ, ψ last.

    rotation: R_6 (N, 3, 3); jacobian: J_g (N, 6, 6), base frame; qd, qdd: (N, 6) [rad/s, rad/s²];
    segment: (N,) labels; period: [s]; printed: whether φ and ψ are exchanged as in the printed
    Equation 2.33 (erratum 1). Returns (N, 6) [m/s², rad/s²]. It peaks near ϑ = 0 and ϑ = π, the
    singularities of the angles, whether the arm accelerates or not.
    """
    # J_a = [J_v; B⁻¹ J_w]
    phi, theta, psi = Rotation.from_matrix(rotation).as_euler("ZYZ").T
    rates = _rates_to_angular_velocity(psi if printed else phi, theta)
    angular = np.linalg.solve(rates, jacobian[:, 3:])
    analytical = np.concatenate([jacobian[:, :3], angular], axis=1)  # (N, 6, 6)
    # J̇_a by central differences
    columns = analytical.reshape(-1, 36)
    analytical_rate = by_segment(differentiate, columns, segment, period).reshape(-1, 6, 6)
    return np.einsum("nij,nj->ni", analytical, qdd) + np.einsum("nij,nj->ni", analytical_rate, qd)


def _rates_to_angular_velocity(first: Array, theta: Array) -> Array:
    """Return B (N, 3, 3) of ω = B (φ̇, ϑ̇, ψ̇) (Equation 2.33); `first` is φ if it is correct."""
    zero, one = np.zeros_like(theta), np.ones_like(theta)
    rows = [
        [zero, -np.sin(first), np.cos(first) * np.sin(theta)],
        [zero, np.cos(first), np.sin(first) * np.sin(theta)],
        [one, zero, np.cos(theta)],
    ]
    return np.moveaxis(np.array(rows), -1, 0)
