"""End-effector acceleration through Euler angles, as in the thesis: for comparison only."""

from functools import partial

import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.derivative import differentiate
from ur5lib.timeseries.segments import by_segment


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
    change = partial(by_segment, partial(differentiate, period=period), segment=segment)
    analytical_rate = change(values=analytical.reshape(-1, 36)).reshape(-1, 6, 6)
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
