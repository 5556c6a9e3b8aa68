"""Inverse dynamics, inertia matrix and gravity torque of an arm, batched."""

import torch
from torch import Tensor
from torch.linalg import cross

from ur5lib.dynamics.arm import Arm
from ur5lib.dynamics.kinematics import jacobian, link_frames


def inverse_dynamics(arm: Arm, q: Tensor, qd: Tensor, qdd: Tensor) -> Tensor:
    """Joint torques tau = D(q) qdd + C(q, qd) qd + g(q) (Equation 2.64).

    q, qd, qdd: (N, 6) [rad, rad/s, rad/s²]. Returns (N, 6) [Nm].
    Recursive Newton-Euler, every vector in base axes; gravity enters as the base's acceleration.
    """
    rotation, origin = link_frames(arm, q)
    axis = rotation[..., 2]  # z_k turns joint k + 1
    center = (rotation[:, 1:] @ arm.center_of_mass[:, :, None])[..., 0]  # seen from o_k
    inertia = rotation[:, 1:] @ arm.inertia @ rotation[:, 1:].mT

    omega = torch.zeros_like(origin[:, 0])
    alpha = torch.zeros_like(omega)
    acceleration = torch.zeros_like(omega) - arm.gravity  # of o_k
    forces, moments = [], []
    for k in range(6):
        spin = axis[:, k] * qd[:, k, None]
        alpha = alpha + axis[:, k] * qdd[:, k, None] + cross(omega, spin)
        omega = omega + spin
        acceleration = acceleration + _rotating(origin[:, k + 1] - origin[:, k], omega, alpha)
        center_acceleration = acceleration + _rotating(center[:, k], omega, alpha)
        forces.append(arm.mass[k] * center_acceleration)
        moments.append(_apply(inertia[:, k], alpha) + cross(omega, _apply(inertia[:, k], omega)))

    torque = torch.empty_like(q)
    force, moment = torch.zeros_like(omega), torch.zeros_like(omega)  # on link k, about o_k
    for k in reversed(range(6)):
        lever = origin[:, k + 1] - origin[:, k]
        moment = moment + moments[k] + cross(center[:, k], forces[k])
        force = force + forces[k]
        moment = moment + cross(lever, force)  # now about o_(k-1)
        torque[:, k] = (axis[:, k] * moment).sum(-1)
    return torque


def inertia_matrix(arm: Arm, q: Tensor) -> Tensor:
    """D(q) of Equation 2.61: the sum of m J_v^T J_v + J_w^T R I R^T J_w over the links.

    q: (N, 6) [rad]. Returns (N, 6, 6) [kg m²], symmetric and positive definite.
    """
    rotation, _ = link_frames(arm, q)
    total = q.new_zeros(len(q), 6, 6)
    for k in range(6):
        columns = jacobian(arm, q, link=k + 1, point=arm.center_of_mass[k])
        linear, angular = columns[:, :3], columns[:, 3:]
        inertia = rotation[:, k + 1] @ arm.inertia[k] @ rotation[:, k + 1].mT
        total += arm.mass[k] * linear.mT @ linear + angular.mT @ inertia @ angular
    return total


def gravity_torque(arm: Arm, q: Tensor) -> Tensor:
    """g(q) of Equation 2.67, with P = -sum m g0^T r (erratum 2): g = -sum m J_v^T g0.

    q: (N, 6) [rad]. Returns (N, 6) [Nm].
    """
    total = torch.zeros_like(q)
    for k in range(6):
        columns = jacobian(arm, q, link=k + 1, point=arm.center_of_mass[k])
        total -= arm.mass[k] * columns[:, :3].mT @ arm.gravity
    return total


def _rotating(lever: Tensor, omega: Tensor, alpha: Tensor) -> Tensor:
    """Acceleration of a lever's end relative to its start on a turning body, (N, 3)."""
    return cross(alpha, lever) + cross(omega, cross(omega, lever))


def _apply(matrix: Tensor, vector: Tensor) -> Tensor:
    return (matrix @ vector[..., None])[..., 0]
