"""The recursions along the arm that the kernels consist of, on single components.

Link k is seen from its own frame (`link_k` of the URDF): origin o_(k-1) on the axis of joint k, z
along that axis, turned by q_k; its `Tail` leads to the Denavit-Hartenberg frame k. There, a joint's
motion and torque are z components, and levers between joints have zeros in fixed places. Vectors
and matrices are tuples of components.
"""

from collections.abc import Iterator, Sequence
from functools import reduce
from operator import add
from typing import Any, NamedTuple

import torch

from ur5lib.dynamics.tracing import Geometry, Number, Tail

Vector = tuple[Number, ...]
Matrix = tuple[Vector, ...]

ZERO_VECTOR: Vector = (0.0, 0.0, 0.0)
IDENTITY_TAIL = Tail(((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)), ZERO_VECTOR)


class Joint(NamedTuple):
    """Transformation from a link's frame to the next: a constant one to the joint, then a turn
    about its z axis.
    """

    tail: Tail
    cos: Number
    sin: Number

    @property
    def lever(self) -> Vector:
        """Return the vector from one origin to the next, in the frame of the link before."""
        return self.tail.lever

    def outwards(self, vector: Vector) -> Vector:
        """Transform a vector from the frame of the link before to that of the link after."""
        x, y, z = times(transposed(self.tail.rotation), vector)
        return self.cos * x + self.sin * y, self.cos * y - self.sin * x, z

    def inwards(self, vector: Vector) -> Vector:
        """Transform a vector from the frame of the link after to that of the link before."""
        x, y, z = vector
        turned = self.cos * x - self.sin * y, self.sin * x + self.cos * y, z
        return times(self.tail.rotation, turned)


class Inertia(NamedTuple):
    """A body's mass, first moment m c, and inertia tensor about the origin of a frame."""

    mass: Number
    moment: Vector
    tensor: Matrix


class LinkMotion(NamedTuple):
    """Motion of a link: ω, α, the acceleration of its origin, and S(α) + S(ω)²."""

    omega: Vector
    alpha: Vector
    acceleration: Vector
    turning: Matrix


class LinkWrench(NamedTuple):
    """Force, and moment about the origin, in the axes of one frame."""

    force: Vector
    moment: Vector


NO_WRENCH = LinkWrench(ZERO_VECTOR, ZERO_VECTOR)


def components(geometry: Geometry, *states: Any) -> list[list[Number]]:
    """Return each state's rows: (n, N) as a list of n rows."""
    return [[state[k] for k in geometry.joints] for state in states]


def split(geometry: Geometry, parameters: Any) -> tuple[list[Inertia], list[Number]]:
    """Split the parameters of `ArmTensors` into links and rotor inertias."""
    count = len(geometry.joints)
    values = [parameters[i] for i in range(11 * count)]
    links = [link_inertia(values[10 * k : 10 * k + 10]) for k in geometry.joints]
    return links, values[10 * count :]


def joints(geometry: Geometry, q: Any) -> list[Joint]:
    """Return joints 1 to n at positions q, rows (n, N)."""
    tails = (IDENTITY_TAIL, *geometry.tails)
    return [Joint(tails[k], torch.cos(q[k]), torch.sin(q[k])) for k in geometry.joints]


def link_inertia(parameters: Sequence[Number]) -> Inertia:
    """Return a link from m, m c_x, m c_y, m c_z, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz."""
    mass, x, y, z, xx, xy, yy, xz, yz, zz = parameters
    return Inertia(mass, (x, y, z), ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))


def link_motions(
    chain: Sequence[Joint], gravity: Vector, qd: Sequence[Number], qdd: Sequence[Number]
) -> Iterator[LinkMotion]:
    """Yield the motion of links 1 to n, outwards from the base, which accelerates by -g0."""
    motion = LinkMotion(
        ZERO_VECTOR, ZERO_VECTOR, scaled(-1.0, gravity), (ZERO_VECTOR, ZERO_VECTOR, ZERO_VECTOR)
    )
    for joint, speed, change in zip(chain, qd, qdd, strict=True):
        # a_k = a_k-1 + (S(α) + S(ω)²) r, in the frame of link k-1; then all in that of link k
        acceleration = plus(motion.acceleration, times(motion.turning, joint.lever))
        omega, alpha, acceleration = map(joint.outwards, (*motion[:2], acceleration))
        # α_k = α_k-1 + ω_k-1 × q̇ z + q̈ z, ω_k = ω_k-1 + q̇ z
        alpha = plus(alpha, cross(omega, (0.0, 0.0, speed)), (0.0, 0.0, change))
        omega = plus(omega, (0.0, 0.0, speed))
        motion = LinkMotion(omega, alpha, acceleration, turning(omega, alpha))
        yield motion


def needed_wrench(body: Inertia, motion: LinkMotion) -> LinkWrench:
    """Return the wrench that a motion requires, by Newton and Euler about the frame's origin."""
    # F = m a + (S(α) + S(ω)²) m c
    force = plus(scaled(body.mass, motion.acceleration), times(motion.turning, body.moment))
    # n = I α + ω × I ω + m c × a
    spin = plus(
        times(body.tensor, motion.alpha), cross(motion.omega, times(body.tensor, motion.omega))
    )
    return LinkWrench(force, plus(spin, cross(body.moment, motion.acceleration)))


def joint_torques(chain: Sequence[Joint], wrenches: Sequence[LinkWrench]) -> list[Number]:
    """Return the joint torques, inwards from the flange: n_z of all wrenches beyond each joint."""
    total, torques = NO_WRENCH, []
    for joint, wrench in zip(reversed(chain), reversed(wrenches), strict=True):
        total = LinkWrench(plus(total.force, wrench.force), plus(total.moment, wrench.moment))
        torques.append(total.moment[2])
        total = wrench_inwards(joint, total)
    return torques[::-1]


def wrench_inwards(joint: Joint, wrench: LinkWrench) -> LinkWrench:
    """Transform a wrench to the frame of the link before: F = R F', n = R n' + r × F."""
    force = joint.inwards(wrench.force)
    return LinkWrench(force, plus(joint.inwards(wrench.moment), cross(joint.lever, force)))


def composite_inertias(chain: Sequence[Joint], bodies: Sequence[Inertia]) -> list[Inertia]:
    """Return each link together with all links beyond it as one body."""
    composite = [bodies[-1]]
    for joint, body in zip(reversed(chain[1:]), reversed(bodies[:-1]), strict=True):
        beyond = inertia_inwards(joint, composite[-1])
        composite.append(
            Inertia(
                body.mass + beyond.mass,
                plus(body.moment, beyond.moment),
                tuple(map(plus, body.tensor, beyond.tensor)),
            )
        )
    return composite[::-1]


def inertia_inwards(joint: Joint, body: Inertia) -> Inertia:
    """Transform a body to the frame of the link before a joint (2.45, 2.46, 2.60)."""
    moment, p = joint.inwards(body.moment), joint.lever
    half_turned = transposed(tuple(map(joint.inwards, body.tensor)))
    turned = tuple(map(joint.inwards, half_turned))
    # R I Rᵀ + 2 (h·p) 1 - h pᵀ - p hᵀ with h half-way between the moment before and after
    h = plus(moment, scaled(body.mass, scaled(0.5, p)))
    trace = 2.0 * dot(h, p)
    shift = [
        [(trace if i == j else 0.0) - h[i] * p[j] - p[i] * h[j] for j in range(3)] for i in range(3)
    ]
    tensor = symmetric([[turned[i][j] + shift[i][j] for j in range(3)] for i in range(3)])
    return Inertia(body.mass, plus(moment, scaled(body.mass, p)), tensor)


def turning(omega: Vector, alpha: Vector) -> Matrix:
    """Return S(α) + S(ω)²; times a lever, it is the acceleration of the lever's end."""
    x, y, z = omega
    return (
        (-1.0 * (y * y + z * z), x * y - alpha[2], x * z + alpha[1]),
        (x * y + alpha[2], -1.0 * (x * x + z * z), y * z - alpha[0]),
        (x * z - alpha[1], y * z + alpha[0], -1.0 * (x * x + y * y)),
    )


def plus(*vectors: Vector) -> Vector:
    """Return the sum of vectors."""
    return tuple(reduce(add, parts) for parts in zip(*vectors, strict=True))


def scaled(factor: Number, vector: Vector) -> Vector:
    """Return a vector times a number."""
    return tuple(factor * part for part in vector)


def dot(a: Vector, b: Vector) -> Number:
    """Return a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """Return a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def times(matrix: Matrix, vector: Vector) -> Vector:
    """Return a matrix times a vector."""
    return tuple(dot(row, vector) for row in matrix)


def transposed(matrix: Matrix) -> Matrix:
    """Return the transpose of a matrix."""
    return tuple(zip(*matrix, strict=True))


def symmetric(matrix: Sequence[Sequence[Number]]) -> Matrix:
    """Return a symmetric matrix from its upper half; the lower half is never computed."""
    return tuple(tuple(matrix[min(i, j)][max(i, j)] for j in range(3)) for i in range(3))
