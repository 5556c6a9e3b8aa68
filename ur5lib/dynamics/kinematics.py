"""Poses, Jacobians, velocities and accelerations of points on the links, batched.

An arm has n joints. A point is (3,) [m] in the frame of a link, 1 to n; its origin if None. The
link is the last one where none is named. Six-vectors are linear,
then angular, base frame, unless said otherwise.
"""

import pytorch_kinematics as pk
import torch
from torch import Tensor
from torch.linalg import cross

from ur5lib.dynamics.arm import Arm
from ur5lib.dynamics.chains import serial_chain
from ur5lib.dynamics.orientation import zyz_angles, zyz_rates_to_angular_velocity

LAST = -1  # link of an arm


def link_frames(arm: Arm, q: Tensor) -> tuple[Tensor, Tensor]:
    """Return frames 0 (base) to n relative to the base (Equation 2.18).

    q: (N, n) [rad]. Returns rotations R_k (N, n + 1, 3, 3) and origins o_k (N, n + 1, 3) [m].
    """
    last = q.shape[1]
    poses = _chain(arm, last).forward_kinematics(q, end_only=False)
    matrices = torch.stack([poses[f"frame_{k}"].get_matrix() for k in range(last + 1)], dim=1)
    return matrices[..., :3, :3], matrices[..., :3, 3]


def jacobian(arm: Arm, q: Tensor, link: int = LAST, point: Tensor | None = None) -> Tensor:
    """Return the geometric Jacobian J_g of a point (Equations 2.27, 2.29 and 2.40).

    q: (N, n) [rad]. Returns (N, 6, n); columns of joints beyond the link are zero.
    """
    joints = q.shape[1]
    link = link % (joints + 1)
    columns = _chain(arm, link).jacobian(q[:, :link], locations=point)
    return torch.nn.functional.pad(columns, (0, joints - link))


def analytical_jacobian(
    arm: Arm, q: Tensor, link: int = LAST, point: Tensor | None = None
) -> Tensor:
    """Return J_a of a point: rows 1 to 3 of J_g, then the rates of φ, ϑ, ψ of R_k (Equation 2.34).

    q: (N, n) [rad]. Returns (N, 6, n). The last rows grow without bound towards sin ϑ = 0 and
    are infinite or not a number there: a singularity of the angles, not of the arm.
    """
    rotation, _ = link_frames(arm, q)
    rates = zyz_rates_to_angular_velocity(zyz_angles(rotation[:, link]))
    linear, angular = jacobian(arm, q, link, point).split(3, dim=1)
    return torch.cat([linear, torch.linalg.solve_ex(rates, angular).result], dim=1)


def velocity(
    arm: Arm, q: Tensor, qd: Tensor, link: int = LAST, point: Tensor | None = None
) -> Tensor:
    """Return J_g q̇ of a point, (N, 6) [m/s, rad/s] (2.26). q, qd: (N, n) [rad, rad/s]."""
    return _apply(jacobian(arm, q, link, point), qd)


def velocity_transformation(rotation: Tensor, lever: Tensor) -> Tensor:
    """Return what takes a body's velocity at frame i to frame j, each in its own axes (2.41).

    rotation: R_i^j (N, 3, 3), from the axes of i to those of j; lever: r_ij (N, 3) [m], from i to
    j, axes of i. Returns [R, -R S(r); 0, R], (N, 6, 6), of linear and angular velocities.
    """
    lever_cross = cross(lever[:, :, None], torch.eye(3).to(lever).expand_as(rotation), dim=1)
    upper = torch.cat([rotation, -rotation @ lever_cross], dim=2)
    return torch.cat([upper, torch.cat([torch.zeros_like(rotation), rotation], dim=2)], dim=1)


def acceleration(
    arm: Arm, q: Tensor, qd: Tensor, qdd: Tensor, link: int = LAST, point: Tensor | None = None
) -> Tensor:
    """Return J_g q̈ + J̇_g q̇ of a point, (N, 6) [m/s², rad/s²], without gravity.

    q, qd, qdd: (N, n) [rad, rad/s, rad/s²]. No angles, so no singularity of angles (erratum 1).
    """
    free = velocity_product_acceleration(arm, q, qd, link, point)
    return _apply(jacobian(arm, q, link, point), qdd) + free


def velocity_product_acceleration(
    arm: Arm, q: Tensor, qd: Tensor, link: int = LAST, point: Tensor | None = None
) -> Tensor:
    """Return J̇_g q̇ of a point, its acceleration at q̈ = 0, (N, 6) [m/s², rad/s²].

    q, qd: (N, n) [rad, rad/s].
    """
    rotation, origin = link_frames(arm, q)
    end = origin[:, link] if point is None else origin[:, link] + rotation[:, link] @ point
    omega, alpha, linear = torch.zeros(3, *origin[:, 0].shape).to(origin)
    link = link % (q.shape[1] + 1)
    for k in range(link):
        spin = rotation[:, k, :, 2] * qd[:, k, None]  # z_k turns joint k + 1
        alpha = alpha + cross(omega, spin)
        omega = omega + spin
        lever = (end if k + 1 == link else origin[:, k + 1]) - origin[:, k]
        linear = linear + cross(alpha, lever) + cross(omega, cross(omega, lever))
    return torch.cat([linear, alpha], dim=1)


def _chain(arm: Arm, link: int) -> pk.SerialChain:
    return serial_chain(arm.urdf, link, arm.gravity.dtype, arm.gravity.device)


def _apply(matrix: Tensor, vector: Tensor) -> Tensor:
    return (matrix @ vector[..., None])[..., 0]
