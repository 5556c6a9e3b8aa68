"""Export of an arm as URDF, for pytorch-kinematics and other engines."""

import math
from collections.abc import Iterable
from xml.etree.ElementTree import Element, SubElement, indent, tostring

import numpy as np

from ur5lib.robots.description import DenavitHartenberg, Robot
from ur5lib.robots.inertia import RigidBodies
from ur5lib.timeseries.arrays import Array


def link_tail(parameters: DenavitHartenberg) -> tuple[Array, Array]:
    """Return rotation (3, 3) and translation (3,) of Trans_z(d) Trans_x(a) Rot_x(alpha) (2.19).

    This is the constant transform from a URDF joint's frame, at the near end of a link, to the
    Denavit-Hartenberg frame k at its far end.
    """
    c, s = math.cos(parameters.alpha), math.sin(parameters.alpha)
    rotation = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    return rotation, np.array([parameters.a, 0.0, parameters.d])


def thick(inertia: Array) -> Array:
    """Return an inertia tensor that obeys the triangle inequality of a rigid body.

    Principal moments obey A + B >= C. For a flat plate A + B = C, which rounded digits can violate;
    MuJoCo then rejects the link. In that case all moments are raised by 1e-12 of their sum.
    """
    slack = np.trace(inertia) - 2 * np.linalg.eigvalsh(inertia)[-1]
    margin = 1e-12 * np.trace(inertia)
    return inertia if slack > margin else inertia + margin * np.eye(3)


def urdf(robot: Robot, bodies: RigidBodies) -> str:
    """Return an arm as URDF.

    The base is `frame_0`; for k = 1 to 6, `joint_k` turns `link_k`, which has the mass, and its
    Denavit-Hartenberg frame `frame_k` lies at the far end of the link. URDF has no element for
    rotor inertias: set them as `model.armature` in Pinocchio and `model.dof_armature` in MuJoCo.
    """
    root = Element("robot", name=robot.name)
    SubElement(root, "link", name="frame_0")
    for k in range(1, 7):
        _add_link(root, k, robot, bodies)
        _add_joint(root, k, robot)
        _add_frame(root, k, robot)
    indent(root)
    return tostring(root, encoding="unicode")


def _text(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)


def _add_link(root: Element, k: int, robot: Robot, bodies: RigidBodies) -> None:
    parameters = robot.denavit_hartenberg[k - 1]
    rotation, translation = link_tail(parameters)
    center = translation + rotation @ bodies.center_of_mass[k - 1]
    inertia = thick(bodies.inertia[k - 1])
    entries = {"ixx": (0, 0), "iyy": (1, 1), "izz": (2, 2)}
    entries |= {"ixy": (0, 1), "ixz": (0, 2), "iyz": (1, 2)}

    inertial = SubElement(SubElement(root, "link", name=f"link_{k}"), "inertial")
    SubElement(inertial, "origin", xyz=_text(center), rpy=_text([parameters.alpha, 0, 0]))
    SubElement(inertial, "mass", value=_text([bodies.mass[k - 1]]))
    SubElement(inertial, "inertia", {name: _text([inertia[ij]]) for name, ij in entries.items()})


def _add_joint(root: Element, k: int, robot: Robot) -> None:
    motor = robot.motor(k)
    joint = SubElement(root, "joint", name=f"joint_{k}", type="revolute")
    SubElement(joint, "parent", link=f"frame_{k - 1}")
    SubElement(joint, "child", link=f"link_{k}")
    SubElement(joint, "origin", xyz="0 0 0", rpy="0 0 0")
    SubElement(joint, "axis", xyz="0 0 1")
    SubElement(
        joint,
        "limit",
        lower=_text([-motor.position_max]),
        upper=_text([motor.position_max]),
        effort=_text([motor.torque_max]),
        velocity=_text([motor.velocity_max]),
    )


def _add_frame(root: Element, k: int, robot: Robot) -> None:
    parameters = robot.denavit_hartenberg[k - 1]
    SubElement(root, "link", name=f"frame_{k}")
    joint = SubElement(root, "joint", name=f"frame_{k}_fixed", type="fixed")
    SubElement(joint, "parent", link=f"link_{k}")
    SubElement(joint, "child", link=f"frame_{k}")
    SubElement(
        joint,
        "origin",
        xyz=_text(link_tail(parameters)[1]),
        rpy=_text([parameters.alpha, 0, 0]),
    )
