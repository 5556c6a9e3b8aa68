"""Rotation matrices as ZYZ Euler angles and as axis and angle, batched (Equations 2.1 to 2.10)."""

import pytorch_kinematics as pk
import torch
from torch import Tensor


def zyz_angles(rotation: Tensor) -> Tensor:
    """Return φ, ϑ, ψ of R = R_z(φ) R_y(ϑ) R_z(ψ), 0 ≤ ϑ ≤ π (Equations 2.4 to 2.7).

    rotation: (N, 3, 3). Returns (N, 3) [rad]. Where sin ϑ is zero to rounding, φ = 0.
    """
    x, y = rotation[:, 0, 2], rotation[:, 1, 2]  # sin ϑ (cos φ, sin φ)
    sine = torch.hypot(x, y)
    phi = torch.where(sine > 4 * torch.finfo(sine.dtype).eps, torch.atan2(y, x), 0.0)
    c, s = torch.cos(phi)[:, None], torch.sin(phi)[:, None]
    turned = c * rotation[:, 1] - s * rotation[:, 0]  # second row of R_y R_z: sin ψ, cos ψ, 0
    theta = torch.atan2(sine, rotation[:, 2, 2])
    return torch.stack([phi, theta, torch.atan2(turned[:, 0], turned[:, 1])], dim=1)


def zyz_rates_to_angular_velocity(angles: Tensor) -> Tensor:
    """Return B(φ) of ω = B (φ̇, ϑ̇, ψ̇), base frame: Equation 2.33 corrected (erratum 1).

    angles: (N, 3) [rad] as from `zyz_angles`. Returns (N, 3, 3), singular where sin ϑ = 0.
    """
    phi, theta, _ = angles.unbind(1)
    zero, one = torch.zeros_like(phi), torch.ones_like(phi)
    rows = [
        [zero, -torch.sin(phi), torch.cos(phi) * torch.sin(theta)],
        [zero, torch.cos(phi), torch.sin(phi) * torch.sin(theta)],
        [one, zero, torch.cos(theta)],
    ]
    return torch.stack([torch.stack(row, dim=1) for row in rows], dim=1)


def axis_angle(rotation: Tensor) -> tuple[Tensor, Tensor]:
    """Return unit axis l (N, 3) and angle λ (N,) [rad], 0 ≤ λ ≤ π, of R (N, 3, 3) (2.9, 2.10).

    By quaternions, which lose nothing near λ = 0 and λ = π. There, Equation 2.10 divides by zero:
    at λ = π, l and -l are the same rotation; at λ = 0 any axis would do, and l = z.
    """
    quaternion = pk.matrix_to_quaternion(rotation)  # cos(λ/2), l sin(λ/2)
    quaternion = torch.where(quaternion[:, :1] < 0, -quaternion, quaternion)
    sine = quaternion[:, 1:].norm(dim=1, keepdim=True)
    z = rotation.new_tensor([0.0, 0.0, 1.0])
    axis = torch.where(sine > 0, quaternion[:, 1:] / sine, z)
    return axis, 2 * torch.atan2(sine[:, 0], quaternion[:, 0])
