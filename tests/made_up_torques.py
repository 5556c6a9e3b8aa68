"""Made-up external torques of a UR5: a motion, what is left without contact, and pushes."""

from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.contact_wrench import regularised_wrench
from ur5lib.force.external_torque import States, joint_states
from ur5lib.force.force_input import ForceInput
from ur5lib.force.gate import TorqueVariances, diagonal
from ur5lib.force.missed_contacts import MISSED_DEVIATIONS
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.wrench_estimate import (
    WrenchEstimate,
    estimate_wrench,
    used_rows,
)
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics
from ur5lib.timeseries.arrays import Array

PERIOD = 0.032  # s, at which the estimate weighs samples, so that none is weighed in vain
PRIOR = ContactPrior(15.0)
MODEL = ResidualModel(  # of the size found on the thesis's UR5
    spread=np.array(
        [
            [0.9, 1.9, 2.3, 0.35, 0.3, 0.2],
            [1.0, 2.5, 3.9, 0.8, 0.4, 0.9],
            [4.6, 5.7, 5.2, 1.2, 0.9, 2.7],
            [4.1, 4.3, 4.8, 1.7, 0.6, 3.7],
            [4.6, 7.9, 3.9, 1.4, 1.7, 2.4],
        ]
    ),
    change=np.array(
        [
            [0.65, 0.85, 0.65, 0.15, 0.2, 0.1],
            [0.9, 1.7, 2.6, 0.6, 0.3, 0.7],
            [2.9, 4.2, 4.1, 0.7, 0.5, 1.3],
            [1.3, 2.3, 0.8, 0.3, 0.2, 0.5],
            [1.8, 0.85, 1.6, 0.15, 0.2, 0.3],
        ]
    ),
    rate=np.array([0.12, 0.03, 0.13, 0.04, 0.03]),
    independent=0.25,
    breakaway=np.array([6.5, 5.6, 4.3, 1.6, 1.6, 1.6]),
)
TYPICAL = 0.5  # of the model's deviations: it is as wide as few paths allow, a run is not
FLANGE = np.zeros(3)  # m, frame 6
REGULAR = np.array([0.3, -1.2, 1.4, -1.0, 1.2, 0.4])
ELBOW, WRIST = REGULAR * [1, 1, 0, 1, 1, 1], REGULAR * [1, 1, 1, 1, 0, 1]


def jacobians(ur5: Robot, q: Array) -> Array:
    return flange_kinematics(ur5, q)[2]


def torque_of(J: Array, wrench: Array) -> Array:
    return (J.mT @ wrench[..., None])[..., 0]


@dataclass(frozen=True)
class Free:
    """A run that nothing touches: motion, Jacobians, R_6, joint states, external torque."""

    time: Array
    q: Array
    qd: Array
    jacobian: Array
    rotation: Array
    states: States
    torque: Array

    def wrench(self, force: Array, off: Array = FLANGE) -> Array:
        """(N, 6), of a force (N, 3) at a point of frame 6 [m]."""
        return np.concatenate([force, np.cross(self.rotation @ off, force)], axis=1)

    def pushed(self, wrench: Array) -> Self:
        """With a wrench (N, 6), all of which the gears pass on."""
        return replace(self, torque=self.torque + torque_of(self.jacobian, wrench))

    def input(self, **others: Any) -> ForceInput:
        segment, step = np.zeros(len(self.time), int), self.time[1] - self.time[0]
        run = ForceInput(self.q, self.qd, self.torque, self.states, segment, step)
        return replace(run, **others)

    def estimate(
        self,
        prior: ContactPrior = PRIOR,
        model: ResidualModel = MODEL,
        **others: Any,
    ) -> WrenchEstimate:
        """others: fields of the `ForceInput`."""
        run = self.input(**others)
        jacobian = self.jacobian[used_rows(run.segment, run.period, model.cutoff)]
        return estimate_wrench(run, jacobian, model, prior)


def free_run(
    ur5: Robot,
    seed: int,
    seconds: float = 24.0,
    moving: bool = True,
    around: Array = REGULAR,
    scale: float = TYPICAL,
    period: float = PERIOD,
) -> Free:
    """Joints that swing about a pose, or rest there; a torque as `MODEL` has it, times a scale."""
    random = np.random.default_rng(seed)
    time = np.arange(0, seconds, period)
    pace, phase = random.uniform(0.4, 0.9, 6), random.uniform(0, 6, 6)
    angle, swing = pace * time[:, None] + phase, 0.4 * moving
    q, qd = around + swing * np.sin(angle), swing * pace * np.cos(angle)
    states = joint_states(qd, np.zeros(len(time), int), period, cutoff=2.0)
    torque = scale * residual(states, period, random)
    rotation, _, jacobian = flange_kinematics(ur5, q)
    return Free(time, q, qd, jacobian, rotation, states, torque)


def residual(states: States, period: float, random: np.random.Generator) -> Array:
    """Slow and quick part (N, 6) of the contact-free torque, as `MODEL` has them."""
    spread, change = (of[states, np.arange(6)] for of in (MODEL.spread, MODEL.change))
    steady = np.sqrt(np.maximum(spread**2 - change**2, 0))
    slow, quick = random.normal(size=(2, 6))
    result = np.empty(states.shape)
    for t in range(len(states)):
        kept = np.exp(-period * MODEL.rate[states[t]]), np.exp(-2 * period / MODEL.independent)
        slow = kept[0] * slow + np.sqrt(1 - kept[0] ** 2) * random.normal(size=6)
        quick = kept[1] * quick + np.sqrt(1 - kept[1] ** 2) * random.normal(size=6)
        result[t] = steady[t] * slow + change[t] * quick
    return result


def unnoticed(
    estimate: WrenchEstimate, jacobian: Array, states: States, model: ResidualModel
) -> Array:
    """Deviation (N, 6) of the estimate, and of what its torques hide where the gate is shut.

    A push that is there, and is missed, is none of the mixture of which the band holds 95 %.
    """
    noise = TorqueVariances.of(states, model, np.zeros(states.shape))
    hidden, nothing = diagonal(MISSED_DEVIATIONS**2 * noise.hiding()), np.zeros(states.shape)
    missed = regularised_wrench(nothing, jacobian, hidden, PRIOR.unknown()).covariance
    shut = (estimate.wrench == 0).all(axis=1)[:, None]
    return np.where(shut, np.sqrt(np.diagonal(missed, axis1=1, axis2=2)), estimate.std)


def between(time: Array, start: float, end: float) -> Array:
    """(N,) one from start to end, else zero."""
    return np.where((time >= start) & (time < end), 1.0, 0.0)
