"""Poses, Jacobians and orientations: identities and finite differences."""

from collections.abc import Callable

import numpy as np
import pytest
import torch
from scipy.spatial.transform import Rotation
from torch import Tensor

from tests.dynamics.test_dynamics import STATES, states, times
from ur5lib.dynamics.arm import ArmTensors, build_arm
from ur5lib.dynamics.kinematics import (
    acceleration,
    analytical_jacobian,
    jacobian,
    link_frames,
    velocity,
    velocity_product_acceleration,
    zyz_angles,
    zyz_rates_to_angular_velocity,
)
from ur5lib.robots.description import Robot, load_robot, robot_path

POINT = torch.tensor([0.1, -0.2, 0.3], dtype=torch.float64)


@pytest.fixture(scope="module", params=["ur5", "ur10e"])
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(robot_path(request.param))


@pytest.fixture(scope="module")
def arm(robot: Robot) -> ArmTensors:
    return build_arm(robot, robot.chosen_model)


def slope(function: Callable[[float], Tensor], step: float = 2e-3) -> Tensor:
    """d/dt at 0 by central differences of eighth order: rounding is what is left of the error."""
    weights = (4 / 5, -1 / 5, 4 / 105, -1 / 280)
    parts = [w * (function(k * step) - function(-k * step)) for k, w in enumerate(weights, 1)]
    return torch.stack(parts).sum(0) / step


def angular_velocity(rotation: Callable[[float], Tensor]) -> Tensor:
    spin = slope(rotation) @ rotation(0).mT  # S(ω) = Ṙ Rᵀ (2.21)
    return torch.stack([spin[:, 2, 1], spin[:, 0, 2], spin[:, 1, 0]], dim=1)


def test_frames_are_the_denavit_hartenberg_ones(robot: Robot, arm: ArmTensors) -> None:
    """Products of Equation 2.19, written out."""
    q, _, _ = states(100)
    pose = np.tile(np.eye(4), (100, 1, 1))
    rotation, origin = link_frames(arm, q)
    for k, (link, angle) in enumerate(zip(robot.denavit_hartenberg, q.T.numpy(), strict=True)):
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
def test_jacobian_is_the_derivative_of_the_pose(arm: ArmTensors, link: int) -> None:
    q, qd, _ = states(1000)

    def place(time: float) -> Tensor:
        rotation, origin = link_frames(arm, q + qd * time)
        return origin[:, link] + rotation[:, link] @ POINT

    angular = angular_velocity(lambda time: link_frames(arm, q + qd * time)[0][:, link])
    expected = torch.cat([slope(place), angular], dim=1)
    ours = velocity(arm, q, qd, link, POINT)
    torch.testing.assert_close(ours, expected, rtol=0, atol=1e-9)
    torch.testing.assert_close(ours, times(jacobian(arm, q, link, POINT), qd))


@pytest.mark.parametrize(("link", "count"), [*((k, 1000) for k in range(1, 6)), (6, STATES)])
def test_velocity_product_acceleration_is_the_change_of_the_jacobian(
    arm: ArmTensors, link: int, count: int
) -> None:
    q, qd, qdd = states(count)
    change = slope(lambda time: jacobian(arm, q + qd * time, link, POINT), 1e-3)
    expected = times(change, qd)
    ours = velocity_product_acceleration(arm, q, qd, link, POINT)
    assert (ours - expected).abs().max() < 1e-9 * expected.abs().max()
    moved = times(jacobian(arm, q, link, POINT), qdd) + ours
    torch.testing.assert_close(acceleration(arm, q, qd, qdd, link, POINT), moved)


# Orientation


def rotations(count: int = STATES) -> Tensor:
    return torch.tensor(Rotation.random(count, random_state=0).as_matrix())


def from_zyz(angles: Tensor) -> Tensor:
    """Equation 2.2, by another library."""
    return torch.tensor(Rotation.from_euler("ZYZ", angles.numpy()).as_matrix())


def test_zyz_angles_give_the_rotation_back() -> None:
    angles = zyz_angles(rotations())
    torch.testing.assert_close(from_zyz(angles), rotations(), rtol=0, atol=1e-14)
    assert (angles[:, 1] >= 0).all()


@pytest.mark.parametrize("theta", [0.0, np.pi])
@pytest.mark.parametrize("tilt", [0.0, 1e-16, 1e-14, 1e-8])
def test_zyz_angles_survive_their_singularity(theta: float, tilt: float) -> None:
    """Equations 2.6 and 2.7: only φ ± ψ is determined there, and φ = 0 by convention."""
    random = np.random.default_rng(0)
    turns = random.uniform(-np.pi, np.pi, (2, 1000))
    exact = torch.tensor(np.stack([turns[0], np.full(1000, theta - tilt), turns[1]], axis=1))
    rotation = from_zyz(exact)
    if tilt == 0:
        rotation = torch.where(rotation.abs() < 1e-15, 0.0, rotation)
    angles = zyz_angles(rotation)
    torch.testing.assert_close(from_zyz(angles), rotation, rtol=0, atol=1e-14)
    if tilt < 1e-15:
        assert (angles[:, 0] == 0).all()


def test_rates_of_zyz_angles_are_put_right() -> None:
    """Equation 2.33 as in erratum 1, against finite differences of R_z R_y R_z."""
    random = np.random.default_rng(0)
    angles = torch.tensor(random.uniform(-3, 3, (STATES, 3)))
    rates = torch.tensor(random.uniform(-3, 3, (STATES, 3)))
    expected = angular_velocity(lambda time: from_zyz(angles + rates * time))
    ours = times(zyz_rates_to_angular_velocity(angles), rates)
    torch.testing.assert_close(ours, expected, rtol=0, atol=1e-9)


def test_analytical_jacobian_is_the_derivative_of_the_angles(arm: ArmTensors) -> None:
    """Away from sin ϑ = 0, where angles change without bound."""
    q, qd, _ = states(2000)
    away = zyz_angles(link_frames(arm, q)[0][:, 6])[:, 1].sin() > 0.3
    q, qd = q[away], qd[away]

    def angles(time: float) -> Tensor:
        return zyz_angles(link_frames(arm, q + qd * time)[0][:, 6])

    start = angles(0)
    change = slope(lambda time: torch.remainder(angles(time) - start + 3, 2 * np.pi), 5e-4)
    rates = times(analytical_jacobian(arm, q), qd)
    assert len(q) > 1000
    torch.testing.assert_close(rates[:, :3], velocity(arm, q, qd)[:, :3])
    assert (rates[:, 3:] - change).abs().max() < 1e-8 * change.abs().max()


def test_analytical_jacobian_is_no_error_at_the_singularity(arm: ArmTensors) -> None:
    """With q = 0 and joint 5 at rest, frame 6 points along the base's axes."""
    q = torch.zeros(2, 6, dtype=torch.float64)
    q[1] = torch.tensor([0.3, -1.2, 0.8, -0.5, 0.7, 0.2])
    matrix = analytical_jacobian(arm, q)
    assert matrix.shape == (2, 6, 6)
    assert matrix[1].isfinite().all()
