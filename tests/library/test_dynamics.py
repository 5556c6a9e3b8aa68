"""Kinematics and dynamics: identities, and Pinocchio as an independent engine."""

import numpy as np
import pinocchio
import pytest
import torch

from ur5lib.dynamics.arm import Arm, build_arm
from ur5lib.dynamics.kinematics import jacobian, link_frames
from ur5lib.dynamics.rigid_body import gravity_torque, inertia_matrix, inverse_dynamics
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.urdf import urdf

STATES = 10_000
MODELS = ["A", "B", "C"]


def states(count: int = STATES) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Positions over both turns, velocities and accelerations up to the arm's limits."""
    random = np.random.default_rng(0)
    limits = (2 * np.pi, 3.2, 25.0)
    q, qd, qdd = (torch.tensor(random.uniform(-a, a, (count, 6))) for a in limits)
    return q, qd, qdd


@pytest.fixture(scope="module", params=MODELS)
def model(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(scope="module")
def arm(ur5: Robot, model: str) -> Arm:
    return build_arm(ur5, model)


@pytest.fixture(scope="module")
def oracle(ur5: Robot, model: str) -> tuple:
    engine = pinocchio.buildModelFromXML(urdf(ur5, rigid_bodies(ur5, model)))
    return engine, engine.createData()


def test_inverse_dynamics_agrees_with_pinocchio(arm: Arm, oracle: tuple) -> None:
    q, qd, qdd = states()
    ours = inverse_dynamics(arm, q, qd, qdd).numpy()
    rows = zip(q.numpy(), qd.numpy(), qdd.numpy(), strict=True)
    theirs = np.array([pinocchio.rnea(*oracle, *row) for row in rows])
    assert np.abs(ours - theirs).max() < 1e-9


def test_inertia_matrix_agrees_with_pinocchio(arm: Arm, oracle: tuple) -> None:
    q, _, _ = states()
    upper = np.triu([pinocchio.crba(*oracle, row) for row in q.numpy()])
    theirs = upper + np.triu(upper, 1).transpose(0, 2, 1)
    assert np.abs(inertia_matrix(arm, q).numpy() - theirs).max() < 1e-9


def test_gravity_torque_agrees_with_pinocchio(arm: Arm, oracle: tuple) -> None:
    q, _, _ = states()
    theirs = np.array([pinocchio.computeGeneralizedGravity(*oracle, row) for row in q.numpy()])
    assert np.abs(gravity_torque(arm, q).numpy() - theirs).max() < 1e-9


def test_inertia_matrix_is_symmetric_and_positive_definite(arm: Arm) -> None:
    matrix = inertia_matrix(arm, states()[0])
    assert (matrix - matrix.mT).abs().max() < 1e-12
    assert torch.linalg.eigvalsh(matrix).min() > 0


def test_both_derivations_of_the_torque_agree(arm: Arm) -> None:
    """Newton-Euler at rest is g, and its columns in the accelerations are D."""
    q, _, qdd = states(500)
    still = torch.zeros_like(q)
    gravity = gravity_torque(arm, q)
    torch.testing.assert_close(inverse_dynamics(arm, q, still, still), gravity)
    accelerated = (inertia_matrix(arm, q) @ qdd[..., None])[..., 0] + gravity
    torch.testing.assert_close(inverse_dynamics(arm, q, still, qdd), accelerated)


def test_power_is_the_change_of_energy(arm: Arm) -> None:
    """qd^T tau = d/dt (kinetic + potential), along a motion of constant acceleration."""
    q, qd, qdd = states(200)
    step = 1e-5

    def energy(time: float) -> torch.Tensor:
        at, velocity = q + qd * time + qdd * time**2 / 2, qd + qdd * time
        rotation, origin = link_frames(arm, at)
        height = origin[:, 1:] + (rotation[:, 1:] @ arm.center_of_mass[..., None])[..., 0]
        potential = -(arm.mass[:, None] * height @ arm.gravity[:, None]).sum((1, 2))
        return (
            potential
            + (velocity[:, None] @ inertia_matrix(arm, at) @ velocity[..., None])[:, 0, 0] / 2
        )

    power = (qd * inverse_dynamics(arm, q, qd, qdd)).sum(1)
    torch.testing.assert_close(
        (energy(step) - energy(-step)) / (2 * step), power, rtol=1e-6, atol=1e-5
    )


def test_frames_are_the_denavit_hartenberg_ones(ur5: Robot, arm: Arm) -> None:
    """Products of Equation 2.19, written out."""
    q, _, _ = states(100)
    pose = np.tile(np.eye(4), (100, 1, 1))
    rotation, origin = link_frames(arm, q)
    for k, (link, angle) in enumerate(zip(ur5.denavit_hartenberg, q.T.numpy(), strict=True)):
        c, s, zero = np.cos(angle), np.sin(angle), np.zeros(100)
        ca, sa = np.cos(link.alpha) + zero, np.sin(link.alpha) + zero
        rows = [
            [c, -s * ca, s * sa, link.a * c],
            [s, c * ca, -c * sa, link.a * s],
            [zero, sa, ca, link.d + zero],
            [zero, zero, zero, zero + 1],
        ]
        pose = pose @ np.array(rows).transpose(2, 0, 1)
        np.testing.assert_allclose(rotation[:, k + 1], pose[:, :3, :3], atol=1e-14)
        np.testing.assert_allclose(origin[:, k + 1], pose[:, :3, 3], atol=1e-14)


@pytest.mark.parametrize("link", range(1, 7))
def test_jacobian_is_the_derivative_of_the_pose(arm: Arm, link: int) -> None:
    q, qd, _ = states(100)
    point, step = torch.tensor([0.1, -0.2, 0.3], dtype=torch.float64), 1e-6

    def pose(time: float) -> tuple[torch.Tensor, torch.Tensor]:
        rotation, origin = link_frames(arm, q + qd * time)
        return rotation[:, link], origin[:, link] + rotation[:, link] @ point

    (rotation_0, place_0), (rotation_1, place_1) = pose(-step), pose(step)
    linear = (place_1 - place_0) / (2 * step)
    spin = (rotation_1 - rotation_0) / (2 * step) @ pose(0)[0].mT  # S(omega), (2.21)
    angular = torch.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], dim=1)
    velocity = (jacobian(arm, q, link, point) @ qd[..., None])[..., 0]
    torch.testing.assert_close(velocity, torch.cat([linear, angular], 1), rtol=1e-6, atol=1e-7)


def test_single_precision_is_what_its_name_says(ur5: Robot, arm: Arm, model: str) -> None:
    single = build_arm(ur5, model, dtype=torch.float32)
    q, qd, qdd = states(1000)
    exact = inverse_dynamics(arm, q, qd, qdd)
    rounded = inverse_dynamics(single, q.float(), qd.float(), qdd.float())
    assert rounded.dtype == torch.float32
    assert (rounded - exact).abs().max() < 1e-5 * exact.abs().max()
