"""Joint friction as a family of terms, each linear in its coefficients.

A term gives columns (N, M) of a joint's motion; friction torque is columns times coefficients.
Shape parameters (a velocity, a distance) are part of a term, chosen from a grid.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

MOVING = 0.02  # rad/s; the dead zone of Equation 6.4: below it, friction is stiction


@dataclass(frozen=True)
class JointMotion:
    """One joint: q [rad], qd [rad/s], torque of the rigid-body model [Nm]; (N,) each."""

    q: Array
    qd: Array
    torque: Array


def direction(qd: Array) -> Array:
    """Sign of the velocity, smooth within the dead zone (Equations 3.15, 6.4)."""
    return np.tanh(qd / MOVING)


def _coulomb(motion: JointMotion, _: float) -> list[Array]:
    return [direction(motion.qd)]  # Equation 3.13


def _viscous(motion: JointMotion, _: float) -> list[Array]:
    return [motion.qd]  # Equation 3.14


def _load(motion: JointMotion, _: float) -> list[Array]:
    """Coulomb friction that grows with the transmitted torque."""
    return [np.abs(motion.torque) * direction(motion.qd)]


def _stribeck(motion: JointMotion, velocity: float) -> list[Array]:
    return [np.exp(-((motion.qd / velocity) ** 2)) * direction(motion.qd)]


def _saturating(motion: JointMotion, velocity: float) -> list[Array]:
    return [np.tanh(motion.qd / velocity)]


def _quadratic(motion: JointMotion, _: float) -> list[Array]:
    return [motion.qd * np.abs(motion.qd)]


def _cubic(motion: JointMotion, _: float) -> list[Array]:
    return [motion.qd**3]


def _asymmetric(motion: JointMotion, _: float) -> list[Array]:
    """Viscous friction that differs with the direction; of Coulomb friction, an offset tells it."""
    return [np.abs(motion.qd)]


def _periodic(motion: JointMotion, cycles: float) -> list[Array]:
    """Once or twice per turn of the joint, as a harmonic drive's flexspline causes."""
    return [np.sin(cycles * motion.q), np.cos(cycles * motion.q)]


KINDS: dict[str, Callable[[JointMotion, float], list[Array]]] = {
    "coulomb": _coulomb,
    "viscous": _viscous,
    "load": _load,
    "stribeck": _stribeck,
    "saturating": _saturating,
    "quadratic": _quadratic,
    "cubic": _cubic,
    "asymmetric": _asymmetric,
    "periodic": _periodic,
}


@dataclass(frozen=True)
class Term:
    """One term: a kind of KINDS, and its shape parameter where it has one [rad/s or 1/turn]."""

    kind: str
    shape: float = 0.0

    def columns(self, motion: JointMotion) -> Array:
        """(N, M), with M = 1 but for periodic terms."""
        return np.stack(KINDS[self.kind](motion, self.shape), axis=1)

    def names(self) -> list[str]:
        """Of its coefficients: the kind, its shape, and sin or cos."""
        name = f"{self.kind}_{self.shape:g}" if self.shape else self.kind
        return [f"{name}_sin", f"{name}_cos"] if self.kind == "periodic" else [name]


BASE = (Term("coulomb"), Term("viscous"))
FAMILY = (
    Term("load"),
    *(Term("stribeck", velocity) for velocity in (0.05, 0.1, 0.2, 0.3, 0.5)),
    *(Term("saturating", velocity) for velocity in (0.1, 0.3, 1.0)),
    Term("quadratic"),
    Term("cubic"),
    Term("asymmetric"),
    Term("periodic", 1),
    Term("periodic", 2),
)
# Slip before sliding [rad]: Coulomb torque over this is the stiffness of a gear, 1e4 to 1e5 Nm/rad;
# shorter ones drown in the encoder's steps.
PRESLIDING = (1e-3, 3e-4, 1e-4)


def locked_friction(q: Array, qd: Array, segment: NDArray[np.int64], distance: float) -> Array:
    """Share of Coulomb friction, -1 to 1, that holds a joint at rest (Dahl, 1968).

    dz = (|dq| / distance) (sign(dq) - z): after a move it keeps the sign, and follows creep.
    q, qd: (N, M) [rad, rad/s]; distance: [rad]. Zero at the start of a segment, where nothing is
    known of it; faded out by 1 - |direction(qd)|, so that it adds to a Coulomb term. (N, M).
    """
    step = np.diff(q, axis=0, prepend=q[:1])
    step[1:][np.diff(segment) != 0] = 0.0
    kept = np.exp(-np.abs(step) / distance)
    state, states = np.zeros(q.shape[1]), np.empty_like(q)
    new = np.diff(segment, prepend=segment[:1]) != 0
    for row, (keep, sign) in enumerate(zip(kept, np.sign(step), strict=True)):
        state = keep * state * (not new[row]) + (1 - keep) * sign
        states[row] = state
    return states * (1 - np.abs(direction(qd)))


def is_dissipative(terms: tuple[Term, ...], coefficients: Array, qd: Array, torque: Array) -> bool:
    """Whether friction brakes at every velocity (N,) [rad/s] under every torque (M,) [Nm].

    What depends on the position or on the sign of the velocity alone is no friction and left out.
    """
    even = [term.kind in ("asymmetric", "periodic") for term in terms]
    speed, load = (grid.ravel() for grid in np.meshgrid(qd, torque))
    motion = JointMotion(np.zeros_like(speed), speed, load)
    friction, start = np.zeros_like(speed), 0
    for term, skip in zip(terms, even, strict=True):
        columns = term.columns(motion)
        if not skip:
            friction += columns @ coefficients[start : start + columns.shape[1]]
        start += columns.shape[1]
    return bool((friction * speed >= 0).all())
