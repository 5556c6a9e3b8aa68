"""Joint friction as a sum of terms, each linear in its coefficients.

A term has columns (N, M) of a joint's motion; friction torque is columns times coefficients.
"""

import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import scipy  # loads scipy.linalg and scipy.ndimage at their first use

from ur5lib.errors import InputError
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import DEAD_ZONE, by_segment, starts
from ur5lib.workspace.extensions import additions, failed

GEAR_EFFICIENCY_STD = 0.03  # the gears' relative efficiency varies by this between runs and poses
# The largest torque accelerates a bare rotor by at least this: 90 rad/s² on a UR5, 360 on a TX40.
ROTOR_ACCELERATION = 50.0  # rad/s²
INERTIA_STD = 0.2  # the inertias of a description's links have this relative error
# Presliding distance: Coulomb torque over it is the stiffness of a gear, 1e4 to 1e5 Nm/rad.
PRESLIDING_DISTANCE = 1e-4  # rad
# A part of a joint's friction at rest may reverse over these distances: at once, as by noise and
# hunting, or with a long memory.
REST_DISTANCES = (1e-5, 1e-3)  # rad
STRIBECK_SPEEDS = (0.01, 0.05, 0.2)  # rad/s; dry friction falls within these speeds
ROOT_LINE = 4 / 15, 4 / 5  # nearest line to √v from 0 to 1 rad/s: offset, slope
FINE_STEP = 0.01  # s; in logs with longer steps, joints reverse between samples
START_DISTANCE = max(REST_DISTANCES)  # rad; within it, friction depends on the motion before
NEGLIGIBLE = 1e-3  # share of friction's direction
# Warmth counts from this temperature.
USUAL_TEMPERATURE = 30.0  # °C
USUAL_AT_REST = 0.75  # share of the usual fit at rest, where one path was fitted


@dataclass(frozen=True)
class ShaftMotion:
    """Motion of the shaft of a motor that turns with two joints, (N,) each, in their scale.

    qd [rad/s], qdd [rad/s²]; direction: of its dry friction, see `friction_direction`.
    """

    qd: Array
    qdd: Array
    direction: Array


@dataclass(frozen=True)
class JointMotion:
    """Motion of one joint, (N,) each.

    q [rad], qd [rad/s]; torque: of the rigid-body model [Nm]; direction: of its dry friction, -1 to
    1, see `friction_direction`; warmth: [K], above USUAL_TEMPERATURE, 0 where it was not recorded;
    shaft: of the coupled motor that turns with the joint; balanced: whether a spring or a
    counterbalance acts on the joint; qdd: [rad/s²], 0 if the link model has the rotor;
    direction_over: returns the direction of dry friction that reverses over another distance [rad];
    inertial: torque without gravity's part [Nm], 0 for motor currents.
    """

    q: Array
    qd: Array
    torque: Array
    direction: Array
    warmth: Array | float = 0.0
    shaft: ShaftMotion | None = None
    balanced: bool | Array = False
    qdd: Array | float = 0.0
    direction_over: Callable[[float], Array] = lambda _: np.zeros(1)
    inertial: Array | float = 0.0


@dataclass(frozen=True)
class Term:
    """A term of friction.

    columns: function of a joint's motion that returns a column (N,) for each coefficient; expected:
    function that returns the prior standard deviation of a coefficient for a motor's largest torque
    [Nm]; parts: what follows the term's name in those of its coefficients, () for a single one;
    name: of a term that is an argument of `ur5lib.fit`.
    """

    columns: Callable[[JointMotion], list[Array]]
    expected: Callable[[float], float] = float
    parts: tuple[str, ...] = ()
    name: str = ""


BASE_TERMS = ("coulomb", "viscous", "load")
PARAMETER_UNITS = {  # units of the parameters that are fitted to each joint
    "torque_constant": "Nm/A",
    "gain": "Nm/Nm",
    "offset": "Nm",
    "coulomb": "Nm",
    "viscous": "Nm s/rad",
}
# Terms that are not fitted, but enlarge the errors of the others: over a part of a turn, a periodic
# term looks like an offset, and together with gravity like a torque constant.
CONSIDERED_TERMS = ("periodic",)
# The same for measured torques: their gain follows from gravity, as inertias are less certain.
INERTIA = "inertia"
CONSIDERED_OF_TORQUES = (*CONSIDERED_TERMS, INERTIA)
TERMS = {
    "coulomb": Term(lambda motion: [motion.direction]),  # Equation 3.13
    "viscous": Term(lambda motion: [motion.qd]),  # Equation 3.14
    # Coulomb friction in proportion to the transmitted torque; gears lose some per cent of it
    "load": Term(lambda motion: [np.abs(motion.torque) * motion.direction], lambda _: 0.1),
    # once per turn, as of a harmonic drive's flexspline: a tenth of Coulomb friction
    "periodic": Term(
        lambda motion: [np.sin(motion.q), np.cos(motion.q)],
        expected=lambda torque_max: 0.005 * torque_max,
        parts=("sin", "cos"),
    ),
    # lubricated gears: friction grows less, or more, than in proportion to speed; the root is less
    # its nearest line up to 1 rad/s, so that Coulomb and viscous friction keep their usual meaning
    "velocity_root": Term(
        lambda motion: [
            np.sqrt(np.abs(motion.qd)) * np.sign(motion.qd)
            - ROOT_LINE[0] * motion.direction
            - ROOT_LINE[1] * motion.qd
        ],
        expected=lambda torque_max: 0.1 * torque_max,
    ),
    "velocity_square": Term(lambda motion: [np.abs(motion.qd) * motion.qd]),
    # dry friction falls with speed, where lubricant comes between the surfaces (Stribeck 1902)
    "velocity_stribeck": Term(
        lambda motion: [
            motion.direction * np.exp(-np.abs(motion.qd) / speed) for speed in STRIBECK_SPEEDS
        ],
        expected=lambda torque_max: 0.1 * torque_max,
        parts=("slow", "middle", "fast"),
    ),
    # a spring or a counterbalance, as a mass that no link has
    "balance": Term(
        lambda motion: [motion.balanced * np.sin(motion.q), motion.balanced * np.cos(motion.q)],
        parts=("sin", "cos"),
    ),
    # for link models without rotors
    "rotor": Term(
        lambda motion: [motion.qdd * np.ones_like(motion.qd)],
        expected=lambda torque_max: torque_max / ROTOR_ACCELERATION,
    ),
    INERTIA: Term(
        lambda motion: [motion.inertial * np.ones_like(motion.qd)],
        expected=lambda _: INERTIA_STD,
    ),
    "coupled": Term(lambda motion: _shaft_columns(motion), parts=("coulomb", "viscous", "rotor")),
}
SPEED_TERMS = ("velocity_root", "velocity_square")  # selected by errors on left-out paths
STRIBECK = "velocity_stribeck"  # tried last, as friction at rest looks like it
# Only some arms or joints have these terms.
OPTIONAL_TERMS = (*SPEED_TERMS, STRIBECK, "coupled", "balance", "rotor")


def _shaft_columns(motion: JointMotion) -> list[Array]:
    """Return friction's direction, velocity and acceleration of a coupled motor's shaft."""
    if motion.shaft is None:
        return [np.zeros_like(motion.qd)] * 3
    return [motion.shaft.direction, motion.shaft.qd, motion.shaft.qdd]


class Track(NamedTuple):
    """Motion of a joint: q, qd (N,) [rad, rad/s], labels (N,) of unbroken stretches, and period
    [s].
    """

    q: Array
    qd: Array
    segment: Labels
    period: float


def friction_direction(
    q: Array, segment: Labels, distance: float = PRESLIDING_DISTANCE, start: float = 0.0
) -> Array:
    """Return the direction z (N,) of a joint's dry friction, -1 to 1, which reverses gradually.

    dz = (|dq| / distance) (sign(dq) - z) (Dahl, 1968), solved exactly from sample to sample;
    constant at rest. q: (N,) [rad]; distance: [rad]; start: z of the first sample, see
    `direction_after`. Zero, as unknown, at the start of other segments.
    """
    # z_k = e_k z_k-1 + (1 - e_k) sign(dq_k), e_k = exp(-|dq_k| / distance)
    fresh = starts(segment)
    step = np.where(fresh, 0.0, np.diff(q, prepend=q[0]))
    memory = np.where(fresh, 0.0, np.exp(-np.abs(step) / distance))
    # as a bidiagonal system: z_k - e_k z_k-1 = (1 - e_k) sign(dq_k)
    bands = np.stack([np.ones(len(q)), np.append(-memory[1:], 0.0)])
    driven = (1 - memory) * np.sign(step)
    driven[0] = start
    direction: Array = scipy.linalg.solve_banded((1, 0), bands, driven, check_finite=False)
    return direction


def direction_between(
    q: Array,
    qd: Array,
    segment: Labels,
    period: float,
    distance: float = PRESLIDING_DISTANCE,
    start: float = 0.0,
) -> Array:
    """Return the direction (N,) of dry friction, see `friction_direction`, of a slowly logged
    motion.

    The joint may reverse between samples; the result is the mean about each sample. q, qd: (N,)
    [rad, rad/s], cubic Hermite splines from sample to sample; period: [s]; distance: [rad]; start:
    of the first sample.
    """
    parts = round(period / FINE_STEP)
    if parts < 2:
        return friction_direction(q, segment, distance, start)
    # q(s) of 0 < s <= 1 between samples, by both ends' positions and velocities
    s = np.arange(1, parts + 1) / parts
    rising, leaving, arriving = s * s * (3 - 2 * s), s * (1 - s) ** 2, s * s * (s - 1)
    unbroken, step, velocity = ~starts(segment)[1:, None], np.diff(q)[:, None], period * qd[:, None]
    moved = rising * step + leaving * velocity[:-1] + arriving * velocity[1:]
    fine = q[:-1, None] + unbroken * moved
    fine[:, -1] = q[1:]  # each last one is the next sample
    labels = np.repeat(segment[:-1, None], parts, axis=1)
    labels[:, -1] = segment[1:]
    labels = np.append(segment[0], labels)
    direction = friction_direction(np.append(q[0], fine), labels, distance, start)
    return by_segment(
        scipy.ndimage.uniform_filter1d, direction[:, None], labels, parts // 2 * 2 + 1, 0
    )[::parts, 0]


def direction_after(earlier: Sequence[Track], distance: float = PRESLIDING_DISTANCE) -> float:
    """Return the direction of a joint's dry friction after earlier motions; 0 is unknown.

    earlier: oldest first, each starting where the previous one ended; motions before one with a gap
    do not count.
    """
    # z = e^(-path / distance) z₀ + z from zero
    direction, kept = 0.0, 1.0
    for track in reversed(earlier):
        direction += kept * float(direction_between(*track, distance)[-1])
        kept *= float(np.exp(-np.abs(np.diff(track.q)).sum() / distance))
        if kept < NEGLIGIBLE or starts(track.segment)[1:].any():
            break
    return direction


def unknown_share(q: Array, segment: Labels, start: float = 1.0) -> Array:
    """Return the share (N,) of a joint's friction that depends on unknown motion before a segment.

    e^(-x / d), x: range of its positions since the segment's start, d: START_DISTANCE. Unlike the
    path length, x does not grow by noise. q: (N,) [rad]; start: share at the first segment's start,
    see `unknown_after`.
    """
    unbroken = np.cumsum(starts(segment)) - 1
    reach = by_segment(_reach, q[:, None], segment)[:, 0]
    share: Array = np.where(unbroken == 0, start, 1.0) * np.exp(-reach / START_DISTANCE)
    return share


def unknown_after(earlier: Sequence[Track]) -> float:
    """Return the share of a joint's friction that is unknown after earlier motions.

    earlier: as for `direction_after`.
    """
    share = 1.0
    for track in earlier:
        share = float(unknown_share(track.q, track.segment, share)[-1])
    return share


def _reach(q: Array) -> Array:
    """Return the range (N, 1) of positions (N, 1) up to each sample."""
    reach: Array = np.maximum.accumulate(q) - np.minimum.accumulate(q)
    return reach


def direction_over_distances(track: Track, earlier: Sequence[Track]) -> Callable[[float], Array]:
    """Return a function of a distance [rad] that returns the direction (N,) of dry friction.

    earlier: as for `direction_after`.
    """
    return lambda distance: direction_between(*track, distance, direction_after(earlier, distance))


def rest_factor(qd: Array) -> Array:
    """Return 1 at rest, 0 in motion, (N,), with a smooth step in the dead zone of Equation 6.4."""
    return 1 - np.abs(np.tanh(qd / DEAD_ZONE))


def usual_at_rest(own: Array, usual: Array, qd: Array) -> Array:
    """Return what a fit states of a motion, at rest with USUAL_AT_REST of what the usual one does.

    qd: [rad/s], of the shape of both.
    """
    return own + USUAL_AT_REST * rest_factor(qd) * (usual - own)


def extension_terms(shipped: Collection[str]) -> dict[str, Term]:
    """Return the terms that the workspace adds. Raises InputError where one is no friction term."""
    return {
        name: usable_term(source, name, term, shipped)
        for source, name, term in additions("friction")
    }


def usable_term(source: str, name: str, term: object, shipped: Collection[str]) -> Term:
    """Return a term unchanged. Raises InputError where it is no friction term; source: of it."""
    motion_at_rest = JointMotion(*np.zeros((4, 3)))
    place = f"{source}: {name!r}"
    if not re.fullmatch(r"[a-z]\w*", name) or name in shipped:
        raise InputError(f"{place} is a term of ur5lib, or no lower-case word; rename it")
    if not isinstance(term, Term):
        raise InputError(f"{place} is no Term; docs/extensions.md shows one")
    try:
        sizes = [np.shape(column) for column in term.columns(motion_at_rest)]
    except Exception as error:  # whatever a user's code does
        raise failed(source, error) from error
    if sizes != [(3,)] * (len(term.parts) or 1):
        raise InputError(
            f"{place} gives columns of shapes {sizes} for 3 samples; return a list of one (3,) "
            "for each of its `parts`, of one without"
        )
    return term


def take_up(term: Term) -> None:
    """Let fits know a term by its name. Raises InputError where it has none, or is no term."""
    TERMS[term.name] = usable_term("terms", term.name, term, SHIPPED)


SHIPPED = frozenset(TERMS)
EXTENSION_TERMS = extension_terms(TERMS)
TERMS |= EXTENSION_TERMS
FITTED_TERMS = (*BASE_TERMS, "velocity_root", *EXTENSION_TERMS)


def term_of(name: str) -> Term:
    """Return a term. Raises InputError if it is unknown, as an extension of another folder."""
    if name not in TERMS:
        raise InputError(
            f"the friction term {name!r} is not known here; run this in the folder whose "
            "extensions/friction.py states it, or install the package that does"
        )
    return TERMS[name]


def coefficient_names(terms: Sequence[str]) -> list[str]:
    """Return the names of the terms' coefficients: the term's, with a part's if it has several."""
    return [
        name
        for term in terms
        for name in ([f"{term}_{part}" for part in term_of(term).parts] or [term])
    ]


def friction_columns(motion: JointMotion, terms: Sequence[str]) -> Array:
    """Return the columns (N, M) of terms, one for each coefficient."""
    return np.stack([column for term in terms for column in term_of(term).columns(motion)], axis=1)
