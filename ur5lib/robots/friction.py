"""Joint friction as a family of terms, each linear in its coefficients.

A term has columns (N, M) of a joint's motion; friction torque is columns times coefficients. Shape
parameters (a velocity, a period) belong to the term and are chosen from a grid.
"""

import re
from collections.abc import Callable, Collection
from dataclasses import dataclass

import numpy as np

from ur5lib.errors import InputError
from ur5lib.lab.extensions import additions, failed
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import DEAD_ZONE, starts

# Presliding distance [rad]: Coulomb torque over it is the stiffness of a gear, 1e4 to 1e5 Nm/rad;
# shorter ones are below the encoder's resolution. The first is used if cross-validation is
# impossible.
PRESLIDING = (3e-4, 1e-3, 1e-4)
KARNOPP = 0.0  # the distance that stands for Karnopp's friction, which reverses at once
GEARS = 0.03  # relative variation of the gears' efficiency between runs and poses
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
    from scipy.linalg import solve_banded  # slow to import; a study's settings do without it

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


@dataclass(frozen=True)
class Kind:
    """A kind of friction term.

    columns: one (N,) for each coefficient, of a joint's motion and a shape parameter; candidates:
    shape parameters among which a fit chooses, none if it does not; expected: prior standard
    deviation of a coefficient, from the motor's largest torque [Nm]; parts: names of two
    coefficients; odd: whether friction reverses with the velocity, as what brakes does.
    """

    columns: Callable[[JointMotion, float], list[Array]]
    candidates: tuple[float, ...] = ()
    expected: Callable[[float], float] = float
    parts: tuple[str, ...] = ()
    odd: bool = True


KINDS = {
    "coulomb": Kind(lambda motion, _: [motion.direction]),  # Equation 3.13
    "viscous": Kind(lambda motion, _: [motion.qd]),  # Equation 3.14
    # Coulomb friction in proportion to the transmitted torque; gears lose some per cent of it
    "load": Kind(
        lambda motion, _: [np.abs(motion.torque) * motion.direction], expected=lambda _: 0.1
    ),
    "stribeck": Kind(
        lambda motion, velocity: [np.exp(-((motion.qd / velocity) ** 2)) * motion.direction],
        (0.05, 0.1, 0.2, 0.3, 0.5),
    ),
    "saturating": Kind(lambda motion, velocity: [np.tanh(motion.qd / velocity)], (0.1, 0.3, 1.0)),
    "quadratic": Kind(lambda motion, _: [motion.qd * np.abs(motion.qd)], (0.0,)),
    "cubic": Kind(lambda motion, _: [motion.qd**3], (0.0,)),
    # direction-dependent viscous friction; that of Coulomb friction is an offset
    "asymmetric": Kind(lambda motion, _: [np.abs(motion.qd)], (0.0,), odd=False),
    # Once or twice per turn, as of a harmonic drive's flexspline: a tenth of Coulomb friction,
    # itself a twentieth of the largest torque.
    "periodic": Kind(
        lambda motion, cycles: [np.sin(cycles * motion.q), np.cos(cycles * motion.q)],
        expected=lambda torque_max: 0.005 * torque_max,
        parts=("sin", "cos"),
        odd=False,
    ),
    # What Coulomb and viscous friction gain per kelvin; they lose, as grease thins: a hundredth
    # of Coulomb friction.
    "warming": Kind(
        lambda motion, _: [motion.warmth * motion.direction, motion.warmth * motion.qd],
        (0.0,),
        expected=lambda torque_max: 5e-4 * torque_max,
        parts=("coulomb", "viscous"),
    ),
}


def added(shipped: Collection[str]) -> dict[str, Kind]:
    """Return the kinds that the lab adds. Raises InputError where one cannot be a friction term."""
    rest = JointMotion(*np.zeros((4, 3)))
    found = {}
    for source, name, kind in additions("friction"):
        place = f"{source}: {name!r}"
        if not re.fullmatch(r"[a-z]\w*", name) or name in shipped:
            raise InputError(f"{place} is a term of ur5lib, or no lower-case word; rename it")
        if not isinstance(kind, Kind) or not kind.candidates:
            raise InputError(f"{place} is no Kind with candidates of its shape; give (0.0,) if one")
        try:
            sizes = [np.shape(own) for own in kind.columns(rest, kind.candidates[0])]
        except Exception as error:  # whatever the lab's code does
            raise failed(source, error) from error
        if sizes != [(3,)] * (len(kind.parts) or 1):
            raise InputError(
                f"{place} gives columns of shapes {sizes} for 3 samples; return a list of one (3,) "
                "for each of its `parts`, of one without"
            )
        found[name] = kind
    return found


KINDS |= added(KINDS)
CANDIDATES = [kind for kind, own in KINDS.items() if own.candidates]


@dataclass(frozen=True)
class Term:
    """One term: a kind of KINDS, and its shape parameter where it has one [rad/s or 1/turn]."""

    kind: str
    shape: float = 0.0

    @property
    def of(self) -> Kind:
        """Return its kind. Raises InputError where that is an extension of another folder."""
        if self.kind not in KINDS:
            raise InputError(
                f"the friction term {self.kind!r} is not known here; run this in the folder whose "
                "extensions/friction.py states it, or install the package that does"
            )
        return KINDS[self.kind]

    def columns(self, motion: JointMotion) -> Array:
        """Return the columns (N, M), M = 2 for periodic and warming terms, 1 for all others."""
        return np.stack(self.of.columns(motion, self.shape), axis=1)

    def expected(self, torque_max: float) -> list[float]:
        """Return the prior standard deviation of each coefficient, in its unit.

        torque_max: of the motor [Nm].
        """
        return [self.of.expected(torque_max)] * len(self.names())

    def names(self) -> list[str]:
        """Return the coefficients' names: the kind, its shape, and which of two."""
        name = f"{self.kind}_{self.shape:g}" if self.shape else self.kind
        return [f"{name}_{part}" for part in self.of.parts] or [name]


BASE = (Term("coulomb"), Term("viscous"), Term("load"))
CONSIDERED = (Term("periodic", 1),)
FAMILY = tuple(Term(kind, shape) for kind in CANDIDATES for shape in KINDS[kind].candidates)


def is_dissipative(terms: tuple[Term, ...], coefficients: Array, qd: Array, torque: Array) -> bool:
    """Return whether friction brakes at every velocity (N,) [rad/s] under every torque (M,) [Nm].

    At the usual temperature; terms that do not reverse with the velocity (asymmetric, periodic)
    are excluded.
    """
    speed, load = (grid.ravel() for grid in np.meshgrid(qd, torque))
    motion = JointMotion(np.zeros_like(speed), speed, load, np.sign(speed))
    columns = [term.of.odd * term.columns(motion) for term in terms]
    friction = np.concatenate(columns, axis=1) @ coefficients
    return bool((friction * speed >= 0).all())
