"""Mass, centre of mass and inertia tensor of each link, and the transform along it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from ur5lib.robots.description import Cylinder, Payload, Pose, Robot
from ur5lib.timeseries.arrays import Array

WRITTEN_SHARE = 1e-5  # this share of an inertia survives rounding to six digits


@dataclass(frozen=True)
class RigidBodies:
    """The n links of an arm as rigid bodies, each in its own Denavit-Hartenberg frame.

    mass: (n,) [kg]; center_of_mass: (n, 3) [m];
    inertia: (n, 3, 3) [kg m²] about the centre of mass;
    rotor_inertia: (n,) [kg m²] of the joints' motors, reflected through their gears.
    """

    mass: Array
    center_of_mass: Array
    inertia: Array
    rotor_inertia: Array

    def rigid(self, share: float) -> "RigidBodies":
        """Return the links with inertias that rigid bodies can have; share: see `rigid_inertia`."""
        raised = np.stack([rigid_inertia(inertia, share) for inertia in self.inertia])
        return replace(self, inertia=raised)


def cylinder_inertia(axis: str, mass: float, height: float, radius: float) -> Array:
    """Return the inertia tensor (3, 3) of a homogeneous cylinder about its centroid (2.48)."""
    across = mass / 12 * (3 * radius**2 + height**2)
    principal = np.full(3, across)
    principal["xyz".index(axis)] = mass / 2 * radius**2
    return np.diag(principal)


def shift_inertia(inertia: Array, mass: float, offset: Array) -> Array:
    """Return an inertia tensor about another point by the parallel-axis theorem (2.45, 2.46).

    inertia: (3, 3) about the centroid; offset: (3,) from the new reference point to the centroid.
    """
    return inertia + mass * (offset @ offset * np.eye(3) - np.outer(offset, offset))


def joined(parts: Sequence[tuple[float, Array, Array]]) -> tuple[float, Array, Array]:
    """Return bodies as one: mass, centre of mass (3,), and inertia tensor (3, 3) about it (2.45,
    2.46).

    parts: the same three of each body, in common axes.
    """
    mass = sum(mass for mass, _, _ in parts)
    center = np.sum([mass * center for mass, center, _ in parts], axis=0) / mass
    shifted = [
        shift_inertia(inertia, mass, part_center - center) for mass, part_center, inertia in parts
    ]
    return mass, center, np.sum(shifted, axis=0)


def combine_cylinders(cylinders: list[Cylinder]) -> Array:
    """Return the inertia tensor (3, 3) of a link about its centre of mass (Equation 2.56)."""
    total = np.zeros((3, 3))
    for part in cylinders:
        about_centroid = cylinder_inertia(part.axis, part.mass, part.height, part.radius)
        total += shift_inertia(about_centroid, part.mass, np.array(part.offset))
    return total


def tensor(entries: Sequence[float]) -> Array:
    """Return the inertia tensor (3, 3) of the entries xx yy zz xy xz yz."""
    xx, yy, zz, xy, xz, yz = entries
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


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


def rigid_inertia(inertia: Array, share: float) -> Array:
    """Return an inertia tensor (3, 3) that a rigid body can have, unchanged if it already is one.

    Principal moments obey A + B >= C. A flat plate has A + B = C, which rounding can violate, and
    simulators reject the link. If A + B - C is less than `share` of their sum, or, of a point mass,
    `share` kg m², all moments are raised by the difference.
    """
    moments = np.linalg.eigvalsh(inertia)
    slack = moments[0] + moments[1] - moments[2]
    margin = share * (np.abs(moments).sum() or 1.0)
    return inertia if slack >= margin else inertia + (margin - slack) * np.eye(3)


def rigid_bodies(robot: Robot, model: str) -> RigidBodies:
    """Return the links of an arm in one of its models, e.g. "C", payload included."""
    links = robot.models[model]
    inertias = (
        map(combine_cylinders, links.cylinders)
        if links.cylinders is not None
        else map(tensor, links.inertias or ())
    )
    masses = links.masses or robot.masses
    bodies = RigidBodies(
        mass=np.array(masses),
        center_of_mass=np.array(links.centers_of_mass),
        inertia=np.stack(list(inertias)),
        rotor_inertia=np.array(links.rotor_inertias or np.zeros(len(masses))),
    )
    return bodies if links.payload is None else mount(bodies, links.payload)


def inertial_parameters(robot: Robot, bodies: RigidBodies) -> Array:
    """Return π of τ = Y π, (11 n,) [kg, kg m, kg m²]: ten per link, then the n rotor inertias.

    m, m c_x, m c_y, m c_z, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz about the origin and in the axes of
    the URDF's link_k: origin o_(k-1), and axes that the tail of link k turns into frame k's.
    """
    links = []
    for k, pose in enumerate(robot.link_poses()):
        rotation, translation = link_tail(pose)
        mass, center = bodies.mass[k], translation + rotation @ bodies.center_of_mass[k]
        inertia = shift_inertia(rotation @ bodies.inertia[k] @ rotation.T, mass, center)
        upper = inertia[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]
        links.append([mass, *(mass * center), *upper])
    return np.append(np.ravel(links), bodies.rotor_inertia)


def written_bodies(robot: Robot, model: str) -> RigidBodies:
    """Return the links of an arm for files of other programs, whose inertias survive rounding."""
    return rigid_bodies(robot, model).rigid(WRITTEN_SHARE)


def mount(bodies: RigidBodies, payload: Payload) -> RigidBodies:
    """Return the links with a payload merged into the last one (Equations 2.45, 2.46)."""
    last = bodies.mass[-1], bodies.center_of_mass[-1], bodies.inertia[-1]
    load = payload.mass, np.array(payload.center_of_mass), tensor(payload.inertia)
    mass, center, inertia = joined([last, load])
    return RigidBodies(
        mass=np.append(bodies.mass[:-1], mass),
        center_of_mass=np.vstack([bodies.center_of_mass[:-1], center]),
        inertia=np.concatenate([bodies.inertia[:-1], inertia[None]]),
        rotor_inertia=bodies.rotor_inertia,
    )
