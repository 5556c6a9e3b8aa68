"""The thesis's methods: the joints in closed loop, contact wrenches, torque constants."""

from typing import NamedTuple

from ur5lib.records.closed_loop import ClosedLoop
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import PublishedForces
from ur5lib.records.friction import Friction
from ur5lib.records.gains import GainSummary
from ur5lib.records.motion import Motion
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.thesis.closed_loop import closed_loops
from ur5lib.thesis.published_constants import (
    PublishedConstants,
    current_torque,
    published_constants,
)
from ur5lib.thesis.published_forces import published_forces
from ur5lib.timeseries.lowpass import Butterworth


class RebuiltThesis(NamedTuple):
    """A recording by the thesis's methods.

    closed_loop, gains: with published gains and with those that fit the recording best; published:
    F̂ᵘ, F̂ and F̂*, as printed and by its equations put right.
    """

    closed_loop: ClosedLoop
    gains: GainSummary
    published: PublishedForces
    constants: PublishedConstants


def rebuild_thesis(
    signals: Signals,
    motion: Motion,
    torques: Torques,
    kinematics: Kinematics,
    premises: Premises,
    friction: Friction,
    arm: Robot,
    lowpass: Butterworth,
    min_singular_value: float,
    gravity: list[float] | None = None,
) -> RebuiltThesis:
    """Return a recording by the thesis's methods; without forces where it contradicts the study.

    lowpass: of the external torques; min_singular_value: the least of a usable Jacobian.
    """
    loop, gains = closed_loops(signals, arm.mounted(gravity))
    forces = PublishedForces(time=signals.time, segment=signals.segment)
    if not premises.contradictions.stop_signs and not friction.stopped:
        known = arm, signals, motion, torques, kinematics.jacobian
        forces = published_forces(*known, lowpass, min_singular_value)
    constants = published_constants(current_torque(arm, signals, torques))
    return RebuiltThesis(loop, gains, forces, constants)
