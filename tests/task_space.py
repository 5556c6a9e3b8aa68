"""Inverse dynamics in task space (Equations 2.75 to 2.79), batched.

A pose X is (N, 6): position of frame n [m], then φ, ϑ, ψ [rad] (2.30). States are those of
`rigid_body`. At sin ϑ = 0 and where the arm is singular, results are infinite or not a number.
"""

import math

import torch
from torch import Tensor

from ur5lib.dynamics.arm import ArmTensors
from ur5lib.dynamics.kinematics import (
    analytical_jacobian,
    apply,
    link_frames,
    velocity_product_acceleration,
    zyz_angles,
    zyz_rates_to_angular_velocity,
)
from ur5lib.dynamics.rigid_body import inverse_dynamics


def pose(arm: ArmTensors, q: Tensor) -> Tensor:
    """Return X (N, 6) [m, rad] (Equation 2.30)."""
    rotation, origin = link_frames(arm, q)
    return torch.cat([origin[:, -1], zyz_angles(rotation[:, -1])], dim=1)


def pose_acceleration(arm: ArmTensors, q: Tensor, qd: Tensor, qdd: Tensor) -> Tensor:
    """Return Ẍ = J_a q̈ + J̇_a q̇ (N, 6) [m/s², rad/s²] (Equation 2.75)."""
    return apply(analytical_jacobian(arm, q), qdd) + drift(arm, q, qd)


def drift(arm: ArmTensors, q: Tensor, qd: Tensor) -> Tensor:
    """Return J̇_a q̇ (N, 6), the acceleration of X at q̈ = 0.

    Its angular part follows from ω = B φ̇ (2.33 corrected, erratum 1): φ̈ = B⁻¹ (α - Ḃ φ̇).
    """
    rotation, _ = link_frames(arm, q)
    angles, rates = zyz_angles(rotation[:, -1]), apply(analytical_jacobian(arm, q), qd)[:, 3:]
    B, B_rate = torch.func.jvp(zyz_rates_to_angular_velocity, (angles,), (rates,))[:2]
    linear, angular = velocity_product_acceleration(arm, q, qd).split(3, dim=1)
    return torch.cat([linear, _solve(B, angular - apply(B_rate, rates))], dim=1)


def joint_acceleration(arm: ArmTensors, q: Tensor, qd: Tensor, commanded: Tensor) -> Tensor:
    """Return a_q = J_a⁻¹ (a_X - J̇_a q̇) (N, 6) [rad/s²] (2.77); commanded: a_X (N, 6)."""
    return _solve(analytical_jacobian(arm, q), commanded - drift(arm, q, qd))


def task_space_torque(arm: ArmTensors, q: Tensor, qd: Tensor, commanded: Tensor) -> Tensor:
    """Return the torque (N, 6) [Nm] by which Ẍ = a_X (2.78): D a_q + C q̇ + g; commanded: a_X."""
    return inverse_dynamics(arm, q, qd, joint_acceleration(arm, q, qd, commanded))


def wanted_acceleration(
    arm: ArmTensors,
    q: Tensor,
    qd: Tensor,
    target: tuple[Tensor, Tensor, Tensor],
    gains: tuple[Tensor, Tensor],
) -> Tensor:
    """Return a_X = Ẍᵈ - K_0 X̃ - K_1 Ẋ̃ (N, 6) (Equation 2.79).

    target: Xᵈ, Ẋᵈ, Ẍᵈ, (N, 6) each; gains: diagonals of K_0 [1/s²] and K_1 [1/s], (6,) each. Errors
    of angles are the nearest ones, within ± π.
    """
    error = pose(arm, q) - target[0]
    angles = torch.remainder(error[:, 3:] + math.pi, 2 * math.pi) - math.pi
    error = torch.cat([error[:, :3], angles], dim=1)
    error_rate = apply(analytical_jacobian(arm, q), qd) - target[1]
    return target[2] - gains[0] * error - gains[1] * error_rate


def _solve(matrix: Tensor, vector: Tensor) -> Tensor:
    return torch.linalg.solve_ex(matrix, vector).result
