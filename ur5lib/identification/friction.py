"""Joint friction as a family of terms, each linear in its coefficients.

A term has columns (N, M) of a joint's motion; friction torque is columns times coefficients. Shape
parameters (a velocity, a period) belong to the term and are chosen from a grid.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.linalg import solve_banded

from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import DEAD_ZONE, starts

# Presliding distance [rad]: Coulomb torque over it is the stiffness of a gear, 1e4 to 1e5 Nm/rad;
# shorter ones are below the encoder's resolution. The first is used if cross-validation is
# impossible.
PRESLIDING = (3e-4, 1e-3, 1e-4)
KARNOPP = 0.0  # the distance that stands for Karnopp's friction, which reverses at once
USUAL = 30.0  # °C, of a joint in motion: at which friction has the coefficients of its other terms


@dataclass(frozen=True)
class JointMotion:
    """Motion of one joint, (N,) each.

    q [rad], qd [rad/s]; torque: of the rigid-body model [Nm]; direction: of its dry friction, -1 to
    1, see `friction_direction`; warmth: [K], above USUAL, 0 where it was not recorded.
    """

    q: Array
    qd: Array
    torque: Array
    direction: Array
    warmth: Array | float = 0.0


def friction_direction(q: Array, segment: Labels, distance: float) -> Array:
    """Return the direction z (N,) of a joint's dry friction, -1 to 1, which reverses gradually.

    dz = (|dq| / distance) (sign(dq) - z) (Dahl, 1968), solved exactly from sample to sample;
    constant at rest. q: (N,) [rad]; distance: [rad]. Zero, as unknown, at the start of a segment.
    """
    # z_k = e_k z_k-1 + (1 - e_k) sign(dq_k), e_k = exp(-|dq_k| / distance)
    fresh = starts(segment)
    step = np.where(fresh, 0.0, np.diff(q, prepend=q[0]))
    kept = np.where(fresh, 0.0, np.exp(-np.abs(step) / distance))
    # as a bidiagonal system: z_k - e_k z_k-1 = (1 - e_k) sign(dq_k)
    bands = np.stack([np.ones(len(q)), np.append(-kept[1:], 0.0)])
    direction: Array = solve_banded((1, 0), bands, (1 - kept) * np.sign(step), check_finite=False)
    return direction


def karnopp_direction(qd: Array, segment: Labels) -> Array:
    """Return the direction (N,) of a joint's dry friction, -1, 0 or 1, by Karnopp (1985).

    The sign of qd (N,) [rad/s] outside DEAD_ZONE. Inside, the joint sticks, and friction
    is whatever holds it: the direction before is kept, and its size is fitted (`resting`). Zero, as
    unknown, until a segment's first motion.
    """
    moves = np.abs(qd) > DEAD_ZONE
    rows = np.arange(len(qd))
    last = np.maximum.accumulate(np.where(moves | starts(segment), rows, 0))
    direction: Array = np.where(moves, np.sign(qd), 0.0)[last]
    return direction


def resting(qd: Array) -> Array:
    """Return 1 at rest, 0 in motion, (N,), with a smooth step in the dead zone of Equation 6.4."""
    return 1 - np.abs(np.tanh(qd / DEAD_ZONE))


def _coulomb(motion: JointMotion, _: float) -> list[Array]:
    return [motion.direction]  # Equation 3.13


def _viscous(motion: JointMotion, _: float) -> list[Array]:
    return [motion.qd]  # Equation 3.14


def _load(motion: JointMotion, _: float) -> list[Array]:
    """Return load-dependent friction: Coulomb friction in proportion to the transmitted torque."""
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
    """Return direction-dependent viscous friction; that of Coulomb friction is an offset."""
    return [np.abs(motion.qd)]


def _periodic(motion: JointMotion, cycles: float) -> list[Array]:
    """Return a torque once or twice per turn of the joint, as a harmonic drive's flexspline has."""
    return [np.sin(cycles * motion.q), np.cos(cycles * motion.q)]


def _warming(motion: JointMotion, _: float) -> list[Array]:
    """Return what Coulomb and viscous friction gain per kelvin; they lose, as grease thins."""
    return [motion.warmth * motion.direction, motion.warmth * motion.qd]


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
    "warming": _warming,
}


LOAD = 0.1  # Nm/Nm
PERIODIC = 0.005  # of a motor's largest torque
WARMING = 5e-4  # of it per kelvin: a hundredth of Coulomb friction
PARTS = {"periodic": ("sin", "cos"), "warming": ("coulomb", "viscous")}  # of kinds with two


@dataclass(frozen=True)
class Term:
    """One term: a kind of KINDS, and its shape parameter where it has one [rad/s or 1/turn]."""

    kind: str
    shape: float = 0.0

    def columns(self, motion: JointMotion) -> Array:
        """Return the columns (N, M), M = 2 for periodic and warming terms, 1 for all others."""
        return np.stack(KINDS[self.kind](motion, self.shape), axis=1)

    def expected(self, torque_max: float) -> list[float]:
        """Return the prior standard deviation of each coefficient, in its unit.

        torque_max: of the motor [Nm]. Gears lose some per cent of the load; the periodic torque is
        a tenth of Coulomb friction, itself a twentieth of the largest torque.
        """
        sizes = {
            "load": LOAD,
            "periodic": PERIODIC * torque_max,
            "warming": WARMING * torque_max,
        }
        return [sizes.get(self.kind, torque_max)] * len(self.names())

    def names(self) -> list[str]:
        """Return the coefficients' names: the kind, its shape, and which of two."""
        name = f"{self.kind}_{self.shape:g}" if self.shape else self.kind
        return [f"{name}_{part}" for part in PARTS[self.kind]] if self.kind in PARTS else [name]


BASE = (Term("coulomb"), Term("viscous"), Term("load"))
CONSIDERED = (Term("periodic", 1),)
FAMILY = (
    *(Term("stribeck", velocity) for velocity in (0.05, 0.1, 0.2, 0.3, 0.5)),
    *(Term("saturating", velocity) for velocity in (0.1, 0.3, 1.0)),
    Term("quadratic"),
    Term("cubic"),
    Term("asymmetric"),
    Term("warming"),
)


def is_dissipative(terms: tuple[Term, ...], coefficients: Array, qd: Array, torque: Array) -> bool:
    """Return whether friction brakes at every velocity (N,) [rad/s] under every torque (M,) [Nm].

    At the usual temperature; terms that are even in the velocity (asymmetric, periodic) are
    excluded.
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
