"""One state of a fitted arm in microseconds, for a controller in Python."""

from collections.abc import Iterator, Sequence
from math import exp, sqrt, tanh
from typing import Any, NamedTuple

import numpy as np

from ur5lib.chain.efforts import Fits, States
from ur5lib.dynamics.one_state import OneState
from ur5lib.identification.current_samples import shafts_of
from ur5lib.identification.currents import torque_constants
from ur5lib.records.friction import CurrentFit, JointFit
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import (
    BASE_TERMS,
    ROOT_LINE,
    SPEED_TERMS,
    STRIBECK,
    STRIBECK_SPEEDS,
    JointMotion,
    ShaftMotion,
    Term,
    coefficient_names,
    term_of,
    usual_at_rest,
)
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import DEAD_ZONE
from ur5lib.workspace.beside import of_extra

IN_CLOSED_FORM = (*BASE_TERMS, *SPEED_TERMS, STRIBECK)


class Steady(NamedTuple):
    """A joint's effort [A] in steady motion, in closed form: see `efforts`."""

    per_torque: float
    offset: float
    coulomb: float
    viscous: float
    load: float
    root: float
    square: float
    held: float
    falling: tuple[tuple[float, float], ...]


def steady(joint: JointFit, coefficients: Array, held: float) -> Steady:
    """Return the closed form of a joint; coefficients: (P,), see `JointFit`; without the terms that
    only some arms have.
    """
    per_torque, offset, *friction = coefficients.tolist()
    named = dict(zip(coefficient_names(joint.terms), friction, strict=True))
    root = named.get("velocity_root", 0.0)  # fitted less its line
    names = coefficient_names([STRIBECK])
    fallen = zip((named.get(name, 0.0) for name in names), STRIBECK_SPEEDS, strict=True)
    return Steady(
        per_torque,
        offset,
        named["coulomb"] - ROOT_LINE[0] * root,
        named["viscous"] - ROOT_LINE[1] * root,
        named["load"],
        root,
        named.get("velocity_square", 0.0),
        held,
        tuple(one for one in fallen if one[0]),
    )


class JointTerm(NamedTuple):
    """A term that only some arms have, with a coefficient (n,) for each of its columns, 0 of joints
    without.
    """

    term: Term
    coefficients: list[Array]


class Single:
    """One state of an arm: arrays (n,) in and out, in microseconds.

    As `Model.torque` and `Model.current` of this state, to 1e-10: a joint that moves has moved like
    that for long, friction of one at rest is left out, as nobody knows its side. Methods take
    arrays of numbers as they are, and check nothing.

        >>> single = model.single()
        >>> q, qd, qdd = np.array([0, -1.5, 1.5, 0, 0, 0]), np.full(6, 0.2), np.zeros(6)
        >>> bool(abs(single.torque(q, qd, qdd) - model.torque(q, qd, qdd)).max() < 1e-10)
        True
    """

    def __init__(self, robot: Robot, fits: Fits, by_current: bool) -> None:
        """Take the arm, its fit, and whether it measures currents; `Model.single` calls this."""
        fit, usual = fits.own, fits.usual
        self._usual = None if usual is None else Single(robot, Fits(usual), by_current)
        of_extra("pinocchio", "pinocchio", "one state in microseconds")
        self._bodies = OneState(robot, robot.fullest_model())
        known = [joint.estimate.coefficients for joint in fit.joints]
        used = [
            own if j.alone is None else j.alone for j, own in zip(fit.joints, known, strict=True)
        ]
        held = [float(joint.held[0]) for joint in fit.joints]
        self._effort = [*map(steady, fit.joints, used, held)]
        rubbed = [own / own[0] for own in known]
        alone = [steady(*one, 0.0) for one in zip(fit.joints, rubbed, strict=True)]
        self._friction = [one._replace(per_torque=0.0, offset=0.0) for one in alone]
        self._terms = [*_further_terms(fit, used)]
        self._further = [*_further_terms(fit, rubbed)]
        self._constant = torque_constants(fit) if by_current else np.ones(len(known))
        self._zero = np.array([own[1] for own in known]) * by_current
        self._balanced: Any = np.isin([*robot.joint_numbers], robot.balanced_joints)
        unit = np.eye(len(known))
        shafts = shafts_of(robot, States(unit, unit, unit, None, False).motion())
        self._shafts = None if shafts is None else np.nan_to_num(shafts.qd).T
        self._knows_rotors = robot.knows_rotors()

    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return the torques (n,) [Nm] of links, rotors and payload, without friction."""
        return self._bodies.inverse_dynamics(q, qd, qdd)

    def forward_dynamics(self, q: Array, qd: Array, torque: Array) -> Array:
        """Return q̈ (n,) [rad/s²] under torques of the motors less friction (n,) [Nm]."""
        return self._bodies.forward_dynamics(q, qd, torque)

    def gravity(self, q: Array) -> Array:
        """Return the torques (n,) [Nm] that hold the arm."""
        return self._bodies.gravity(q)

    def mass_matrix(self, q: Array) -> Array:
        """Return the mass matrix (n, n) [kg m²], rotors included."""
        return self._bodies.mass_matrix(q)

    def jacobian(self, q: Array) -> Array:
        """Return J (6, n) of the velocity [m/s, rad/s] of the last frame, base axes."""
        return self._bodies.jacobian(q)

    def torque(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return the torques of motors (n,) [Nm] that a motion needs, with friction."""
        found = self._constant * (self._of_fit(q, qd, qdd) - self._zero)
        if self._usual is None:
            return found
        return usual_at_rest(found, self._usual.torque(q, qd, qdd), qd)

    def current(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return the motor currents (n,) [A]; of an arm that measures torques, these [Nm]."""
        found = self._of_fit(q, qd, qdd)
        if self._usual is None:
            return found
        return usual_at_rest(found, self._usual.current(q, qd, qdd), qd)

    def _of_fit(self, q: Array, qd: Array, qdd: Array) -> Array:
        torque = self._bodies.inverse_dynamics(q, qd, qdd)
        found = efforts(self._effort, torque, qd)
        return found + self._of_some_arms(q, qd, qdd, torque) if self._terms else found

    def friction(self, qd: Array, load: Array | float = 0.0) -> Array:
        """Return friction (n,) [Nm] at velocities (n,) [rad/s], as `Model.friction`, but none of a
        joint at rest; load: torque [Nm] that each gear transmits.
        """
        found = efforts(self._friction, load + 0.0 * qd, qd)
        if not self._further:
            return found
        nothing = np.zeros(len(qd))
        return found + _sum(self._further, JointMotion(nothing, qd, nothing + load, np.sign(qd)))

    def _of_some_arms(self, q: Array, qd: Array, qdd: Array, torque: Array) -> Array:
        rotors = 0.0 if self._knows_rotors else qdd
        shafts = None if self._shafts is None else _turned(self._shafts, qd, qdd)
        more = 0.0, shafts, self._balanced, rotors
        return _sum(self._terms, JointMotion(q, qd, torque, np.sign(qd), *more))


def _turned(shafts: Array, qd: Array, qdd: Array) -> ShaftMotion:
    """Return the motion of the coupled motors that turn with the joints."""
    rate = shafts @ qd
    return ShaftMotion(rate, shafts @ qdd, np.sign(rate))


def efforts(joints: Sequence[Steady], torque: Array, qd: Array) -> Array:
    """Return p τ + o ± (c + d |v| + l |τ| + r √|v| + s v² + h (1 - tanh |v|/v₀) + Σ f e^(-|v|/w))
    (n,), with the sign of v; 0 in the brackets at rest.

    In plain Python: of six joints, NumPy takes three times as long.
    """
    found = []
    for own, load, velocity in zip(joints, torque.tolist(), qd.tolist(), strict=True):
        per_torque, offset, coulomb, viscous, by_load, root, square, held, falling = own
        speed = abs(velocity)
        rubs = coulomb + viscous * speed + by_load * abs(load)
        rubs += root * sqrt(speed) + square * speed * speed
        rubs += held * (1 - tanh(speed / DEAD_ZONE))
        for part, within in falling:
            rubs += part * exp(-speed / within)
        side = (velocity > 0) - (velocity < 0)
        found.append(per_torque * load + offset + side * rubs)
    return np.array(found)


def _sum(terms: Sequence[JointTerm], motion: JointMotion) -> Array:
    """Return the sum (n,) of terms; what are samples to them are here the joints of one state."""
    columns = [(own.coefficients, own.term.columns(motion)) for own in terms]
    return np.sum([a * b for own in columns for a, b in zip(*own, strict=True)], axis=0)


def _further_terms(fit: CurrentFit, coefficients: Sequence[Array]) -> Iterator[JointTerm]:
    """Yield the terms beyond those of `Steady`; coefficients: (P,) of each joint."""
    of_joints = dict.fromkeys(name for joint in fit.joints for name in joint.terms)
    for name in (name for name in of_joints if name not in IN_CLOSED_FORM):
        rows = [
            [
                own[joint.names().index(part)] if name in joint.terms else 0.0
                for part in coefficient_names([name])
            ]
            for joint, own in zip(fit.joints, coefficients, strict=True)
        ]
        if np.any(rows):
            yield JointTerm(term_of(name), [*np.array(rows).T.copy()])
