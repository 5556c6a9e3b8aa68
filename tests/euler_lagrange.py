"""The equations of motion as the thesis derives them: from energies, by Jacobians, batched.

The second derivation; `rigid_body` computes the same faster, by Newton and Euler.
"""

import torch
from torch import Tensor
from torch.func import jvp

from ur5lib.dynamics.arm import ArmTensors
from ur5lib.dynamics.kinematics import jacobian, link_frames


def inertia_matrix(arm: ArmTensors, q: Tensor) -> Tensor:
    """Return D(q) = Σ m J_vᵀ J_v + J_ωᵀ R I Rᵀ J_ω over links, plus rotors (Equation 2.61).

    q: (N, n) [rad]. Returns (N, n, n) [kg m²], symmetric and positive definite.
    """
    rotation, _ = link_frames(arm, q)
    total = torch.diag(arm.rotor_inertia).repeat(len(q), 1, 1)
    for k in range(q.shape[1]):
        columns = jacobian(arm, q, link=k + 1, point=arm.center_of_mass[k])
        linear, angular = columns[:, :3], columns[:, 3:]
        inertia = rotation[:, k + 1] @ arm.inertia[k] @ rotation[:, k + 1].mT
        total += arm.mass[k] * linear.mT @ linear + angular.mT @ inertia @ angular
    return total


def coriolis_matrix(arm: ArmTensors, q: Tensor, qd: Tensor) -> Tensor:
    """Return C(q, q̇) by the Christoffel symbols (2.65, 2.66) of exact derivatives of D.

    q, qd: (N, n) [rad, rad/s]. Returns (N, n, n) [Nm s/rad].
    """

    def inertia(q: Tensor) -> Tensor:
        return inertia_matrix(arm, q)

    units = torch.eye(q.shape[1], dtype=q.dtype, device=q.device)
    slopes = [jvp(inertia, (q,), (unit.expand_as(q),))[1] for unit in units]
    slope = torch.stack(slopes, dim=1)  # ∂d_kj/∂q_i as (N, i, k, j)
    # c_kj = ½ Σ_i (∂d_kj/∂q_i + ∂d_ki/∂q_j - ∂d_ij/∂q_k) q̇_i
    along = torch.einsum("nikj,ni->nkj", slope, qd)
    across = torch.einsum("njki,ni->nkj", slope, qd)
    return (along + across - across.mT) / 2


def gravity_torque(arm: ArmTensors, q: Tensor) -> Tensor:
    """Return g(q) = ∂P/∂q = -Σ m J_vᵀ g0, with P = -Σ m g0ᵀ r (Equation 2.67, erratum 2).

    q: (N, n) [rad]. Returns (N, n) [Nm].
    """
    total = torch.zeros_like(q)
    for k in range(q.shape[1]):
        columns = jacobian(arm, q, link=k + 1, point=arm.center_of_mass[k])
        total -= arm.mass[k] * columns[:, :3].mT @ arm.gravity
    return total
