"""Exports of an arm: URDF (for pytorch-kinematics, too), SDF of Gazebo, actuators of Isaac Lab."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from xml.etree.ElementTree import Comment, Element, SubElement, indent, tostring

import yaml

from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import RigidBodies, link_tail, rigid_bodies
from ur5lib.timeseries.arrays import Array

SDF_VERSION = "1.9"
FRICTION_NOTE = (
    "Of the identified friction, Coulomb and viscous friction that come closest to it; root and "
    "square of the velocity, friction by load and its reversal over a distance have no element."
)
STICK_RADIUS = 0.03  # m
ISAAC_HEAD = """\
# Fields of ImplicitActuatorCfg in Isaac Lab 2, for the joints of `ur5 export --format urdf`.
# Units: Nm, rad/s, kg m2, Nm s/rad; friction is in Nm since Isaac Sim 5.
# The joints are driven by torque: for control of position, set stiffness and damping.
"""


@dataclass(frozen=True)
class JointFriction:
    """Friction in the form of simulators, (n,) each: coulomb [Nm], viscous [Nm s/rad].

    NaN for joints that moved too little. share: of the mean square of the identified friction in
    motion, the part that these two terms have; the rest is of terms that no simulator has.
    """

    coulomb: Array
    viscous: Array
    share: Array

    def coefficients(self, joint: int) -> tuple[float, float] | None:
        """Return Coulomb and viscous friction of a joint, from 1; None where unknown."""
        pair = float(self.coulomb[joint - 1]), float(self.viscous[joint - 1])
        return None if any(map(math.isnan, pair)) else pair

    def note(self) -> str:
        """Return a sentence on the share of the identified friction that a simulator has."""
        shares = ", ".join("-" if math.isnan(own) else f"{own:.1%}" for own in self.share)
        return f"{FRICTION_NOTE} Joints from 1 have so much of its mean square in motion: {shares}."


def urdf(robot: Robot, bodies: RigidBodies, friction: JointFriction | None = None) -> str:
    """Return an arm as URDF, with friction as `dynamics` of its joints.

    The base is `frame_0`; for k = 1 to n, `joint_k` turns `link_k`, which has the mass, and its
    Denavit-Hartenberg frame `frame_k` lies at the far end of the link. Viewers draw each link as a
    stick. URDF has no element for rotor inertias: set them as `model.armature` in Pinocchio and
    `model.dof_armature` in MuJoCo, followed by `mj_setConst`.
    """
    root = Element("robot", name=robot.name)
    _add_note(root, friction)
    SubElement(root, "link", name="frame_0")
    for k, pose in zip(robot.joint_numbers, robot.link_poses(), strict=True):
        link = SubElement(root, "link", name=f"link_{k}")
        inertial = SubElement(link, "inertial")
        center, rpy = _center(robot, bodies, k), _text(pose.rpy)
        SubElement(inertial, "origin", xyz=_text(center), rpy=rpy)
        SubElement(inertial, "mass", value=_text([bodies.mass[k - 1]]))
        SubElement(inertial, "inertia", _inertia(bodies, k))
        _add_stick(link, pose.position)
        limit = _limit(robot, k)
        kind = "revolute" if "upper" in limit else "continuous"
        joint = _urdf_joint(root, f"joint_{k}", kind, f"frame_{k - 1}", f"link_{k}")
        SubElement(joint, "origin", xyz="0 0 0", rpy="0 0 0")
        SubElement(joint, "axis", xyz="0 0 1")
        SubElement(joint, "limit", limit)
        if dynamics := _friction(friction, k):
            SubElement(joint, "dynamics", dynamics)
        SubElement(root, "link", name=f"frame_{k}")
        end = _urdf_joint(root, f"frame_{k}_fixed", "fixed", f"link_{k}", f"frame_{k}")
        SubElement(end, "origin", xyz=_text(pose.position), rpy=rpy)
    return _xml(root)


def sdf(robot: Robot, bodies: RigidBodies, friction: JointFriction | None = None) -> str:
    """Return an arm as an SDF model, fixed to the world.

    Names are those of the URDF: `joint_k` turns `link_k` about its z axis, and the
    Denavit-Hartenberg frame `frame_k` lies at the far end of the link. Gravity belongs to the
    world, in which an arm on a wall has to be turned. SDF has no element for rotor inertias.
    """
    root = Element("sdf", version=SDF_VERSION)
    _add_note(root, friction)
    arm = SubElement(root, "model", name=robot.name)
    SubElement(arm, "link", name="frame_0")
    _sdf_joint(arm, "base", "fixed", "world", "frame_0")
    for k, pose in zip(robot.joint_numbers, robot.link_poses(), strict=True):
        link = SubElement(arm, "link", name=f"link_{k}")
        SubElement(link, "pose", relative_to=f"frame_{k - 1}").text = _text([0.0] * 6)
        inertial = SubElement(link, "inertial")
        SubElement(inertial, "pose").text = _text([*_center(robot, bodies, k), *pose.rpy])
        SubElement(inertial, "mass").text = _text([bodies.mass[k - 1]])
        _add_texts(SubElement(inertial, "inertia"), _inertia(bodies, k))
        parent = f"link_{k - 1}" if k > 1 else "frame_0"
        axis = SubElement(_sdf_joint(arm, f"joint_{k}", "revolute", parent, f"link_{k}"), "axis")
        SubElement(axis, "xyz").text = "0 0 1"
        _add_texts(SubElement(axis, "limit"), _limit(robot, k))
        if dynamics := _friction(friction, k):
            _add_texts(SubElement(axis, "dynamics"), dynamics)
        frame = SubElement(arm, "frame", name=f"frame_{k}", attached_to=f"link_{k}")
        SubElement(frame, "pose").text = _text([*pose.position, *pose.rpy])
    return _xml(root)


def isaac(robot: Robot, model: str, friction: JointFriction | None) -> str:
    """Return the joints of an arm as YAML: `arm` has the fields of Isaac Lab's actuators.

    The rotors of a link model are `armature`; Coulomb friction is `friction` (at rest) and
    `dynamic_friction`. Friction is left out where it is unknown.
    """
    motors = [robot.motor(k) for k in robot.joint_numbers]
    names = [f"joint_{k}" for k in robot.joint_numbers]
    fields: dict[str, Sequence[float] | Array] = {
        "effort_limit_sim": [motor.torque_max for motor in motors],
        "velocity_limit_sim": [motor.velocity_max for motor in motors],
        "stiffness": [0.0 for _ in motors],
        "damping": [0.0 for _ in motors],
        "armature": rigid_bodies(robot, model).rotor_inertia,
    }
    if friction is not None:
        coulomb, viscous = friction.coulomb, friction.viscous
        fields |= {"friction": coulomb, "dynamic_friction": coulomb, "viscous_friction": viscous}
    by_joint = {
        name: {k: float(v) for k, v in zip(names, values, strict=True) if not math.isnan(v)}
        for name, values in fields.items()
    }
    arm = {"joint_names_expr": names, **by_joint}
    note = "" if friction is None else f"# {friction.note()}\n"
    return ISAAC_HEAD + note + yaml.safe_dump({"arm": arm}, sort_keys=False)


def _add_note(root: Element, friction: JointFriction | None) -> None:
    """Add a comment on the share of the identified friction that is written."""
    if friction is not None:
        root.append(Comment(f" {friction.note()} "))


def _urdf_joint(root: Element, name: str, kind: str, parent: str, child: str) -> Element:
    joint = SubElement(root, "joint", name=name, type=kind)
    SubElement(joint, "parent", link=parent)
    SubElement(joint, "child", link=child)
    return joint


def _add_stick(link: Element, end: Sequence[float]) -> None:
    """Add a link's drawing for viewers: a cylinder from its near to its far end (3,) [m]."""
    x, y, z = end
    length = math.hypot(x, y, z)
    if length > 0:
        visual = SubElement(link, "visual")
        rpy = 0.0, math.acos(z / length), math.atan2(y, x)
        SubElement(visual, "origin", xyz=_text([x / 2, y / 2, z / 2]), rpy=_text(rpy))
        size = {"radius": _text([STICK_RADIUS]), "length": _text([length])}
        SubElement(SubElement(visual, "geometry"), "cylinder", size)


def _sdf_joint(arm: Element, name: str, kind: str, parent: str, child: str) -> Element:
    joint = SubElement(arm, "joint", name=name, type=kind)
    _add_texts(joint, {"parent": parent, "child": child})
    return joint


def _center(robot: Robot, bodies: RigidBodies, k: int) -> Array:
    """Return the centre of mass (3,) [m] of link k in the frame `link_k` at its near end."""
    rotation, translation = link_tail(robot.link_poses()[k - 1])
    return translation + rotation @ bodies.center_of_mass[k - 1]


def _inertia(bodies: RigidBodies, k: int) -> dict[str, str]:
    """Return the entries of the inertia tensor of link k by their names in URDF and SDF."""
    full = bodies.inertia[k - 1]
    pairs = [(i, j) for i in range(3) for j in range(i, 3)]
    return {f"i{'xyz'[i]}{'xyz'[j]}": _text([full[i, j]]) for i, j in pairs}


def _limit(robot: Robot, k: int) -> dict[str, str]:
    """Return the limits of joint k; an endless joint has no limits of position."""
    motor, (low, high) = robot.motor(k), robot.position_limits()[k - 1]
    bounds = {"lower": low, "upper": high} if math.isfinite(high) else {}
    limits = bounds | {"effort": motor.torque_max, "velocity": motor.velocity_max}
    return {name: _text([value]) for name, value in limits.items()}


def _friction(friction: JointFriction | None, k: int) -> dict[str, str]:
    """Return the friction of joint k, empty where it is unknown."""
    coefficients = friction and friction.coefficients(k)
    return (
        {"damping": _text([coefficients[1]]), "friction": _text([coefficients[0]])}
        if coefficients
        else {}
    )


def _text(values: Iterable[float]) -> str:
    """Return numbers as text for XML, with all digits."""
    return " ".join(repr(float(value)) for value in values)


def _add_texts(parent: Element, texts: Mapping[str, str]) -> None:
    for name, text in texts.items():
        SubElement(parent, name).text = text


def _xml(root: Element) -> str:
    indent(root)
    return tostring(root, encoding="unicode")
