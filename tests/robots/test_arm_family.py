"""The manufacturer's arms as data: beside the ROS description and other engines."""

from pathlib import Path

import mujoco
import numpy as np
import pinocchio
import pytest
import yaml
from scipy.spatial.transform import Rotation
from typer.testing import CliRunner

from tests.conftest import shared_folder
from ur5lib.cli import app
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.robots.description import Robot, joint_sizes, load_robot, robot_names, robot_path
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import RigidBodies, rigid_bodies
from ur5lib.timeseries.arrays import Array

CB, E_SERIES, HEAVY = ["ur3", "ur5", "ur10"], ["ur3e", "ur5e", "ur10e", "ur16e"], ["ur20", "ur30"]
REACH = {"ur8long": 1.75, "ur15": 1.3, "ur18": 0.95, "ur20": 1.75, "ur30": 1.3}  # m, data sheets
FAMILY = [*CB, *E_SERIES, *HEAVY]
ROUNDED = 1.001e-6  # m; the thesis's UR5 has d1 = 89.16 mm, the ROS description 89.159 mm
ROS_LINKS = ["shoulder", "upper_arm", "forearm", "wrist_1", "wrist_2", "wrist_3"]


@pytest.fixture(params=FAMILY)
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(robot_path(request.param))


@pytest.fixture(scope="module")
def descriptions() -> Path:
    return shared_folder("arms", "they are config/ of Universal_Robots_ROS2_Description")


def states(count: int) -> Array:
    return np.random.default_rng(0).uniform(-3, 3, (3, count, 6))


def test_the_family_is_described() -> None:
    assert set(FAMILY) <= set(robot_names())


# Kinematics


def ros_flange(path: Path, q: Array) -> tuple[Array, Array]:
    """R (3, 3), o (3,) of `tool0` in `base`, from transforms between ROS's link frames."""
    kinematics = yaml.safe_load(path.read_text())["kinematics"]
    pose = np.eye(4)
    for name, angle in zip(ROS_LINKS, q, strict=True):
        link, step = kinematics[name], np.eye(4)
        rpy = [link[key] for key in ("roll", "pitch", "yaw")]
        turned = Rotation.from_euler("xyz", rpy) * Rotation.from_rotvec([0, 0, angle])
        step[:3, :3], step[:3, 3] = turned.as_matrix(), [link[key] for key in "xyz"]
        pose = pose @ step
    return pose[:3, :3], pose[:3, 3]


def test_exported_kinematics_are_the_ros_description_s(robot: Robot, descriptions: Path) -> None:
    engine = pinocchio.buildModelFromXML(urdf(robot, rigid_bodies(robot, robot.chosen_model)))
    data, flange = engine.createData(), engine.getFrameId("frame_6")
    for q in states(20)[0]:
        pinocchio.framesForwardKinematics(engine, data, configuration(engine, q))
        rotation, origin = ros_flange(descriptions / robot.name / "default_kinematics.yaml", q)
        np.testing.assert_allclose(data.oMf[flange].translation, origin, rtol=0, atol=ROUNDED)
        np.testing.assert_allclose(data.oMf[flange].rotation, rotation, rtol=0, atol=1e-8)


def configuration(engine: pinocchio.Model, q: Array) -> Array:
    """q as Pinocchio has it: cosine and sine of a joint that turns without limit."""
    parts = [
        [angle] if joint.nq == 1 else [np.cos(angle), np.sin(angle)]
        for joint, angle in zip([*engine.joints][1:], q, strict=True)
    ]
    return np.concatenate(parts)


@pytest.mark.parametrize(("name", "reach"), REACH.items())
def test_the_reach_is_that_of_the_data_sheet(name: str, reach: float) -> None:
    """Upper arm, forearm and the offset of joint 5, to the wrist's centre."""
    links = load_robot(robot_path(name)).denavit_hartenberg
    assert -links[1].a - links[2].a + links[4].d == pytest.approx(reach, abs=1e-3)


# Dynamics


@pytest.mark.parametrize("name", robot_names())
def test_torques_are_those_of_other_engines(name: str) -> None:
    robot = load_robot(robot_path(name))
    model, given = [*robot.models][-1], states(20)
    bodies = rigid_bodies(robot, model)
    ours = LinkModel(robot, model).inverse_dynamics(*given)
    for engine in (by_pinocchio, by_mujoco):
        np.testing.assert_allclose(ours, engine(robot, bodies, given), atol=1e-7)


def by_pinocchio(robot: Robot, bodies: RigidBodies, given: Array) -> Array:
    """Torques (N, n) of motions (3, N, n), by the arm's URDF."""
    engine = pinocchio.buildModelFromXML(urdf(robot, bodies))
    engine.armature, engine.gravity.linear = bodies.rotor_inertia, np.array(robot.gravity)
    data = engine.createData()
    rows = zip(*given, strict=True)
    return np.array(
        [pinocchio.rnea(engine, data, configuration(engine, q), qd, qdd) for q, qd, qdd in rows]
    )


def by_mujoco(robot: Robot, bodies: RigidBodies, given: Array) -> Array:
    engine = mujoco.MjModel.from_xml_string(urdf(robot, bodies.rigid(1e-12)))  # no point masses
    engine.dof_armature[:], engine.opt.gravity[:] = bodies.rotor_inertia, robot.gravity
    engine.opt.disableflags = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data, torques = mujoco.MjData(engine), []
    for data.qpos, data.qvel, data.qacc in zip(*given, strict=True):
        mujoco.mj_inverse(engine, data)
        torques.append(data.qfrc_inverse.copy())
    return np.array(torques)


# Joint sizes


@pytest.mark.parametrize("name", ["ur3", "ur10", *E_SERIES])
def test_rotors_and_torque_constants_come_with_the_joint_sizes(name: str) -> None:
    robot = load_robot(robot_path(name))
    sizes = [joint_sizes()[size] for size in robot.joints]
    rotors = robot.models[f"{robot.chosen_model}+rotors"].rotor_inertias
    assert rotors == pytest.approx([size["rotor_inertia"] * 101**2 for size in sizes])
    constants = [size["torque_constant"] * 101 for size in sizes]
    assert robot.maker_torque_constants() == pytest.approx(constants)


def test_an_arm_may_describe_a_joint_size_of_its_own(tmp_path: Path) -> None:
    path = tmp_path / "mine.yaml"
    own = "motors: {size1: {position_max: 3, velocity_max: 1, torque_max: 5}}\nmasses:"
    path.write_text(robot_path("ur5e").read_text().replace("masses:", own))
    robot = load_robot(path)
    assert [robot.motor(joint).torque_max for joint in range(1, 7)] == [150] * 3 + [5] * 3
    assert "maker+rotors" not in robot.models  # those of its own size are unknown


def test_the_last_joint_of_the_smallest_arms_turns_without_limit() -> None:
    for name in FAMILY:
        limited = np.isfinite(load_robot(robot_path(name)).position_limits()).all(axis=1)
        assert limited.tolist() == [True] * 5 + [name not in ("ur3", "ur3e")]


# Export


def test_export_prints_the_chosen_model() -> None:
    def export(*arguments: str) -> str:
        command = ["export", "--robot", "ur5e", *arguments]
        return CliRunner().invoke(app, command, catch_exceptions=False).stdout

    assert export() == export("--model", "maker")
    assert pinocchio.buildModelFromXML(export()).nv == 6
