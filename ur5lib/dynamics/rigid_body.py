"""The equations of motion (2.64) of an arm, batched: by Newton and Euler, with composite bodies.

All are functions of an arm of n joints and of states (N, n): q [rad], qd [rad/s], qdd [rad/s²],
torque [Nm]. They are differentiable in the states and in the arm's `parameters`. Raises ValueError
where states are not (N, n) of the same N, or not of the arm's precision.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import torch
from torch import Tensor

from ur5lib.dynamics import recursion
from ur5lib.dynamics.arm import ArmTensors, batch_size, evaluate, in_batches
from ur5lib.dynamics.recursion import (
    NO_WRENCH,
    ZERO_VECTOR,
    Inertia,
    LinkMotion,
    LinkWrench,
    components,
    link_inertia,
    split,
)
from ur5lib.dynamics.tracing import Geometry, Number, stacked, straight_line

UNIT_TURN = LinkMotion(
    ZERO_VECTOR, (0.0, 0.0, 1.0), ZERO_VECTOR, recursion.turning(ZERO_VECTOR, (0.0, 0.0, 1.0))
)


def inverse_dynamics(
    arm: ArmTensors, q: Tensor, qd: Tensor, qdd: Tensor, wrench: Tensor | None = None
) -> Tensor:
    """Return τ = D(q) q̈ + C(q, q̇) q̇ + g(q) - J_gᵀ wrench (Equation 2.64).

    wrench: (N, 6) [N, Nm], on the arm, base axes, at the origin of frame n. Returns (N, n) [Nm].
    """
    torque = evaluate(arm, _newton_euler, q, qd, qdd)
    return torque if wrench is None else torque - wrench_torque(arm, q, wrench)


def inertia_matrix(arm: ArmTensors, q: Tensor) -> Tensor:
    """Return D(q), (N, n, n) [kg m²], symmetric and positive definite, rotors included."""
    return evaluate(arm, _composite_bodies, q)


def coriolis_matrix(arm: ArmTensors, q: Tensor, qd: Tensor) -> Tensor:
    """Return C(q, q̇) of the Christoffel symbols (2.65, 2.66), (N, n, n) [Nm s/rad].

    The symbols are symmetric, c_ijk = c_jik, so b(q̇) = C(q, q̇) q̇ is a quadratic form in q̇ for
    each joint, and C half its derivative. The central difference of a quadratic form is exact at
    any step: column j of C is [b(q̇ + e_j) - b(q̇ - e_j)] / 4.
    """

    def column(unit: Tensor) -> Tensor:
        ahead, behind = (evaluate(arm, _unloaded, q, qd + step) for step in (unit, -unit))
        return (ahead - behind) / 4

    units = torch.eye(q.shape[1], dtype=q.dtype, device=q.device)
    return torch.stack([column(unit) for unit in units], dim=2)


def gravity_torque(arm: ArmTensors, q: Tensor) -> Tensor:
    """Return g(q) of Equation 2.67, (N, n) [Nm]."""
    return evaluate(arm, _at_rest, q)


def wrench_torque(arm: ArmTensors, q: Tensor, wrench: Tensor) -> Tensor:
    """Return J_gᵀ wrench, (N, n) [Nm], the joint torques of a wrench on the arm.

    wrench: (N, 6) [N, Nm], base axes, at the origin of frame n.
    """
    return evaluate(arm, _pushed, q, wrench=wrench)


def forward_dynamics(
    arm: ArmTensors, q: Tensor, qd: Tensor, torque: Tensor, wrench: Tensor | None = None
) -> Tensor:
    """Return q̈ = D⁻¹ (τ + J_gᵀ wrench - C q̇ - g), (N, n) [rad/s²]; wrench as in
    `inverse_dynamics`.
    """

    def solve(q: Tensor, net_torque: Tensor) -> Tensor:
        # D = L Lᵀ, positive definite
        root = torch.linalg.cholesky(inertia_matrix(arm, q))
        return torch.cholesky_solve(net_torque[..., None], root)[..., 0]

    net_torque = torque - inverse_dynamics(arm, q, qd, torch.zeros_like(q), wrench)
    return in_batches(solve, batch_size(arm), q, net_torque)


def equation_of_motion(
    geometry: Geometry, parameters: Tensor, gravity: Tensor, q: Tensor, qd: Tensor
) -> tuple[Tensor, Tensor]:
    """Return D(q) (N, n, n) and C(q, q̇) q̇ + g(q) (N, n) of arms of one geometry, each under masses
    and a gravity of its own.

    parameters: (11 n, N), π of each; gravity: (3, N) [m/s²], base frame.
    """
    program = straight_line(_equation, geometry)
    rows = program(parameters, gravity, q.T.contiguous(), qd.T.contiguous())
    return rows[1:].movedim(-1, 0), rows[0].T


def kinetic_energy(arm: ArmTensors, q: Tensor, qd: Tensor) -> Tensor:
    """Return ½ q̇ᵀ D(q) q̇, (N,) [J], rotors included (Equation 2.61)."""
    return evaluate(arm, _kinetic_energy, q, qd)


def potential_energy(arm: ArmTensors, q: Tensor) -> Tensor:
    """Return P = -Σ m g0ᵀ r, (N,) [J], zero at the base's origin (Equation 2.63, erratum 2)."""
    return evaluate(arm, _potential_energy, q)


# Kernels: states are (n, N); parameters are those of `ArmTensors`.


def _newton_euler(geometry: Geometry, parameters: Any, q: Any, qd: Any, qdd: Any) -> Any:
    rates = components(geometry, qd, qdd)
    return stacked(_torques(geometry, *split(geometry, parameters), q, *rates), q[0])


def _at_rest(geometry: Geometry, parameters: Any, q: Any) -> Any:
    still = [0.0 for _ in geometry.joints]
    return stacked(_torques(geometry, *split(geometry, parameters), q, still, still), q[0])


def _unloaded(geometry: Geometry, parameters: Any, q: Any, qd: Any) -> Any:
    weightless, still = geometry._replace(gravity=ZERO_VECTOR), [0.0 for _ in geometry.joints]
    [speeds] = components(geometry, qd)
    return stacked(_torques(weightless, *split(geometry, parameters), q, speeds, still), q[0])


def _equation(geometry: Geometry, parameters: Any, gravity: Any, q: Any, qd: Any) -> Any:
    """Return C q̇ + g above the rows of D, (n + 1, n, N)."""
    arm = geometry._replace(gravity=(gravity[0], gravity[1], gravity[2]))
    [speeds], still = components(geometry, qd), [0.0 for _ in geometry.joints]
    torques = _torques(arm, *split(geometry, parameters), q, speeds, still)
    matrix = _composite_bodies(geometry, parameters, q)
    return torch.cat([stacked(torques, q[0])[None], matrix])


def _kinetic_energy(geometry: Geometry, parameters: Any, q: Any, qd: Any) -> Any:
    weightless, still = geometry._replace(gravity=ZERO_VECTOR), [0.0 for _ in geometry.joints]
    [speeds] = components(geometry, qd)
    momenta = _torques(weightless, *split(geometry, parameters), q, still, speeds)  # D q̇
    return 0.5 * sum(speed * momentum for speed, momentum in zip(speeds, momenta, strict=True))


def _potential_energy(geometry: Geometry, parameters: Any, q: Any) -> Any:
    chain, (bodies, _) = recursion.joints(geometry, q), split(geometry, parameters)
    composite, *_ = recursion.composite_inertias(chain, bodies)
    energy = -recursion.dot(geometry.gravity, chain[0].inwards(composite.moment))
    return stacked([energy], q[0])[0]


def _composite_bodies(geometry: Geometry, parameters: Any, q: Any) -> Any:
    """Return D: column k is the torque of q̈_k = 1, which moves all links beyond it as one body."""
    chain, (bodies, rotors) = recursion.joints(geometry, q), split(geometry, parameters)
    entries: dict[tuple[int, int], Any] = {}
    for k, body in enumerate(recursion.composite_inertias(chain, bodies)):
        wrench = recursion.needed_wrench(body, UNIT_TURN)
        entries[k, k] = wrench.moment[2] + rotors[k]
        for j in reversed(range(k)):
            wrench = recursion.wrench_inwards(chain[j + 1], wrench)
            entries[j, k] = entries[k, j] = wrench.moment[2]
    rows = [[entries[i, j] for j in geometry.joints] for i in geometry.joints]
    return torch.stack([stacked(row, q[0]) for row in rows])


def _pushed(geometry: Geometry, parameters: Any, q: Any, wrench: Any) -> Any:
    chain = recursion.joints(geometry, q)
    force, moment = tuple(wrench[k] for k in range(3)), tuple(wrench[k] for k in range(3, 6))
    for joint in chain:
        force, moment = joint.outwards(force), joint.outwards(moment)
    end = geometry.tails[-1]
    moment = recursion.plus(moment, recursion.cross(end.lever, force))
    inner = [recursion.NO_WRENCH] * (len(chain) - 1)
    return stacked(recursion.joint_torques(chain, [*inner, LinkWrench(force, moment)]), q[0])


def _torques(
    geometry: Geometry,
    bodies: Sequence[Inertia],
    rotors: Sequence[Number],
    q: Any,
    qd: Sequence[Number],
    qdd: Sequence[Number],
) -> list[Number]:
    """Return τ by recursive Newton-Euler: motions outwards, wrenches inwards, plus J_m q̈."""
    chain = recursion.joints(geometry, q)
    motions = recursion.link_motions(chain, geometry.gravity, qd, qdd)
    wrenches = [recursion.needed_wrench(*pair) for pair in zip(bodies, motions, strict=True)]
    torques = recursion.joint_torques(chain, wrenches)
    return [t + rotor * a for t, rotor, a in zip(torques, rotors, qdd, strict=True)]


def regressor(arm: ArmTensors, q: Tensor, qd: Tensor, qdd: Tensor) -> Tensor:
    """Return Y(q, q̇, q̈) of τ = Y π, (N, n, 11 n), with π as in `ArmTensors.parameters`.

    q, qd, qdd: (N, n) [rad, rad/s, rad/s²]. Only the arm's geometry matters. The first 10 n columns
    are those of Pinocchio's computeJointTorqueRegressor. Raises ValueError where states are not (N,
    n) of the same N, or not of the arm's precision.
    """
    plain = replace(arm, fused=False)  # thousands of operations would compile for minutes
    return evaluate(plain, _columns, q, qd, qdd)


def _columns(geometry: Geometry, parameters: Any, q: Any, qd: Any, qdd: Any) -> Any:
    """Return Y (n, 11 n, N): each column contains the torques that arise if its parameter is 1 and
    all others are 0.
    """
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
