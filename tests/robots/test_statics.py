"""Poses and gravity without torch are those of the dynamics."""

import numpy as np
import pytest

from ur5lib.dynamics.flange import link_frames
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.robots import statics
from ur5lib.robots.description import Payload, Robot, load_robot, robot_names, robot_path
from ur5lib.robots.inertia import rigid_bodies

Q = np.random.default_rng(0).uniform(-3, 3, (50, 6))
LOAD = Payload(mass=2.0, center_of_mass=(0.1, -0.2, 0.3))
WEIGHT = np.array([2.0, 0.2, -0.4, 0.6])  # its mass [kg] and first moments [kg m]


@pytest.fixture(params=robot_names())
def arm(request: pytest.FixtureRequest) -> Robot:
    return load_robot(robot_path(request.param)).mounted([1.0, -2.0, -9.5])


def test_frames(arm: Robot) -> None:
    for own, other in zip(statics.link_frames(arm, Q), link_frames(arm, Q), strict=True):
        np.testing.assert_allclose(own, other, atol=1e-12)


def test_gravity(arm: Robot) -> None:
    loaded = arm.carrying(LOAD)
    expected = LinkModel(loaded, arm.chosen_model).gravity_torque(Q)
    own = statics.gravity_torque(loaded, arm.chosen_model, Q)
    np.testing.assert_allclose(own, expected, atol=1e-10)


def test_a_load_adds_its_torque(arm: Robot) -> None:
    bare, loaded = (
        statics.gravity_torque(a, arm.chosen_model, Q) for a in (arm, arm.carrying(LOAD))
    )
    np.testing.assert_allclose(loaded - bare, statics.load_torque(arm, Q) @ WEIGHT, atol=1e-10)


def test_links_weigh_by_the_regressor(arm: Robot) -> None:
    """τ_j = Σ_k Y_jk [m_k, m_k c_k]."""
    bodies = rigid_bodies(arm, arm.chosen_model)
    own = np.column_stack([bodies.mass, bodies.mass[:, None] * bodies.center_of_mass])
    torque = np.einsum("njkp,kp->nj", statics.gravity_regressor(arm, Q), own)
    expected = statics.gravity_torque(arm, arm.chosen_model, Q)
    np.testing.assert_allclose(torque, expected, atol=1e-10)


@pytest.mark.parametrize("gravity", [(0.0, 0.0, -9.81), (1e-15, -2e-15, -9.81)])
def test_gravity_of_unknown_links_is_in_its_columns(arm: Robot, gravity: tuple[float, ...]) -> None:
    """And an upright axis bears none, though its base is turned by as little as rounding."""
    standing = arm.mounted(gravity)
    unknown = standing.model_copy(update={"links": "unknown"})
    torque = statics.gravity_torque(standing, arm.chosen_model, Q).T
    columns = statics.gravity_columns(unknown, Q)
    assert columns[0].shape == (len(Q), 0)
    for basis, own in zip(columns[1:], torque[1:], strict=True):
        np.testing.assert_allclose(basis @ (basis.T @ own), own, atol=1e-2 * np.abs(torque).max())
    assert [basis.shape[0] for basis in statics.gravity_columns(unknown, Q[:0])] == [0] * 6


def test_gravity_loads_no_joint_with_an_upright_axis() -> None:
    """Joint 1 of an upright arm shows no torque constant; on a wall, it does."""
    arm = load_robot(robot_path("ur3"))
    assert {2, 3, 4} <= {*statics.bearing_joints(arm)} <= {2, 3, 4, 5}
    assert 1 in statics.bearing_joints(arm.mounted([9.81, 0.0, 0.0]))


def test_a_known_load_fits_the_arm() -> None:
    """An arm of 300 kg payload was told to carry 2 kg."""
    loads = {name: load_robot(robot_path(name)).known_load() for name in ("ur5", "kuka-kr300")}
    assert {name: load and load.mass for name, load in loads.items()} == {
        "ur5": 2.0,
        "kuka-kr300": 100.0,
    }
    unrated = load_robot(robot_path("ur5")).model_copy(update={"rated_payload": None})
    assert unrated.known_load().mass == pytest.approx(2.0)
    unknown = unrated.model_copy(update={"links": "unknown"})
    assert unknown.known_load() is None
