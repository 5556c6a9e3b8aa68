"""The recursions along the arm, on single components: what the kernels are made of.

Link k is seen from its own frame (`link_k` of the URDF): origin o_(k-1) on the axis of joint k,
z along that axis, turned by q_k; its `Tail` leads to the Denavit-Hartenberg frame k. There, a
joint's motion and torque are z components, and levers between joints have zeros in known places.
Vectors and matrices are tuples of components.
"""

from collections.abc import Iterator, Sequence
from functools import reduce
from operator import add
from typing import Any, NamedTuple

import torch

from ur5lib.dynamics.tracing import Geometry, Number, Tail

Vector = tuple[Number, ...]
Matrix = tuple[Vector, ...]

ZERO: Vector = (0.0, 0.0, 0.0)
NO_TAIL = Tail(a=0.0, d=0.0, cos=1.0, sin=0.0)


class Joint(NamedTuple):
    """The way from one link's frame to the next: a constant tail, then a turn about z."""

    tail: Tail
    cos: Number
    sin: Number

    @property
    def lever(self) -> Vector:
        """From one origin to the next, seen from the link before."""
        return self.tail.a, 0.0, self.tail.d

    def outwards(self, vector: Vector) -> Vector:
        """A vector of the link before, seen from the link after."""
        x, y, z = vector
        y, z = self.tail.cos * y + self.tail.sin * z, self.tail.cos * z - self.tail.sin * y
        return self.cos * x + self.sin * y, self.cos * y - self.sin * x, z

    def inwards(self, vector: Vector) -> Vector:
        """A vector of the link after, seen from the link before."""
        x, y, z = vector
        x, y = self.cos * x - self.sin * y, self.sin * x + self.cos * y
        return x, self.tail.cos * y - self.tail.sin * z, self.tail.sin * y + self.tail.cos * z


class Inertia(NamedTuple):
    """A body's mass, first moment m c, and inertia tensor about the origin of a frame."""

    mass: Number
    moment: Vector
    tensor: Matrix


class Motion(NamedTuple):
    """How a link moves: ω, α, the acceleration of its origin, and S(α) + S(ω)²."""

    omega: Vector
    alpha: Vector
    acceleration: Vector
    turning: Matrix


class Wrench(NamedTuple):
    """Force, and moment about the origin of the frame it is seen from."""

    force: Vector
    moment: Vector


NO_WRENCH = Wrench(ZERO, ZERO)


def components(states: Any) -> list[Number]:
    """The six rows of (6, N)."""
    return [states[k] for k in range(6)]


def split(parameters: Any) -> tuple[list[Inertia], list[Number]]:
    """Links and rotor inertias from the parameters of an `Arm`."""
    values = [parameters[i] for i in range(66)]
    return [link_inertia(values[10 * k : 10 * k + 10]) for k in range(6)], values[60:]


def joints(geometry: Geometry, q: Sequence[Number]) -> list[Joint]:
    """Joints 1 to 6."""
    tails = (NO_TAIL, *geometry.tails)
    return [Joint(tails[k], torch.cos(q[k]), torch.sin(q[k])) for k in range(6)]


def link_inertia(parameters: Sequence[Number]) -> Inertia:
    """From the ten parameters m, m c_x, m c_y, m c_z, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz."""
    mass, x, y, z, xx, xy, yy, xz, yz, zz = parameters
    return Inertia(mass, (x, y, z), ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)))


def link_motions(
    chain: Sequence[Joint], gravity: Vector, qd: Sequence[Number], qdd: Sequence[Number]
) -> Iterator[Motion]:
    """Outwards from the base, which accelerates against gravity."""
    motion = Motion(ZERO, ZERO, scaled(-1.0, gravity), (ZERO, ZERO, ZERO))
    for joint, speed, change in zip(chain, qd, qdd, strict=True):
        acceleration = plus(motion.acceleration, times(motion.turning, joint.lever))
        omega, alpha, acceleration = map(joint.outwards, (*motion[:2], acceleration))
        alpha = plus(alpha, cross(omega, (0.0, 0.0, speed)), (0.0, 0.0, change))
        omega = plus(omega, (0.0, 0.0, speed))
        motion = Motion(omega, alpha, acceleration, turning(omega, alpha))
        yield motion


def needed_wrench(body: Inertia, motion: Motion) -> Wrench:
    """Newton's and Euler's equations about a point that need not be the centre of mass."""
    force = plus(scaled(body.mass, motion.acceleration), times(motion.turning, body.moment))
    spin = plus(
        times(body.tensor, motion.alpha), cross(motion.omega, times(body.tensor, motion.omega))
    )
    return Wrench(force, plus(spin, cross(body.moment, motion.acceleration)))


def joint_torques(chain: Sequence[Joint], wrenches: Sequence[Wrench]) -> list[Number]:
    """Inwards from the flange: each joint carries what the links beyond it need."""
    total, torques = NO_WRENCH, []
    for joint, wrench in zip(reversed(chain), reversed(wrenches), strict=True):
        total = Wrench(plus(total.force, wrench.force), plus(total.moment, wrench.moment))
        torques.append(total.moment[2])
        total = wrench_inwards(joint, total)
    return torques[::-1]


def wrench_inwards(joint: Joint, wrench: Wrench) -> Wrench:
    """A wrench on the link after a joint, seen from the frame of the link before."""
    force = joint.inwards(wrench.force)
    return Wrench(force, plus(joint.inwards(wrench.moment), cross(joint.lever, force)))


def composite_inertias(chain: Sequence[Joint], bodies: Sequence[Inertia]) -> list[Inertia]:
    """Each link together with all links beyond it, as if they were one body."""
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
    """A body after a joint, seen from the frame of the link before (2.45, 2.46, 2.60)."""
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
    """S(α) + S(ω)²: a lever of a turning body to the acceleration of its end."""
    x, y, z = omega
    return (
        (-1.0 * (y * y + z * z), x * y - alpha[2], x * z + alpha[1]),
        (x * y + alpha[2], -1.0 * (x * x + z * z), y * z - alpha[0]),
        (x * z - alpha[1], y * z + alpha[0], -1.0 * (x * x + y * y)),
    )


def plus(*vectors: Vector) -> Vector:
    """Sum of vectors."""
    return tuple(reduce(add, parts) for parts in zip(*vectors, strict=True))


def scaled(factor: Number, vector: Vector) -> Vector:
    """A vector times a number."""
    return tuple(factor * part for part in vector)


def dot(a: Vector, b: Vector) -> Number:
    """a · b."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def cross(a: Vector, b: Vector) -> Vector:
    """a × b."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def times(matrix: Matrix, vector: Vector) -> Vector:
    """A matrix times a vector."""
    return tuple(dot(row, vector) for row in matrix)


def transposed(matrix: Matrix) -> Matrix:
    """The rows of a matrix as its columns."""
    return tuple(zip(*matrix, strict=True))


def symmetric(matrix: Sequence[Sequence[Number]]) -> Matrix:
    """A symmetric matrix by its upper half; what made the lower one is not computed."""
    return tuple(tuple(matrix[min(i, j)][max(i, j)] for j in range(3)) for i in range(3))
