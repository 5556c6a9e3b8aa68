"""An arm as other programs read it."""

import json
from pathlib import Path
from types import SimpleNamespace
from xml.etree import ElementTree

import mujoco
import numpy as np
import pinocchio
import pytest
import yaml

from tests.rigid import check_rigid
from tests.robots.test_from_urdf import made_up, saved
from ur5lib.commands.compensation import offset_of
from ur5lib.commands.described import describe_urdf
from ur5lib.commands.exported import WRITERS, exported, simulator_friction
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Torques
from ur5lib.records.motion import Motion
from ur5lib.records.sensor_offset import OffsetAccount
from ur5lib.robots.description import Payload, Robot, load_robot, robot_names, robot_path
from ur5lib.robots.exports import JointFriction, isaac, sdf, urdf
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.robots.inertia import rigid_bodies, written_bodies
from ur5lib.robots.mjcf import mjcf
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array

JOINTS = [f"joint_{k}" for k in range(1, 7)]
RANDOM = np.random.default_rng(3)
STATES = RANDOM.uniform(-1.5, 1.5, (3, 40, 6))
FRICTION = JointFriction(np.arange(1.0, 7.0), np.linspace(0.5, 3, 6), np.linspace(0.9, 1, 6))
GRAVITY = np.array([1.0, -2.0, 9.0])


def motion(joints: int = 6) -> Motion:
    q, qd, qdd = STATES[..., np.arange(joints) % 6]
    time, std = 0.008 * np.arange(40), 0 * q
    known = {"q": q, "qd": qd, "qdd": qdd, "q_std": std, "qd_std": std, "qdd_std": std}
    known["motor_qd"] = qd
    return Motion(time=time, segment=np.zeros(40, dtype=np.int64), **known)


def replayed(robot: Robot, friction: JointFriction | None, folder: Path) -> Array:
    file = folder / "arm.xml"
    file.write_text(mjcf(robot, f"{robot.chosen_model}+rotors", friction))
    return torques_by_mujoco(file, motion(len(robot.joints)))


def torques_by_mujoco(file: Path, states: Motion) -> Array:
    """The inverse dynamics (N, n) [Nm] of a model file, without contacts and limits."""
    model = mujoco.MjModel.from_xml_path(str(file))
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    model.opt.gravity = GRAVITY  # a URDF has none
    data, torques = mujoco.MjData(model), []
    for data.qpos, data.qvel, data.qacc in zip(states.q, states.qd, states.qdd, strict=True):
        mujoco.mj_inverse(model, data)
        torques.append(data.qfrc_inverse.copy())
    return np.array(torques)


@pytest.mark.parametrize("name", ["ur5e", "ur10e", "ur20"])
def test_its_torques_are_this_project_s(name: str, tmp_path: Path) -> None:
    robot = load_robot(robot_path(name)).mounted(GRAVITY)
    robot = robot.carrying(Payload(mass=1.5, center_of_mass=(0.02, 0.0, 0.1)))
    expected = LinkModel(robot, f"{robot.chosen_model}+rotors").inverse_dynamics(*STATES)
    np.testing.assert_allclose(replayed(robot, None, tmp_path), expected, rtol=1e-4, atol=1e-3)


def test_an_arm_of_seven_joints_is_exported(tmp_path: Path) -> None:
    robot = robot_from_urdf(saved(made_up(7), tmp_path))[0].mounted(GRAVITY)
    bodies, states = rigid_bodies(robot, "maker"), motion(7)
    expected = LinkModel(robot, "maker").inverse_dynamics(states.q, states.qd, states.qdd)
    for text in (mjcf(robot, "maker", None), urdf(robot, bodies)):
        (tmp_path / "arm.xml").write_text(text)
        found = torques_by_mujoco(tmp_path / "arm.xml", states)
        np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-3)
    assert from_sdf(sdf(robot, bodies), 7).nv == 7


def test_placeholders_are_not_exported_unless_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    root = made_up(3)
    for mass in root.iter("mass"):
        mass.set("value", "1.0")
    describe_urdf(saved(root, tmp_path), None, "link_3", "mine")
    with pytest.raises(InputError, match=r"are placeholders .* --results .* --model maker"):
        exported("mine", None, "mjcf", None, "")
    assert exported("mine", "maker", "mjcf", None, "").startswith("<mujoco")


def test_its_friction_is_coulomb_and_viscous(tmp_path: Path) -> None:
    robot = load_robot(robot_path("ur5e")).mounted(GRAVITY)
    qd = STATES[1]
    added = replayed(robot, FRICTION, tmp_path) - replayed(robot, None, tmp_path)
    expected = FRICTION.coulomb * np.sign(qd) + FRICTION.viscous * qd
    moving = np.abs(qd) > 0.1  # at lower speeds, MuJoCo's dry friction gives way
    np.testing.assert_allclose(added[moving], expected[moving], atol=1e-3)


def test_friction_is_that_of_all_joints() -> None:
    """Of the predicted current, k⁻¹ (τ + friction) + offset, of seven joints, where they move and
    it is known: at rest, friction is anything.
    """
    random, coulomb, viscous = np.random.default_rng(1), np.arange(1.0, 8.0), np.linspace(0.5, 3, 7)
    qd, torque = random.normal(size=(2, 200, 7))
    qd[:20] *= 1e-6
    friction = coulomb * np.sign(qd) + viscous * qd
    friction[:20], friction[20:40] = 50 * random.normal(size=(20, 7)), np.nan
    coefficients = SimpleNamespace(coefficients=[0.1, 0.2])
    joints = [SimpleNamespace(estimate=coefficients)] * 7
    records = {
        Motion: SimpleNamespace(qd=qd),
        Torques: SimpleNamespace(measured={"maker": torque}, payload_torque=torque),
        Currents: SimpleNamespace(predicted=0.1 * (2 * torque + friction) + 0.2),
    }
    found = SimpleNamespace(from_=["run"], fit=SimpleNamespace(joints=joints))
    study = SimpleNamespace(parameters=lambda *_: found, record=lambda kind, _: records[kind])
    exported_friction = simulator_friction("mine", "maker", study)
    assert exported_friction is not None
    known = [coulomb, viscous, np.ones(7)]
    np.testing.assert_allclose([*vars(exported_friction).values()], known)


def test_urdf_has_the_same_friction() -> None:
    robot = load_robot(robot_path("ur5e"))
    text = urdf(robot, written_bodies(robot, robot.chosen_model), FRICTION)
    model = mujoco.MjModel.from_xml_string(text)
    np.testing.assert_array_equal(model.dof_frictionloss, FRICTION.coulomb)
    np.testing.assert_array_equal(np.reshape(model.dof_damping, (6, -1))[:, 0], FRICTION.viscous)


@pytest.mark.parametrize("unknown", [2, 6])
def test_unknown_friction_is_left_out(unknown: int) -> None:
    coulomb = np.where(np.arange(1, 7) == unknown, np.nan, FRICTION.coulomb)
    friction, robot = (
        JointFriction(coulomb, FRICTION.viscous, FRICTION.share),
        load_robot(robot_path("ur5e")),
    )
    bodies, others = rigid_bodies(robot, "maker"), {*JOINTS} - {f"joint_{unknown}"}
    for text, place in (
        (urdf(robot, bodies, friction), "dynamics"),
        (sdf(robot, bodies, friction), "axis/dynamics"),
    ):
        joints = ElementTree.fromstring(text).iter("joint")
        assert {joint.get("name") for joint in joints if joint.find(place) is not None} == others
    assert yaml.safe_load(isaac(robot, "maker", friction))["arm"]["friction"].keys() == others
    model = mujoco.MjModel.from_xml_string(mjcf(robot, "maker", friction))
    assert np.flatnonzero(model.dof_frictionloss == 0).tolist() == [unknown - 1]


# SDF, read by its specification: no engine here reads it


def placed(pose: str) -> pinocchio.SE3:
    """A pose of SDF: x y z [m], roll pitch yaw [rad]."""
    *position, roll, pitch, yaw = map(float, pose.split())
    return pinocchio.SE3(pinocchio.rpy.rpyToMatrix(roll, pitch, yaw), np.array(position))


def from_sdf(text: str, joints: int = 6) -> pinocchio.Model:
    """The arm of an SDF text, each link turned about the z axis of the frame that it stands in."""
    arm, model = ElementTree.fromstring(text).find("model"), pinocchio.Model()
    assert arm is not None
    frames = {frame.get("name"): frame.findtext("pose", "") for frame in arm.iter("frame")}
    below = pinocchio.SE3.Identity()
    for k in range(1, joints + 1):
        joint, link = arm.find(f"joint[@name='joint_{k}']"), arm.find(f"link[@name='link_{k}']")
        assert joint is not None
        assert link is not None
        assert joint.findtext("axis/xyz") == "0 0 1"
        assert joint.findtext("parent") == (f"link_{k - 1}" if k > 1 else "frame_0")
        assert link.find("pose").get("relative_to") == f"frame_{k - 1}"
        model.addJoint(k - 1, pinocchio.JointModelRZ(), below, f"joint_{k}")
        model.appendBodyToJoint(k, mass_of(link), placed(link.findtext("inertial/pose", "")))
        below = placed(frames[f"frame_{k}"])
    return model


def mass_of(link: ElementTree.Element) -> pinocchio.Inertia:
    """A link's mass and inertia, centred in its inertial pose."""
    i = {e.tag: float(e.text or "") for e in link.find("inertial/inertia") or []}
    tensor = [
        [i["ixx"], i["ixy"], i["ixz"]],
        [i["ixy"], i["iyy"], i["iyz"]],
        [i["ixz"], i["iyz"], i["izz"]],
    ]
    return pinocchio.Inertia(
        float(link.findtext("inertial/mass", "")), np.zeros(3), np.array(tensor)
    )


@pytest.mark.parametrize("name", ["ur5", "ur10e", "ur20"])
def test_sdf_has_the_same_torques(name: str) -> None:
    robot = load_robot(robot_path(name)).mounted(GRAVITY)
    robot = robot.carrying(Payload(mass=1.5, center_of_mass=(0.02, 0.0, 0.1)))
    engine = from_sdf(sdf(robot, rigid_bodies(robot, robot.chosen_model)))
    engine.gravity.linear = GRAVITY
    data, states = engine.createData(), zip(*STATES, strict=True)
    torque = [pinocchio.rnea(engine, data, q, qd, qdd) for q, qd, qdd in states]
    expected = LinkModel(robot, robot.chosen_model).inverse_dynamics(*STATES)
    np.testing.assert_allclose(torque, expected, atol=1e-7)


def test_sdf_has_limits_and_friction() -> None:
    robot = load_robot(robot_path("ur3e"))  # whose last joint turns without end
    root = ElementTree.fromstring(sdf(robot, rigid_bodies(robot, robot.chosen_model), FRICTION))
    axes = [*root.iter("axis")]
    assert root.get("version") == "1.9"
    upper = [axis.findtext("limit/upper") for axis in axes]
    expected = [None if np.isinf(end) else str(end) for _, end in robot.position_limits()]
    assert upper == expected
    assert None in expected
    for field, values in (("damping", FRICTION.viscous), ("friction", FRICTION.coulomb)):
        assert [float(axis.findtext(f"dynamics/{field}", "")) for axis in axes] == [*values]


# Others


@pytest.mark.parametrize("name", robot_names())
def test_links_can_exist(name: str) -> None:
    for model in load_robot(robot_path(name)).models:
        check_rigid(name, model)


def test_each_format_says_which_part_of_friction_it_has() -> None:
    """And of an arm as described, whose friction nobody identified, nothing."""
    robot = load_robot(robot_path("ur5e"))
    for to in ("urdf", "mjcf", "sdf", "isaac"):
        texts = [WRITERS[to](robot, "maker", friction, None) for friction in (FRICTION, None)]
        assert [FRICTION.note() in text for text in texts] == [True, False]
    assert "90.0%" in FRICTION.note()


def test_isaac_has_rotors_limits_and_friction() -> None:
    robot = load_robot(robot_path("ur10e"))
    model = robot.fullest_model()
    arm = yaml.safe_load(isaac(robot, model, FRICTION))["arm"]
    assert arm["joint_names_expr"] == JOINTS
    assert [*arm["armature"].values()] == [*rigid_bodies(robot, model).rotor_inertia]
    assert [*arm["friction"].values()] == [*FRICTION.coulomb] == [*arm["dynamic_friction"].values()]
    assert [*arm["viscous_friction"].values()] == [*FRICTION.viscous]
    assert arm["effort_limit_sim"]["joint_1"] == robot.motor(1).torque_max
    assert not yaml.safe_load(isaac(robot, model, None))["arm"].keys() & {"friction"}


def test_json_describes_an_arm_without_results() -> None:
    robot = load_robot(robot_path("ur5e"))
    known = json.loads(exported("ur5e", None, "json", None, ""))
    assert known["arm"]["denavit_hartenberg"][1]["a"] == robot.denavit_hartenberg[1].a
    bodies = rigid_bodies(robot, robot.chosen_model)
    np.testing.assert_allclose(known["link_model"]["center_of_mass"], bodies.center_of_mass)
    assert "base_parameters" not in known


def offset(mass: float, moment_arm: Array) -> OffsetAccount:
    """Errors of 0.01 kg and 0.001 kg m."""
    known = {"bias": np.zeros(6), "bias_std": np.ones(6), "noise": np.ones(6), "agreeing": 1.0}
    known |= {"rival": 0.0, "free": 1.0, "start_bias": np.zeros(6), "pull_at": np.zeros(3)}
    errors = {"mass_std": 0.01, "moment_arm_std": np.full(3, 0.001)}
    known |= errors | {"clock_std": 0.0, "inertia": None}
    return OffsetAccount(mass=mass, moment_arm=moment_arm, **known)


def test_a_centre_of_mass_has_the_errors_of_mass_and_moment() -> None:
    mass, arm = 0.4, np.array([0.0, 0.01, 0.02])
    centers = RANDOM.normal(arm, 0.001, (10_000, 3)) / RANDOM.normal(mass, 0.01, (10_000, 1))
    found = [*offset_of(offset(mass, arm))["center_of_mass"].values()]
    np.testing.assert_allclose([one["value"] for one in found], arm / mass)
    half = [(one["high"] - one["low"]) / 2 for one in found]
    np.testing.assert_allclose(half, 1.96 * centers.std(axis=0), rtol=0.05)
    assert {*offset_of(offset(0.01, arm))["center_of_mass"].values()} == {None}


@pytest.mark.parametrize("name", ["ur5e", "ur10", "kuka-kr300"])
def test_links_are_capsules_between_the_joints(name: str) -> None:
    """Of each link, from the frame before to its own; they touch a floor, and not one another."""
    robot = load_robot(robot_path(name))
    spec = mujoco.MjSpec.from_string(mjcf(robot, robot.chosen_model, None))
    spec.worldbody.add_geom(name="floor", type=mujoco.mjtGeom.mjGEOM_PLANE, size=[5, 5, 1])
    model = spec.compile()
    data = mujoco.MjData(model)
    data.qpos = q = np.linspace(0.4, -0.9, model.nq)
    mujoco.mj_forward(model, data)
    origins = link_frames(robot, q[None])[1]
    for k in range(model.nq):
        own = model.geom(f"link_{k + 1}")
        along = data.geom_xmat[own.id].reshape(3, 3)[:, 2] * own.size[1]
        ends = {tuple(np.round(data.geom_xpos[own.id] + side * along, 3)) for side in (-1, 1)}
        assert np.round(origins[0, k + 1], 3) in np.array([*ends])
    floor = model.geom("floor").id
    assert all(floor in contact.geom for contact in data.contact)
    assert model.body_mass.sum() == pytest.approx(
        np.sum(rigid_bodies(robot, robot.chosen_model).mass)
    )


def test_flange_and_tool_centre_point_are_sites() -> None:
    robot, tcp = load_robot(robot_path("ur5e")), (0.01, -0.02, 0.12, 0.0, 0.3, 0.0)
    model = mujoco.MjModel.from_xml_string(mjcf(robot, "maker", None, tcp))
    data = mujoco.MjData(model)
    data.qpos = q = np.array([0.3, -1.2, 1.4, -0.7, 1.1, 0.5])
    mujoco.mj_forward(model, data)
    rotations, origins = link_frames(robot, q[None])
    np.testing.assert_allclose(data.site("flange").xpos, origins[0, -1], atol=1e-5)
    np.testing.assert_allclose(data.site("flange").xmat.reshape(3, 3), rotations[0, -1], atol=1e-5)
    expected = origins[0, -1] + rotations[0, -1] @ tcp[:3]
    np.testing.assert_allclose(data.site("tcp").xpos, expected, atol=1e-5)


@pytest.mark.parametrize("to", ["mjcf", "urdf", "sdf", "isaac"])
def test_joints_have_the_names_of_ros_on_request(to: str) -> None:
    plain, named = (exported("ur5e", None, to, None, "", ros) for ros in (False, True))
    names = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
    for number, name in enumerate(names, start=1):
        plain = plain.replace(f"joint_{number}", f"{name}_joint")
    assert named == plain
    assert "wrist_3_joint" in named


def test_only_a_ur_has_joints_that_ros_names() -> None:
    with pytest.raises(InputError, match="leave out --ros-names"):
        exported("kuka-kr300", "placeholder", "mjcf", None, "", ros_names=True)


def test_limits_are_those_of_the_joints() -> None:
    robot = load_robot(robot_path("ur5e"))
    model = mujoco.MjModel.from_xml_string(mjcf(robot, "maker", None))
    np.testing.assert_allclose(model.jnt_range, robot.position_limits(), rtol=1e-5)
    most = [robot.motor(joint).torque_max for joint in range(1, 7)]
    np.testing.assert_allclose(model.actuator_ctrlrange[:, 1], most)


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"to": "usd"}, "available: urdf, mjcf, sdf, isaac, json, sensor"),
        ({"robot": "ur6"}, "no description"),
        ({"model": "Z"}, "no link model 'Z'"),
        ({"as_in": "pushed"}, "--results"),
        ({"to": "sensor"}, "--results"),
        ({"to": "live"}, "--results"),
        ({"results": Path("nowhere")}, "ur5 run"),
    ],
)
def test_what_is_not_there_is_reported(changed: dict[str, object], message: str) -> None:
    asked = {"robot": "ur5", "model": None, "to": "mjcf", "results": None, "as_in": ""}
    with pytest.raises(InputError, match=message):
        exported(**asked | changed)
