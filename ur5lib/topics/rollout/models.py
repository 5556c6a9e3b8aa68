"""The arms that are compared in rollouts: links, torque constants and friction of each."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ur5lib.identification.estimation import physical_values
from ur5lib.records.friction import CurrentFit, Friction
from ur5lib.robots.description import Robot
from ur5lib.robots.friction import coefficient_names
from ur5lib.timeseries.arrays import Array

IDENTIFIED, FRICTIONLESS = "identified arm", "without friction"
DESCRIBED, STILL = "as described", "standing still"
NO_FRICTION = ("balance",)  # terms that remain without friction
ROTOR = "rotor"  # the term that acts as an inertia


class Contender(NamedTuple):
    """An arm that is compared: its name, its link model, whether it has friction, and whether its
    torque constants are the documented ones.
    """

    name: str
    links: str
    rubs: bool = True
    documented: bool = False


def contenders(arm: Robot, friction: Friction) -> Iterator[Contender]:
    """Yield the identified arm, then what it is compared with."""
    fullest, known = arm.fullest_model(), friction.known_constants
    yield Contender(IDENTIFIED, fullest)
    yield from (Contender(links, links) for links in arm.models if links != fullest)
    yield Contender(FRICTIONLESS, fullest, rubs=False)
    if arm.links == "known" and known is not None and np.isfinite(known.value).all():
        yield Contender(DESCRIBED, DESCRIBED, rubs=False, documented=True)


def with_described(arm: Robot) -> Robot:
    """Return an arm with a further link model, DESCRIBED: the chosen one with the described rotors,
    if all are.
    """
    model = arm.models[arm.chosen_model]
    rotors = [arm.motor(joint).reflected_rotor() for joint in arm.joint_numbers]
    if None not in rotors:
        model = model.model_copy(update={"rotor_inertias": tuple(rotors)})
    return arm.with_model(DESCRIBED, model)


class Constants(NamedTuple):
    """What R fits know of an arm of n joints: torque constants (R, n) [Nm/A], offsets (R, n) [Nm],
    coefficients of friction (R, n, P) [Nm, ...], and fitted rotors (R, n) [kg m²].
    """

    torque_constant: Array
    offset: Array
    friction: Array
    rotors: Array

    @classmethod
    def of(cls, fits: Sequence[CurrentFit], terms: Sequence[str]) -> "Constants":
        """Return those of fits by some terms, of which their joints may lack some."""
        known = [
            [
                dict(zip(joint.names(), physical_values(joint.estimate.coefficients), strict=True))
                for joint in fit.joints
            ]
            for fit in fits
        ]

        def values(*names: str) -> Array:
            return np.array(
                [[[one.get(name, 0.0) for name in names] for one in own] for own in known]
            )

        singles = (values(name)[..., 0] for name in ("torque_constant", "offset", ROTOR))
        constant, offset, rotors = singles
        return cls(constant, offset, values(*coefficient_names(terms)), rotors)

    def of_contender(
        self, own: Contender, terms: Sequence[str], known: Array | None
    ) -> "Constants":
        """Return those that an arm has; terms: of friction; known: documented torque constants
        (n,).
        """
        coefficients = self.friction * kept(terms, own.rubs)
        if not own.documented or known is None:
            return self._replace(friction=coefficients)
        nothing = np.zeros_like(self.offset)
        return Constants(known + nothing, nothing, coefficients, nothing)


def terms_of(fits: Sequence[CurrentFit]) -> list[str]:
    """Return the terms of friction that any joint of some fits has, without the rotor."""
    terms = (term for fit in fits for joint in fit.joints for term in joint.terms)
    return [term for term in dict.fromkeys(terms) if term != ROTOR]


def kept(terms: Sequence[str], rubs: bool) -> Array:
    """Return 1 for the terms' coefficients that an arm has with friction, or without, 0 for others,
    (P,).
    """
    return np.array(
        [rubs or term in NO_FRICTION for term in terms for _ in coefficient_names([term])], float
    )
