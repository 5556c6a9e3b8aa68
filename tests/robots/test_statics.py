"""Poses, Jacobians and gravity without torch are those of the dynamics, and of Pinocchio."""

from pathlib import Path

import numpy as np
import pinocchio
import pytest
import torch

from tests.house.test_seven_joints import arm as seven_joints
from tests.robots.test_arm_family import configuration
from tests.robots.test_from_urdf import made_up, saved
from ur5lib.dynamics import kinematics
from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.robots import statics
from ur5lib.robots.description import Payload, Robot, load_robot, robot_names, robot_path
from ur5lib.robots.exports import urdf
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.timeseries.arrays import Array

Q = np.random.default_rng(0).uniform(-3, 3, (50, 6))
LOAD = Payload(mass=2.0, center_of_mass=(0.1, -0.2, 0.3))
WEIGHT = np.array([2.0, 0.2, -0.4, 0.6])  # its mass [kg] and first moments [kg m]


@pytest.fixture(params=robot_names())
def arm(request: pytest.FixtureRequest) -> Robot:
    return load_robot(robot_path(request.param)).mounted([1.0, -2.0, -9.5])


@pytest.fixture(params=[*robot_names(), "seven joints", "made up 5", "made up 7"])
def any_arm(request: pytest.FixtureRequest, tmp_path: Path) -> Robot:
    """Of five to seven joints, on a tilted base, with a load off its flange's axis."""
    if request.param == "seven joints":
        robot = seven_joints()
    elif request.param.startswith("made up"):
        urdf_file = saved(made_up(int(request.param[-1])), tmp_path)
        robot, _ = robot_from_urdf(urdf_file, None, None)
    else:
        robot = load_robot(robot_path(request.param))
    return robot.mounted([1.0, -2.0, -9.5]).carrying(LOAD)


def postures(robot: Robot) -> Array:
    return np.random.default_rng(1).uniform(-6, 6, (50, len(robot.joints)))


def test_frames_and_jacobians_are_those_of_the_dynamics(any_arm: Robot) -> None:
    q, last = postures(any_arm), len(any_arm.joints)
    arm, position = build_arm(any_arm, any_arm.chosen_model), torch.from_numpy(q)
    frames = statics.link_frames(any_arm, q)
    for own, other in zip(frames, kinematics.link_frames(arm, position), strict=True):
        np.testing.assert_allclose(own, other, atol=1e-13)
    expected = kinematics.jacobian(arm, position)
    np.testing.assert_allclose(statics.geometric_jacobian(any_arm, q), expected, atol=1e-13)
    rotation, origin, jacobian = statics.flange_kinematics(any_arm, q)
    np.testing.assert_array_equal(rotation, frames[0][:, last])
    np.testing.assert_array_equal(origin, frames[1][:, last])
    np.testing.assert_array_equal(jacobian, statics.geometric_jacobian(any_arm, q))


def test_frames_jacobians_and_gravity_are_those_of_pinocchio(any_arm: Robot) -> None:
    model, q = any_arm.chosen_model, postures(any_arm)
    engine = pinocchio.buildModelFromXML(urdf(any_arm, rigid_bodies(any_arm, model)))
    engine.gravity.linear = np.array(any_arm.gravity)
    data, names = engine.createData(), [f"frame_{k}" for k in range(len(any_arm.joints) + 1)]
    frames, jacobians, torques = [], [], []
    for posture in (configuration(engine, one) for one in q):
        pinocchio.computeJointJacobians(engine, data, posture)
        pinocchio.updateFramePlacements(engine, data)
        frames.append([data.oMf[engine.getFrameId(name)].homogeneous for name in names])
        flange = engine.getFrameId(names[-1])
        axes = pinocchio.LOCAL_WORLD_ALIGNED
        jacobians.append(pinocchio.getFrameJacobian(engine, data, flange, axes))
        torques.append(pinocchio.computeGeneralizedGravity(engine, data, posture))
    rotation, origin = statics.link_frames(any_arm, q)
    np.testing.assert_allclose(rotation, np.array(frames)[..., :3, :3], atol=1e-12)
    np.testing.assert_allclose(origin, np.array(frames)[..., :3, 3], atol=1e-12)
    np.testing.assert_allclose(statics.geometric_jacobian(any_arm, q), jacobians, atol=1e-12)
    own = statics.gravity_torque(any_arm, model, q)
    np.testing.assert_allclose(own, torques, rtol=1e-10, atol=1e-10)


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
