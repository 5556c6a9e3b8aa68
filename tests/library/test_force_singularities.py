"""Where the arms are singular, by their Jacobian and by their geometry."""

import numpy as np
import pytest
from typer.testing import CliRunner

from ur5lib.cli import app
from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.errors import InputError
from ur5lib.force.singularities import (
    SINGULARITY_KINDS,
    sample_joints,
    singular_distances,
    singular_shares,
    smallest_singular_value,
)
from ur5lib.robots.description import Robot, load_robot, robot_path

RANGES = [(-3.1, 3.1)] * 6
POSE = np.array([0.3, -1.2, 1.4, -1.0, 1.2, 0.4])


@pytest.mark.parametrize("name", ["ur5", "ur10e"])
def test_the_determinant_is_the_product_of_the_distances(name: str) -> None:
    robot = load_robot(robot_path(name))
    q = sample_joints(RANGES, 2000)
    links = robot.denavit_hartenberg[1].a * robot.denavit_hartenberg[2].a
    product = abs(links) * singular_distances(robot, q).prod(axis=1)
    J = flange_kinematics(robot, q)[2]
    np.testing.assert_allclose(np.abs(np.linalg.det(J)), product, atol=1e-12)
    values = np.linalg.svd(J, compute_uv=False)
    np.testing.assert_array_equal(smallest_singular_value(J), values[:, -1])


def test_joints_are_sampled_all_over_their_ranges() -> None:
    limits = [(-1.0, 1.0), (0.0, 2.0), (-3.0, -2.0), (0.0, 0.1), (5.0, 6.0), (-0.5, 0.5)]
    q = sample_joints(limits, 1000)
    for joint, (low, high) in enumerate(limits):
        counts = np.histogram(q[:, joint], bins=10, range=(low, high))[0]
        assert counts.min() > 80
        assert counts.sum() == 1000
    np.testing.assert_array_equal(sample_joints(limits, 1000), q)  # always the same
    np.testing.assert_allclose(q[:2, :2], [[-1.0, 0.0], [0.0, 2 / 3]])  # Halton's, from zero


def test_each_kind_is_named_where_it_is_alone(ur5: Robot) -> None:
    """Ranges around an elbow or a wrist singularity have that one, far from all they have none."""
    for kind, joint in (("elbow", 2), ("wrist", 4)):
        limits = [(value - 0.3, value + 0.3) for value in POSE]
        limits[joint] = (-0.3, 0.3)
        q = sample_joints(limits, 2000)
        singular = smallest_singular_value(flange_kinematics(ur5, q)[2]) < 0.01
        share = singular_shares(ur5, q, singular)[kind]
        assert share > 0.01
        assert share == pytest.approx(singular.mean(), abs=0.01)
    q = sample_joints([(value - 0.1, value + 0.1) for value in POSE], 500)
    singular = smallest_singular_value(flange_kinematics(ur5, q)[2]) < 0.01
    assert singular_shares(ur5, q, singular) == dict.fromkeys(SINGULARITY_KINDS, 0.0)


def test_the_command_maps_joint_ranges() -> None:
    """With the elbow kept bent and the wrist turned, no elbow or wrist singularity is met."""
    bent = ["--within", "3=0.5:2.5", "--within", "5=0.5:2.5"]
    command = ["singularities", "--robot", "ur5", "--count", "2000"]
    whole = CliRunner().invoke(app, command, catch_exceptions=False)
    kept = CliRunner().invoke(app, [*command, *bent], catch_exceptions=False)
    assert "elbow: 0.00 %" in kept.stdout
    assert "wrist: 0.00 %" in kept.stdout
    assert "elbow: 0.00 %" not in whole.stdout


@pytest.mark.parametrize("entry", ["3", "3=1", "3=2:1", "7=0:1", "a=0:1"])
def test_a_wrong_range_is_told(entry: str) -> None:
    done = CliRunner().invoke(app, ["singularities", "--robot", "ur5", "--within", entry])
    assert isinstance(done.exception, InputError)
    assert "write joint=low:high" in str(done.exception)
