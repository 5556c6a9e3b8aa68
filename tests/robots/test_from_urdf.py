"""Arms described from their URDF: the dynamics of Pinocchio and MuJoCo on the same file."""

from pathlib import Path
from xml.etree.ElementTree import Element, SubElement, fromstring, tostring

import mujoco
import numpy as np
import pinocchio
import pytest

from ur5lib.commands.described import describe_urdf
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.robots.description import load_robot, robot_yaml
from ur5lib.robots.exports import urdf
from ur5lib.robots.from_urdf import robot_from_urdf
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.mjcf import mjcf
from ur5lib.robots.statics import flange_kinematics
from ur5lib.stand.plan import Standstill
from ur5lib.stand.trajectories import plan_targets
from ur5lib.timeseries.arrays import Array


def text(values: Array) -> str:
    return " ".join(map(repr, np.asarray(values, float).tolist()))


def add_link(root: Element, name: str, random: np.random.Generator) -> None:
    """A link of 0.2 to 3 kg with an inertia tensor without symmetry, turned and off its frame."""
    mass, part = random.uniform(0.2, 3.0), random.uniform(0.02, 0.1, (4, 3))
    second = part.T @ part * mass / 4
    inertia = np.trace(second) * np.eye(3) - second  # of mass points: as a body may have
    inertial = SubElement(SubElement(root, "link", name=name), "inertial")
    place = random.uniform(-0.1, 0.1, 3), random.uniform(-3, 3, 3)
    SubElement(inertial, "origin", xyz=text(place[0]), rpy=text(place[1]))
    SubElement(inertial, "mass", value=repr(mass))
    names = zip(
        ("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), inertia[np.triu_indices(3)], strict=True
    )
    SubElement(inertial, "inertia", {name: repr(float(value)) for name, value in names})


def add_joint(
    root: Element, name: str, links: tuple[str, str], kind: str, random: np.random.Generator
) -> Element:
    joint = SubElement(root, "joint", name=name, type=kind)
    place = random.uniform(-0.4, 0.4, 3), random.uniform(-3, 3, 3)
    SubElement(joint, "origin", xyz=text(place[0]), rpy=text(place[1]))
    SubElement(joint, "parent", link=links[0])
    SubElement(joint, "child", link=links[1])
    if kind != "fixed":
        SubElement(joint, "limit", lower="-2.5", upper="2.5", effort="50", velocity="2")
        SubElement(joint, "axis", xyz=text(random.normal(size=3)))
    return joint


def made_up(count: int) -> Element:
    """A chain with any axes, a pedestal, brackets fixed between its joints, and a fixed tool."""
    root, random, last = (
        Element("robot", name=f"made up {count}"),
        np.random.default_rng(count),
        "base",
    )
    add_link(root, last, random)
    for k in range(1, count + 1):
        add_link(root, f"bracket_{k}", random)
        add_joint(root, f"screw_{k}", (last, f"bracket_{k}"), "fixed", random)
        add_link(root, last := f"link_{k}", random)
        add_joint(root, f"axis_{k}", (f"bracket_{k}", last), "revolute", random)
    add_link(root, "tool", random)
    add_joint(root, "flange", (last, "tool"), "fixed", random)
    return root


def saved(root: Element, folder: Path) -> Path:
    path = folder / "arm.urdf"
    path.write_bytes(tostring(root))
    return path


def planar(count: int) -> Element:
    """Rods of 1 kg and 0.4 m that turn about y, as a pendulum."""
    root = fromstring("<robot name='planar'><link name='base'/></robot>")
    for k in range(1, count + 1):
        parent, height = f"rod_{k - 1}" if k > 1 else "base", 0.4 if k > 1 else 0.0
        rod = f"""<r><link name='rod_{k}'><inertial><origin xyz='0 0 0.2'/><mass value='1'/>
            <inertia ixx='0.013' iyy='0.013' izz='0.001' ixy='0' ixz='0' iyz='0'/></inertial></link>
            <joint name='swing_{k}' type='continuous'><origin xyz='0 0 {height}'/>
            <parent link='{parent}'/><child link='rod_{k}'/><axis xyz='0 1 0'/>
            <limit effort='20' velocity='3'/></joint></r>"""
        root.extend(fromstring(rod))
    return root


@pytest.mark.parametrize("count", [2, 6, 7, 8])
def test_dynamics_are_those_of_the_file(count: int, tmp_path: Path) -> None:
    path = saved(made_up(count), tmp_path)
    robot, _ = robot_from_urdf(path, tip="tool")
    q, qd, qdd = np.random.default_rng(0).uniform(-3, 3, (3, 200, count))
    ours = LinkModel(robot, "maker").inverse_dynamics(q, qd, qdd)

    engine = pinocchio.buildModelFromUrdf(str(path))
    data, frame = engine.createData(), engine.getFrameId("tool")
    theirs = [pinocchio.rnea(engine, data, *row) for row in zip(q, qd, qdd, strict=True)]
    np.testing.assert_allclose(ours, theirs, atol=1e-9)
    rotation, _, jacobian = flange_kinematics(robot, q)
    start, _, _ = flange_kinematics(robot, 0 * q[:1])
    for k in range(20):
        pinocchio.framesForwardKinematics(engine, data, q[k])
        place = data.oMf[frame].copy()
        pinocchio.framesForwardKinematics(engine, data, 0 * q[k])
        base = data.oMf[frame].rotation @ start[0].T  # axes of our base frame in those of the file
        np.testing.assert_allclose(base @ rotation[k], place.rotation, atol=1e-9)
        local = pinocchio.computeFrameJacobian(engine, data, q[k], frame, pinocchio.LOCAL)
        turned = np.kron(np.eye(2), rotation[k].T) @ jacobian[k]
        np.testing.assert_allclose(turned, local, atol=1e-9)


@pytest.mark.parametrize("count", [2, 6, 7, 8])
def test_mujoco_agrees(count: int, tmp_path: Path) -> None:
    for root in (made_up(count), planar(count)):
        path = saved(root, tmp_path)
        robot, _ = robot_from_urdf(path)
        engine = mujoco.MjModel.from_xml_path(str(path))
        engine.opt.disableflags = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        data = mujoco.MjData(engine)
        for q, qd, qdd in np.random.default_rng(1).uniform(-2, 2, (20, 3, count)):
            data.qpos, data.qvel, data.qacc = q, qd, qdd
            mujoco.mj_inverse(engine, data)
            ours = LinkModel(robot, "maker").inverse_dynamics(q[None], qd[None], qdd[None])[0]
            np.testing.assert_allclose(ours, data.qfrc_inverse, atol=1e-6)


def test_a_description_is_written_and_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    path = saved(made_up(7), tmp_path)
    monkeypatch.chdir(tmp_path)
    describe_urdf(path, None, "tool", "mine")
    assert load_robot("robots/mine.yaml").joints == tuple(f"axis_{k}" for k in range(1, 8))
    for name in ("mine", "ur5", "../mine"):
        with pytest.raises(InputError):
            describe_urdf(path, None, None, name)


def test_a_name_with_a_line_break_writes_no_key(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = saved(made_up(3), tmp_path)
    path.write_text(path.read_text().replace('<joint name="', '<joint name="a&#10;mass: 9'))
    with pytest.raises(InputError, match="control character"):
        describe_urdf(path, None, "tool", "mine")
    assert not (tmp_path / "robots").exists()


def test_endless_joints_and_limits_are_read(tmp_path: Path) -> None:
    robot, _ = robot_from_urdf(saved(planar(2), tmp_path))
    assert robot.endless_joints == [1, 2]
    assert np.isinf(robot.position_limits()).all()
    assert [robot.motor(k).torque_max for k in robot.joint_numbers] == [20.0, 20.0]


def test_a_range_to_one_side_is_that_of_the_file(tmp_path: Path) -> None:
    """In its description, its exports, and what the stand refuses."""
    root = made_up(2)
    limit = next(root.iter("limit"))
    limit.set("lower", "-3")
    limit.set("upper", "-0.1")
    robot, _ = robot_from_urdf(saved(root, tmp_path))
    written = tmp_path / "arm.yaml"
    written.write_text(robot_yaml(robot))
    ends = [(-3.0, -0.1), (-2.5, 2.5)]
    assert load_robot(written).position_limits() == robot.position_limits() == ends
    (tmp_path / "arm.urdf").write_text(urdf(robot, rigid_bodies(robot, "maker"), None))
    assert robot_from_urdf(tmp_path / "arm.urdf")[0].position_limits() == ends
    model = mujoco.MjModel.from_xml_string(mjcf(robot, "maker", None))
    np.testing.assert_allclose(model.jnt_range, ends)
    still = Standstill(kind="standstill", posture=(0.0, 0.0))
    with pytest.raises(InputError, match=r"joint 1 of .* to 0 rad, beyond its limit of -0\.1"):
        plan_targets(still, robot, np.arange(0, 1, 0.1))


def test_the_base_frame_lies_beside_the_base_links_origin(tmp_path: Path) -> None:
    """On the first axis; where the joint's own origin is along it does not matter."""
    root = planar(2)
    joint = next(j for j in root.iter("joint") if j.get("name") == "swing_1")
    origins = []
    for along in (0.0, 0.7):
        joint.find("origin").set("xyz", f"0.1 {along} 0.2")
        robot, remarks = robot_from_urdf(saved(root, tmp_path))
        assert "base frame at 0.1, 0, 0.2 m of base" in remarks[0]
        origins.append(flange_kinematics(robot, np.zeros((1, 2)))[1][0])
    np.testing.assert_allclose(origins[1] - origins[0], [0, 0, 0.7], atol=1e-12)


def test_what_moves_beside_the_chain_is_held(tmp_path: Path) -> None:
    """A gripper's finger weighs on the last link, at its position zero, and is named."""
    root, random = made_up(3), np.random.default_rng(3)
    without, _ = robot_from_urdf(saved(root, tmp_path))
    add_link(root, "finger", random)
    add_joint(root, "grip", ("tool", "finger"), "prismatic", random)
    robot, remarks = robot_from_urdf(saved(root, tmp_path))
    assert robot.joints == without.joints
    assert robot.masses[-1] > without.masses[-1]
    assert any("grip" in remark for remark in remarks)


def damaged(part: str) -> Element:
    root = made_up(2)
    for parent in [*root.iter()]:
        for child in [child for child in parent if child.tag == part]:
            parent.remove(child)
    return root


@pytest.mark.parametrize(
    ("root", "named"),
    [
        (damaged("limit"), "axis_1.*axis_2"),
        (damaged("joint"), "--base"),
        (made_up(1), "1 joints"),
        (made_up(9), "9 joints"),
        (Element("mujoco"), "arm.urdf"),
    ],
)
def test_what_is_missing_is_named(root: Element, named: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=named):
        robot_from_urdf(saved(root, tmp_path))


@pytest.mark.parametrize(
    ("found", "written", "named"),
    [
        ('link name="link_2"', 'link name="link_1"', "link 'link_1' twice"),
        ('joint name="axis_2"', 'joint name="axis_1"', "joint 'axis_1' twice"),
        ('child link="link_2"', 'child link="nothing"', "the child of axis_2, 'nothing', is none"),
        ("</robot>", '<link name="alone" /></robot>', "base, alone; .* --base"),
        ('mass value="', 'mass value="${m}', "run xacro"),
        ("robot", "html", "holds <html>"),
        ('upper="2.5"', 'upper="one"', "is no URDF"),
        ('<axis xyz="', '<axis xyz="nan 0 0" was="', "`xyz` in the <axis> of axis_1 is 'nan 0 0'"),
        ('<origin xyz="', '<origin xyz="0 -inf 0" was="', "`xyz` in the <origin> of base is"),
        ('ixy="', 'ixy="nan" was="', "`ixy` in the <inertia> of base is 'nan'; give a number"),
        ('upper="2.5"', 'upper="1e999"', "`upper` in the <limit> of axis_1"),
    ],
)
def test_what_is_wrong_in_a_file_is_named(
    found: str, written: str, named: str, tmp_path: Path
) -> None:
    path = saved(made_up(3), tmp_path)
    content = path.read_text()
    assert found in content
    path.write_text(content.replace(found, written))
    with pytest.raises(InputError, match=named):
        robot_from_urdf(path)


@pytest.mark.parametrize(
    ("tag", "values", "said"),
    [
        ("limit", {"lower": "-180", "upper": "180"}, "is it in degrees?"),
        ("origin", {"xyz": "0 0 400"}, "are they in mm?"),
        ("inertia", {"ixx": "-3"}, "no mass or inertia of a body for link_1, link_2"),
    ],
)
def test_what_is_unlikely_in_a_file_is_said(
    tag: str, values: dict[str, str], said: str, tmp_path: Path
) -> None:
    root = made_up(3)
    for part in root.iter(tag):
        part.attrib |= values
    assert any(said in remark for remark in robot_from_urdf(saved(root, tmp_path))[1])


@pytest.mark.parametrize(
    ("change", "named"),
    [({"type": "prismatic"}, "axis_2 is prismatic"), ({"axis": "0 0 0"}, "`axis` of axis_2")],
)
def test_a_joint_that_cannot_turn_is_named(
    change: dict[str, str], named: str, tmp_path: Path
) -> None:
    root = made_up(3)
    joint = next(joint for joint in root.iter("joint") if joint.get("name") == "axis_2")
    joint.set("type", change.get("type", "revolute"))
    next(joint.iter("axis")).attrib["xyz"] = change.get("axis", "0 0 1")
    with pytest.raises(InputError, match=named):
        robot_from_urdf(saved(root, tmp_path))


def test_a_joint_that_follows_another_is_refused_on_the_way_to_the_tip(tmp_path: Path) -> None:
    """A parallelogram of the arm itself, unlike the fingers of a gripper beyond it."""
    root = made_up(4)
    joints = {joint.get("name"): joint for joint in root.iter("joint")}
    mimic = SubElement(joints["axis_4"], "mimic", joint="axis_1")
    assert len(robot_from_urdf(saved(root, tmp_path))[0].joints) == 3
    joints["axis_4"].remove(mimic)
    SubElement(joints["axis_2"], "mimic", joint="axis_1")
    with pytest.raises(InputError, match="axis_2 follows another"):
        robot_from_urdf(saved(root, tmp_path))


@pytest.mark.parametrize("part", ["inertia", "inertial"])
def test_links_without_inertia_are_found_from_recordings(part: str, tmp_path: Path) -> None:
    robot, remarks = robot_from_urdf(saved(damaged(part), tmp_path))
    assert robot.links == "unknown"
    assert any("link_1, link_2" in remark for remark in remarks)


def test_links_fixed_to_each_other_may_be_many(tmp_path: Path) -> None:
    """Long chains and circles of fixed links end no less than others do."""
    root, random, last = planar(2), np.random.default_rng(0), "rod_2"
    for k in range(1500):
        SubElement(root, "link", name=f"part_{k}")
        add_joint(root, f"screw_{k}", (last, f"part_{k}"), "fixed", random)
        last = f"part_{k}"
    assert len(robot_from_urdf(saved(root, tmp_path), tip=last)[0].joints) == 2
    add_joint(root, "circle", (last, "part_0"), "fixed", random)
    with pytest.raises(InputError, match="does not hang on base"):
        robot_from_urdf(saved(root, tmp_path), tip=last)
    assert len(robot_from_urdf(saved(root, tmp_path), tip="rod_2")[0].joints) == 2


def test_a_folder_of_recordings_is_led_to_import(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="is a folder; name a URDF, or import recordings"):
        robot_from_urdf(tmp_path)


def test_equal_masses_are_placeholders(tmp_path: Path) -> None:
    root = made_up(3)
    assert robot_from_urdf(saved(root, tmp_path))[0].links == "known"
    for mass in root.iter("mass"):
        mass.set("value", "2.0")
    robot, _ = robot_from_urdf(saved(root, tmp_path), tip="link_3")
    assert (robot.links, robot.weight) == ("unknown", None)


def test_a_tool_on_the_last_of_equal_links_leaves_them_placeholders(tmp_path: Path) -> None:
    root = made_up(6)
    others = [*root.iter("mass")][:-1]
    for mass in others:
        mass.set("value", "0.3")  # twice, of a bracket, too
    robot, remarks = robot_from_urdf(saved(root, tmp_path))
    assert robot.links == "unknown"
    assert any("each link but the last weighs 0.6 kg" in remark for remark in remarks)


def test_limits_of_effort_and_velocity_that_lack_are_said(tmp_path: Path) -> None:
    root = made_up(2)
    for limit in root.iter("limit"):
        limit.attrib |= {"effort": "0", "velocity": "0"}
    _, remarks = robot_from_urdf(saved(root, tmp_path))
    assert [remark.split(" in ")[0] for remark in remarks[-2:]] == ["no effort", "no velocity"]


def test_gears_and_rotors_that_no_urdf_has_are_told_in_one_line(tmp_path: Path) -> None:
    robot, remarks = robot_from_urdf(saved(planar(2), tmp_path))
    (told,) = (remark for remark in remarks if "rotor" in remark)
    assert all(words in told for words in (", ".join(robot.joints), "gear_ratio", "effort"))
    assert robot.effort == "torque"  # nobody said on which side they are


def test_two_arms_ask_for_one(tmp_path: Path) -> None:
    root, random = made_up(2), np.random.default_rng(9)
    for k, parent in enumerate(["base", "other_1"], 1):
        add_link(root, f"other_{k}", random)
        add_joint(root, f"other_axis_{k}", (parent, f"other_{k}"), "revolute", random)
    path = saved(root, tmp_path)
    with pytest.raises(InputError, match=r"--tip: .*link_2, .*other_2"):
        robot_from_urdf(path)
    assert len(robot_from_urdf(path, tip="other_2")[0].joints) == 2


def test_prismatic_joints_are_refused(tmp_path: Path) -> None:
    root = made_up(2)
    next(j for j in root.iter("joint") if j.get("name") == "axis_1").set("type", "prismatic")
    with pytest.raises(InputError, match="axis_1 is prismatic"):
        robot_from_urdf(saved(root, tmp_path), tip="link_2")
