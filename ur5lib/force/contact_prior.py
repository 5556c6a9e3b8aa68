"""Prior assumptions about contacts: how large they are, where, and how long they last."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from ur5lib.records.contact_place import ContactPlace
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import STANDARD_GRAVITY
from ur5lib.timeseries.arrays import Array

TYPICAL_LOAD_SHARE = 0.3  # a typical contact weighs this share of the rated payload
PAYLOAD_SHARE = 0.3  # payload over the links' mass, if none is described
# Magnitudes among which the gate chooses, in typical forces.
GATE_SIZES = (1 / 3, 3.0)


def typical_force(arm: Robot) -> float:
    """Return the magnitude [N] of a typical contact with an arm: 15 N for a UR5."""
    payload = arm.rated_payload or PAYLOAD_SHARE * sum(arm.masses)
    return TYPICAL_LOAD_SHARE * STANDARD_GRAVITY * payload


@dataclass(frozen=True)
class ContactPrior:
    """Prior assumptions on magnitudes and durations of contacts, and on losses between contact and
    motors.

    Contacts: force [N], magnitude of a typical contact; lever [m], usual distance of a contact from
    the place where contacts are assumed; lever_weight: weight of this distance, in samples;
    duration, pause: mean duration of contacts and of the pauses between them [s]; unseen_duration:
    mean duration of contacts that the gate may miss [s].

    Gears: load_friction: relative standard deviation of a contact's torque at each joint, or at
    joints 1 to 6 (6,), by what the fitted gears transmit; friction_std: relative deviation of each
    joint's friction in one run from that of the fit.

    Rest: hunting: amplitude by which a joint's torque wanders after it was touched, as a share of
    the breakaway torque; settling: time constant of this [s].
    """

    force: float
    lever: float = ContactPlace.within
    lever_weight: float = ContactPlace.weight
    duration: float = 1.0
    pause: float = 10.0
    unseen_duration: float = 3.0
    load_friction: float | Array = 0.1
    friction_std: float = 0.2
    hunting: float = 0.3
    settling: float = 3.0

    @classmethod
    def of(cls, arm: Robot, force: float | None, place: ContactPlace) -> Self:
        """Return the prior of contacts with an arm; force: typical [N], None to derive it from the
        arm's payload.
        """
        return cls(force or typical_force(arm), place.within, place.weight)

    def usual(self) -> Array:
        """Return the covariance (6, 6) of the wrench of a typical contact, at its place."""
        return wrench_covariance(self.force, self.lever)

    def unknown(self) -> Array:
        """Return the covariance (6, 6) of the wrench of a contact of unknown size: three times the
        typical force.
        """
        return wrench_covariance(3 * self.force, self.lever)

    def sizes(self) -> list[float]:
        """Return the magnitudes [N] among which the gate chooses."""
        return [share * self.force for share in GATE_SIZES]


def wrench_covariance(force: float, lever: float) -> Array:
    """Return the covariance (6, 6) of a force [N] in any direction and a moment by a lever [m]."""
    return np.diag([force**2] * 3 + [(lever * force) ** 2] * 3)
