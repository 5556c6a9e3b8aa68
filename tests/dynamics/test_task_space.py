"""Inverse dynamics in task space and transformation of velocities, by identities."""

import math

import pytest
import torch
from torch import Tensor

from tests.dynamics.test_dynamics import states
from tests.dynamics.test_dynamics_kinematics import slope
from tests.task_space import (
    pose,
    pose_acceleration,
    task_space_torque,
    wanted_acceleration,
)
from ur5lib.dynamics.arm import ArmTensors, build_arm
from ur5lib.dynamics.rigid_body import forward_dynamics
from ur5lib.robots.description import Robot

COUNT = 60


@pytest.fixture(scope="module")
def arm(ur5: Robot) -> ArmTensors:
    return build_arm(ur5, "C")


@pytest.fixture(scope="module")
def regular(arm: ArmTensors) -> tuple[Tensor, Tensor, Tensor]:
    """States away from the singularities of the arm and of the angles."""
    q, qd, qdd = states(4 * COUNT)
    theta = pose(arm, q)[:, 4]
    kept = (torch.sin(theta) > 0.3) & (torch.sin(q[:, 4]).abs() > 0.3) & (torch.sin(q[:, 2]) > 0.3)
    assert kept.sum() > 20
    return q[kept], qd[kept], qdd[kept]


def test_the_pose_accelerates_as_its_second_derivative(
    arm: ArmTensors, regular: tuple[Tensor, Tensor, Tensor]
) -> None:
    q, qd, qdd = regular

    def rate(t: float) -> Tensor:
        def at(s: float) -> Tensor:
            moved = pose(arm, q + (t + s) * qd + (t + s) ** 2 / 2 * qdd)
            off = moved - pose(arm, q)
            off[:, 3:] = torch.remainder(off[:, 3:] + math.pi, 2 * math.pi) - math.pi
            return off

        return slope(at)

    found = pose_acceleration(arm, q, qd, qdd)
    torch.testing.assert_close(found, slope(rate), rtol=1e-4, atol=1e-4)


def test_the_commanded_acceleration_is_what_the_arm_does(
    arm: ArmTensors, regular: tuple[Tensor, Tensor, Tensor]
) -> None:
    """(2.78): the torque of a_X, in the forward dynamics, accelerates the pose by a_X."""
    q, qd, wanted = regular
    qdd = forward_dynamics(arm, q, qd, task_space_torque(arm, q, qd, wanted))
    torch.testing.assert_close(pose_acceleration(arm, q, qd, qdd), wanted, rtol=1e-8, atol=1e-8)


def test_the_control_law_leads_to_the_target(arm: ArmTensors) -> None:
    """In closed loop, each error is that of a critically damped system: (1 + ω t) exp(-ω t)."""
    q = torch.tensor([[0.3, -1.2, 1.4, -1.0, 1.3, 0.2]], dtype=torch.float64)
    qd, omega, step = torch.zeros_like(q), 4.0, 1e-2
    start = pose(arm, q)
    off = torch.tensor([[0.05, -0.04, 0.06, 0.1, -0.08, 2 * math.pi + 0.1]], dtype=torch.float64)
    still = torch.zeros_like(q)
    target = start - off, still, still
    gains = (torch.full((6,), omega**2).to(q), torch.full((6,), 2 * omega).to(q))

    def accelerated(q: Tensor, qd: Tensor) -> Tensor:
        wanted = wanted_acceleration(arm, q, qd, target, gains)
        return forward_dynamics(arm, q, qd, task_space_torque(arm, q, qd, wanted))

    for _ in range(50):  # the midpoint method
        half, middle = q + step / 2 * qd, qd + step / 2 * accelerated(q, qd)
        q, qd = q + step * middle, qd + step * accelerated(half, middle)
    off[0, 5] -= 2 * math.pi  # the nearer way round
    left = (1 + omega * 0.5) * math.exp(-omega * 0.5)
    torch.testing.assert_close(pose(arm, q) - start, (left - 1) * off, rtol=0, atol=5e-4)
