"""Forward kinematics and geometric Jacobians, batched."""

import torch
from torch import Tensor

from ur5lib.dynamics.arm import Arm


def link_frames(arm: Arm, q: Tensor) -> tuple[Tensor, Tensor]:
    """Frames 0 (base) to 6 seen from the base (Equation 2.18).

    q: (N, 6) [rad]. Returns rotations R_k (N, 7, 3, 3) and origins o_k (N, 7, 3) [m].
    """
    chain = arm.links[-1]
    poses = chain.forward_kinematics(q, end_only=False)
    matrices = torch.stack([poses[f"frame_{k}"].get_matrix() for k in range(7)], dim=1)
    return matrices[..., :3, :3], matrices[..., :3, 3]


def jacobian(arm: Arm, q: Tensor, link: int = 6, point: Tensor | None = None) -> Tensor:
    """Geometric Jacobian J_g of a link, base frame (Equations 2.27, 2.29 and 2.40).

    q: (N, 6) [rad]; link: 1 to 6; point: (3,) [m] in the link's frame, its origin if None.
    Returns (N, 6, 6): rows are linear, then angular velocity; joints beyond the link are zero.
    """
    columns = arm.links[link - 1].jacobian(q[:, :link], locations=point)
    return torch.nn.functional.pad(columns, (0, 6 - link))
