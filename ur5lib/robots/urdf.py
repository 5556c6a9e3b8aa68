"""Export of an arm as URDF, for pytorch-kinematics and other engines."""

import math
from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from ur5lib.robots.description import Pose, Robot
from ur5lib.robots.inertia import RigidBodies
from ur5lib.robots.joint_friction import JointFriction
from ur5lib.timeseries.arrays import Array


def link_tail(pose: Pose) -> tuple[Array, Array]:
    """Return rotation (3, 3) and translation (3,) [m] of a link's constant transform.

    It leads from a URDF joint's frame, at the near end of link k, to frame k at its far end:
    Trans_z(d) Trans_x(a) Rot_x(alpha) of Equation 2.19, unless the arm was calibrated.
    """
    (cr, cp, cy), (sr, sp, sy) = ([f(angle) for angle in pose.rpy] for f in (math.cos, math.sin))
    roll = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    pitch = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    yaw = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return yaw @ pitch @ roll + 0.0, np.array(pose.position)


def thick(inertia: Array, share: float = 1e-12) -> Array:
    """Return an inertia tensor that obeys the triangle inequality of a rigid body.

    Principal moments obey A + B >= C. For a flat plate A + B = C, which rounding can violate, and
    MuJoCo rejects the link. In that case all moments are raised by `share` of their sum, or, for a
    point mass, by `share` kg m².
    """
    slack = np.trace(inertia) - 2 * np.linalg.eigvalsh(inertia)[-1]
    margin = share * (np.trace(inertia) or 1.0)
    return inertia if slack > margin else inertia + margin * np.eye(3)


def urdf(robot: Robot, bodies: RigidBodies, friction: JointFriction | None = None) -> str:
    """Return an arm as URDF, with friction as `dynamics` of its joints.

    The base is `frame_0`; for k = 1 to n, `joint_k` turns `link_k`, which has the mass, and its
    Denavit-Hartenberg frame `frame_k` lies at the far end of the link. URDF has no element for
    rotor inertias: set them as `model.armature` in Pinocchio and `model.dof_armature` in MuJoCo.
    """
    root = Element("robot", name=robot.name)
    SubElement(root, "link", name="frame_0")
    for k in robot.joint_numbers:
        _add_link(root, k, robot, bodies)
        _add_joint(root, k, robot, friction)
        _add_frame(root, k, robot)
    indent(root)
    return tostring(root, encoding="unicode")


def numbers(values: Iterable[float]) -> str:
    """Return numbers as text for XML, with all digits."""
    return " ".join(repr(float(value)) for value in values)


def _add_link(root: Element, k: int, robot: Robot, bodies: RigidBodies) -> None:
    pose = robot.link_poses()[k - 1]
    rotation, translation = link_tail(pose)
    center = translation + rotation @ bodies.center_of_mass[k - 1]
    entries = inertia_entries(bodies.inertia[k - 1])
    inertial = SubElement(SubElement(root, "link", name=f"link_{k}"), "inertial")
    SubElement(inertial, "origin", xyz=numbers(center), rpy=numbers(pose.rpy))
    SubElement(inertial, "mass", value=numbers([bodies.mass[k - 1]]))
    SubElement(inertial, "inertia", {name: numbers([value]) for name, value in entries.items()})


def inertia_entries(inertia: Array) -> dict[str, float]:
    """Return the entries of an inertia tensor (3, 3) by their names in URDF and SDF."""
    full = thick(inertia)
    pairs = {a + b: full["xyz".index(a), "xyz".index(b)] for a in "xyz" for b in "xyz" if a <= b}
    return {f"i{pair}": float(value) for pair, value in pairs.items()}


def _add_joint(root: Element, k: int, robot: Robot, friction: JointFriction | None) -> None:
    motor, end = robot.motor(k), robot.position_limits()[k - 1]
    kind = "revolute" if math.isfinite(end) else "continuous"
    bounds = {"lower": numbers([-end]), "upper": numbers([end])} if math.isfinite(end) else {}
    joint = SubElement(root, "joint", name=f"joint_{k}", type=kind)
    SubElement(joint, "parent", link=f"frame_{k - 1}")
    SubElement(joint, "child", link=f"link_{k}")
    SubElement(joint, "origin", xyz="0 0 0", rpy="0 0 0")
    SubElement(joint, "axis", xyz="0 0 1")
    SubElement(
        joint,
        "limit",
        bounds,
        effort=numbers([motor.torque_max]),
        velocity=numbers([motor.velocity_max]),
    )
    if friction is not None and (known := friction.coefficients(k)):
        coulomb, viscous = (numbers([value]) for value in known)
        SubElement(joint, "dynamics", damping=viscous, friction=coulomb)


def _add_frame(root: Element, k: int, robot: Robot) -> None:
    pose = robot.link_poses()[k - 1]
    SubElement(root, "link", name=f"frame_{k}")
    joint = SubElement(root, "joint", name=f"frame_{k}_fixed", type="fixed")
    SubElement(joint, "parent", link=f"link_{k}")
    SubElement(joint, "child", link=f"frame_{k}")
    SubElement(joint, "origin", xyz=numbers(pose.position), rpy=numbers(pose.rpy))
