"""Joint friction as a family of terms, each linear in its coefficients.

A term gives columns (N, M) of a joint's motion; friction torque is columns times coefficients.
Shape parameters (a velocity, a distance) are part of a term, chosen from a grid.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded

from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import starts

MOVING = 0.02  # rad/s; the dead zone of Equation 6.4: below it, friction is stiction
# Slip before sliding [rad]: Coulomb torque over this is the stiffness of a gear, 1e4 to 1e5 Nm/rad;
# shorter ones drown in the encoder's steps. The first stands where recordings cannot tell.
PRESLIDING = (3e-4, 1e-3, 1e-4)


@dataclass(frozen=True)
class JointMotion:
    """One joint: q [rad], qd [rad/s], torque of the rigid-body model [Nm], and the direction of its
    dry friction, -1 to 1, as `friction_direction`; (N,) each.
    """

    q: Array
    qd: Array
    torque: Array
    direction: Array


def friction_direction(q: Array, segment: Labels, distance: float) -> Array:
    """Direction of a joint's dry friction (N,), -1 to 1: it turns over a distance, not at once.

    dz = (|dq| / distance) (sign(dq) - z) (Dahl, 1968), solved exactly from sample to sample; at
    rest it stays. q: (N,) [rad]; distance: [rad]. Zero at the start of a segment, where nothing is
    known of it.
    """
    fresh = starts(segment)
    step = np.where(fresh, 0.0, np.diff(q, prepend=q[0]))
    kept = np.where(fresh, 0.0, np.exp(-np.abs(step) / distance))
    bands = np.stack([np.ones(len(q)), np.append(-kept[1:], 0.0)])
    turned: Array = solve_banded((1, 0), bands, (1 - kept) * np.sign(step), check_finite=False)
    return turned


def resting(qd: Array) -> Array:
    """How much a joint rests, 0 to 1, (N,): one within the dead zone of Equation 6.4."""
    return 1 - np.abs(np.tanh(qd / MOVING))


def _coulomb(motion: JointMotion, _: float) -> list[Array]:
    return [motion.direction]  # Equation 3.13


def _viscous(motion: JointMotion, _: float) -> list[Array]:
    return [motion.qd]  # Equation 3.14


def _load(motion: JointMotion, _: float) -> list[Array]:
    """Coulomb friction that grows with the transmitted torque."""
    return [np.abs(motion.torque) * motion.direction]


def _stribeck(motion: JointMotion, velocity: float) -> list[Array]:
    return [np.exp(-((motion.qd / velocity) ** 2)) * motion.direction]


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


LOAD = 0.1  # Nm/Nm
PERIODIC = 0.005  # of a motor's largest torque


@dataclass(frozen=True)
class Term:
    """One term: a kind of KINDS, and its shape parameter where it has one [rad/s or 1/turn]."""

    kind: str
    shape: float = 0.0

    def columns(self, motion: JointMotion) -> Array:
        """(N, M), with M = 1 but for periodic terms."""
        return np.stack(KINDS[self.kind](motion, self.shape), axis=1)

    def expected(self, torque_max: float) -> list[float]:
        """Standard deviation of each coefficient before any motion, in its unit.

        torque_max: of the motor [Nm]. Gears lose some per cent of the load; what comes and goes
        over a turn is a tenth of Coulomb friction, itself a twentieth of the largest torque.
        """
        sizes = {"load": LOAD, "periodic": PERIODIC * torque_max}
        return [sizes.get(self.kind, torque_max)] * len(self.names())

    def names(self) -> list[str]:
        """Of its coefficients: the kind, its shape, and sin or cos."""
        name = f"{self.kind}_{self.shape:g}" if self.shape else self.kind
        return [f"{name}_sin", f"{name}_cos"] if self.kind == "periodic" else [name]


BASE = (Term("coulomb"), Term("viscous"), Term("load"))
CONSIDERED = (Term("periodic", 1),)
FAMILY = (
    *(Term("stribeck", velocity) for velocity in (0.05, 0.1, 0.2, 0.3, 0.5)),
    *(Term("saturating", velocity) for velocity in (0.1, 0.3, 1.0)),
    Term("quadratic"),
    Term("cubic"),
    Term("asymmetric"),
)


def is_dissipative(terms: tuple[Term, ...], coefficients: Array, qd: Array, torque: Array) -> bool:
    """Whether friction brakes at every velocity (N,) [rad/s] under every torque (M,) [Nm].

    What depends on the position or on the sign of the velocity alone is no friction and left out.
    """
    even = [term.kind in ("asymmetric", "periodic") for term in terms]
    speed, load = (grid.ravel() for grid in np.meshgrid(qd, torque))
    motion = JointMotion(np.zeros_like(speed), speed, load, np.sign(speed))
    friction, start = np.zeros_like(speed), 0
    for term, skip in zip(terms, even, strict=True):
        columns = term.columns(motion)
        if not skip:
            friction += columns @ coefficients[start : start + columns.shape[1]]
        start += columns.shape[1]
    return bool((friction * speed >= 0).all())
