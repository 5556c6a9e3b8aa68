"""Export of an arm as SDF, the model format of Gazebo."""

import math
from collections.abc import Mapping
from xml.etree.ElementTree import Element, SubElement, indent, tostring

from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import RigidBodies, rigid_bodies
from ur5lib.robots.joint_friction import JointFriction
from ur5lib.robots.urdf import inertia_entries, link_tail, numbers

VERSION = "1.9"


def sdf(robot: Robot, model: str, friction: JointFriction | None) -> str:
    """Return an arm with one of its link models as an SDF model, fixed to the world.

    Names are those of the URDF: `joint_k` turns `link_k` about its z axis, and the
    Denavit-Hartenberg frame `frame_k` lies at the far end of the link. Gravity belongs to the
    world, in which an arm on a wall has to be turned. SDF has no element for rotor inertias.
    """
    bodies = rigid_bodies(robot, model)
    root = Element("sdf", version=VERSION)
    arm = SubElement(root, "model", name=robot.name)
    SubElement(arm, "link", name="frame_0")
    _add_joint(arm, "base", "fixed", "world", "frame_0")
    for k in robot.joint_numbers:
        _add_link(arm, k, robot, bodies)
        joint = _add_joint(arm, f"joint_{k}", "revolute", _parent(k), f"link_{k}")
        _add_axis(joint, k, robot, friction)
        frame = SubElement(arm, "frame", name=f"frame_{k}", attached_to=f"link_{k}")
        pose = robot.link_poses()[k - 1]
        SubElement(frame, "pose").text = numbers([*pose.position, *pose.rpy])
    indent(root)
    return tostring(root, encoding="unicode")


def _parent(k: int) -> str:
    return f"link_{k - 1}" if k > 1 else "frame_0"


def _add_link(arm: Element, k: int, robot: Robot, bodies: RigidBodies) -> None:
    pose = robot.link_poses()[k - 1]
    rotation, translation = link_tail(pose)
    center = translation + rotation @ bodies.center_of_mass[k - 1]
    link = SubElement(arm, "link", name=f"link_{k}")
    SubElement(link, "pose", relative_to=f"frame_{k - 1}").text = numbers([0.0] * 6)
    inertial = SubElement(link, "inertial")
    SubElement(inertial, "pose").text = numbers([*center, *pose.rpy])
    _add_numbers(inertial, {"mass": bodies.mass[k - 1]})
    _add_numbers(SubElement(inertial, "inertia"), inertia_entries(bodies.inertia[k - 1]))


def _add_joint(arm: Element, name: str, kind: str, parent: str, child: str) -> Element:
    joint = SubElement(arm, "joint", name=name, type=kind)
    SubElement(joint, "parent").text = parent
    SubElement(joint, "child").text = child
    return joint


def _add_axis(joint: Element, k: int, robot: Robot, friction: JointFriction | None) -> None:
    axis, motor, end = SubElement(joint, "axis"), robot.motor(k), robot.position_limits()[k - 1]
    SubElement(axis, "xyz").text = "0 0 1"
    bounds = {"lower": -end, "upper": end} if math.isfinite(end) else {}
    limit = bounds | {"effort": motor.torque_max, "velocity": motor.velocity_max}
    _add_numbers(SubElement(axis, "limit"), limit)
    if friction is not None and (known := friction.coefficients(k)):
        coulomb, viscous = known
        _add_numbers(SubElement(axis, "dynamics"), {"damping": viscous, "friction": coulomb})


def _add_numbers(parent: Element, values: Mapping[str, float]) -> None:
    for name, value in values.items():
        SubElement(parent, name).text = numbers([value])
