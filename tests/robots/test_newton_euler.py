"""The regressor without torch is that of the dynamics, and Pinocchio's; so are its torques."""

from pathlib import Path

import numpy as np
import pinocchio
import pytest

from benchmarks.harness.abb_like import MadeUpArm
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.robots import newton_euler
from ur5lib.robots.description import Payload, Robot, load_robot, robot_names, robot_path
from ur5lib.robots.from_urdf import robot_from_urdf

Q, QD, QDD = np.random.default_rng(0).uniform(-3, 3, (3, 20, 6))
LOAD = Payload(mass=2.0, center_of_mass=(0.1, -0.2, 0.3), inertia=(0.1, 0.2, 0.15, 0.01, 0, 0.02))


@pytest.fixture(params=robot_names())
def arm(request: pytest.FixtureRequest) -> Robot:
    return load_robot(robot_path(request.param)).mounted([1.0, -2.0, -9.5])


def test_columns_are_those_of_the_dynamics(arm: Robot) -> None:
    expected = LinkModel(arm, arm.chosen_model).regressor(Q, QD, QDD)
    own = newton_euler.torque_regressor(arm, Q, QD, QDD)
    np.testing.assert_allclose(own, expected, atol=1e-10)


def test_torques_are_those_of_the_dynamics(arm: Robot) -> None:
    loaded = arm.carrying(LOAD)
    expected = LinkModel(loaded, loaded.fullest_model()).inverse_dynamics(Q, QD, QDD)
    own = newton_euler.torque(loaded, loaded.fullest_model(), Q, QD, QDD)
    np.testing.assert_allclose(own, expected, atol=1e-9)


def test_columns_of_links_are_pinocchios(tmp_path: Path) -> None:
    """Of an arm whose axes point anywhere, from its URDF."""
    made = MadeUpArm(1)
    (tmp_path / "arm.urdf").write_bytes(made.file)
    robot, _ = robot_from_urdf(tmp_path / "arm.urdf")
    data, model = made.model.createData(), robot.chosen_model
    own = newton_euler.torque(robot, model, Q, QD, QDD)
    expected = [pinocchio.rnea(made.model, data, *state) for state in zip(Q, QD, QDD, strict=True)]
    np.testing.assert_allclose(own, expected, atol=1e-9)
    of_links = newton_euler.torque_regressor(robot, Q, QD, QDD)[:, :, :60]
    states = zip(Q, QD, QDD, strict=True)
    theirs = [pinocchio.computeJointTorqueRegressor(made.model, data, *s) for s in states]
    # Pinocchio's axes of links differ from those about whose z joints turn; what they span does not
    both = np.concatenate([of_links, np.array(theirs)], axis=2).reshape(-1, 120)
    ranks = [np.linalg.matrix_rank(part) for part in (both, both[:, :60], both[:, 60:])]
    assert len({*ranks}) == 1
