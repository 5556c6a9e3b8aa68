"""Poses and gravity without torch are those of the dynamics."""

import numpy as np
import pytest

from ur5lib.dynamics.flange import link_frames
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.robots import statics
from ur5lib.robots.description import Payload, Robot, load_robot, robot_names, robot_path

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
