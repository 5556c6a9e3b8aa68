"""The regressor: joint torques as a linear function of the inertial parameters."""

from dataclasses import replace
from typing import Any

import torch
from torch import Tensor

from ur5lib.dynamics import recursion
from ur5lib.dynamics.arm import Arm
from ur5lib.dynamics.batches import evaluate
from ur5lib.dynamics.recursion import NO_WRENCH, components, link_inertia
from ur5lib.dynamics.tracing import Geometry, Number, stacked


def regressor(arm: Arm, q: Tensor, qd: Tensor, qdd: Tensor) -> Tensor:
    """Return Y(q, q̇, q̈) of τ = Y π, (N, n, 11 n), with π as in `Arm.parameters`.

    q, qd, qdd: (N, n) [rad, rad/s, rad/s²]. Of the arm, only its geometry matters.
    The first 10 n columns are those of Pinocchio's computeJointTorqueRegressor.
    Raises ValueError where states are not (N, n) of the same N, or not of the arm's precision.
    """
    plain = replace(arm, fused=False)  # thousands of operations would compile for minutes
    return evaluate(plain, _columns, q, qd, qdd)


def _columns(geometry: Geometry, parameters: Any, q: Any, qd: Any, qdd: Any) -> Any:
    """Return Y: the torques of links with one parameter equal to one and the others zero."""
    chain, joints = recursion.joints(geometry, q), geometry.joints
    rates = components(geometry, qd, qdd)
    columns: list[list[Number]] = []
    for k, motion in enumerate(recursion.link_motions(chain, geometry.gravity, *rates)):
        for unit in torch.eye(10).tolist():
            wrench = recursion.needed_wrench(link_inertia(unit), motion)
            torques = recursion.joint_torques(chain[: k + 1], [NO_WRENCH] * k + [wrench])
            columns.append(torques + [0.0 for _ in joints[k + 1 :]])
    columns += [[rates[1][k] if j == k else 0.0 for j in joints] for k in joints]
    return torch.stack([stacked([column[j] for column in columns], q[0]) for j in joints])
