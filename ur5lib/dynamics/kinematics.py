"""Poses, orientations, Jacobians, velocities and accelerations of points on the links, batched.

An arm has n joints. A point is (3,) [m] in the frame of a link, 1 to n; None: its origin. Without a
named link, it is the last one. Six-vectors are linear, then angular, base frame, unless stated
otherwise. Importing this takes half as long as importing torch, because of the plotting packages of
pytorch-kinematics: modules that need no poses do not import it.
"""

from functools import cache
from xml.etree import ElementTree

import pytorch_kinematics as pk
import torch
from torch import Tensor
from torch.linalg import cross

from ur5lib.dynamics.arm import ArmTensors

LAST_LINK = -1  # index of an arm's last link


@cache
def serial_chain(text: str, link: int, dtype: torch.dtype, device: torch.device) -> pk.SerialChain:
    """Return the chain from the base to frame k of a link, 1 to n, of an arm as URDF."""
    chain = pk.SerialChain(read_urdf(text, dtype), f"frame_{link}", dtype=dtype)
    return chain.to(device=device)


def read_urdf(text: str, dtype: torch.dtype) -> pk.Chain:
    """Read a kinematic chain from URDF, with the origins of its joints in full precision.

    pytorch-kinematics reads rotations in single precision, which misplaces the UR5's flange by
    16 nm; the exact origins are put back here. The chain is a template for `pk.SerialChain`.
    """
    chain = pk.build_chain_from_urdf(text.encode())
    for name in chain.get_frame_names(exclude_fixed=False):
        chain.find_frame(name).link.offset = None  # places the link's drawing, in single precision
    for joint in ElementTree.fromstring(text).iter("joint"):
        child, origin = (joint.findall(name)[0].attrib for name in ("child", "origin"))
        frame = chain.find_frame(child["link"])
        frame.joint.offset = _transform(origin["xyz"], origin["rpy"], dtype)
    return chain


def _transform(xyz: str, rpy: str, dtype: torch.dtype) -> pk.Transform3d:
    position, angles = (
        torch.tensor([float(value) for value in text.split()], dtype=torch.float64)
        for text in (xyz, rpy)
    )
    # About fixed axes: R = R_z(yaw) R_y(pitch) R_x(roll).
    rotation = pk.euler_angles_to_matrix(angles.flip(0), "ZYX")
    return pk.Transform3d(rot=rotation.to(dtype), pos=position.to(dtype), dtype=dtype)


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


def link_frames(arm: ArmTensors, q: Tensor) -> tuple[Tensor, Tensor]:
    """Return frames 0 (base) to n relative to the base (Equation 2.18).

    q: (N, n) [rad]. Returns rotations R_k (N, n + 1, 3, 3) and origins o_k (N, n + 1, 3) [m].
    """
    last = q.shape[1]
    poses = _chain(arm, last).forward_kinematics(q, end_only=False)
    matrices = torch.stack([poses[f"frame_{k}"].get_matrix() for k in range(last + 1)], dim=1)
    return matrices[..., :3, :3], matrices[..., :3, 3]


def jacobian(
    arm: ArmTensors, q: Tensor, link: int = LAST_LINK, point: Tensor | None = None
) -> Tensor:
    """Return the geometric Jacobian J_g of a point (Equations 2.27, 2.29 and 2.40).

    q: (N, n) [rad]. Returns (N, 6, n); columns of joints beyond the link are zero.
    """
    joints = q.shape[1]
    link = link % (joints + 1)
    columns = _chain(arm, link).jacobian(q[:, :link], locations=point)
    return torch.nn.functional.pad(columns, (0, joints - link))


def analytical_jacobian(arm: ArmTensors, q: Tensor) -> Tensor:
    """Return J_a of frame n: rows 1 to 3 of J_g, then the rates of φ, ϑ, ψ of R_n (Equation 2.34).

    q: (N, n) [rad]. Returns (N, 6, n). The last rows grow without bound towards sin ϑ = 0 and
    are infinite or not a number there: a singularity of the angles, not of the arm.
    """
    rotation, _ = link_frames(arm, q)
    rates = zyz_rates_to_angular_velocity(zyz_angles(rotation[:, LAST_LINK]))
    linear, angular = jacobian(arm, q).split(3, dim=1)
    return torch.cat([linear, torch.linalg.solve_ex(rates, angular).result], dim=1)


def velocity(
    arm: ArmTensors, q: Tensor, qd: Tensor, link: int = LAST_LINK, point: Tensor | None = None
) -> Tensor:
    """Return J_g q̇ of a point, (N, 6) [m/s, rad/s] (2.26). q, qd: (N, n) [rad, rad/s]."""
    return apply(jacobian(arm, q, link, point), qd)


def acceleration(
    arm: ArmTensors,
    q: Tensor,
    qd: Tensor,
    qdd: Tensor,
    link: int = LAST_LINK,
    point: Tensor | None = None,
) -> Tensor:
    """Return J_g q̈ + J̇_g q̇ of a point, (N, 6) [m/s², rad/s²], without gravity.

    q, qd, qdd: (N, n) [rad, rad/s, rad/s²]. No angles, so no singularity of angles (erratum 1).
    """
    free_acceleration = velocity_product_acceleration(arm, q, qd, link, point)
    return apply(jacobian(arm, q, link, point), qdd) + free_acceleration


def velocity_product_acceleration(
    arm: ArmTensors, q: Tensor, qd: Tensor, link: int = LAST_LINK, point: Tensor | None = None
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


def _chain(arm: ArmTensors, link: int) -> pk.SerialChain:
    return serial_chain(arm.urdf, link, arm.gravity.dtype, arm.gravity.device)


def apply(matrix: Tensor, vector: Tensor) -> Tensor:
    """Return matrices (N, m, n) times vectors (N, n)."""
    return (matrix @ vector[..., None])[..., 0]
