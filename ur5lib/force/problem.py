"""The contact wrench from the external torque: the problem, and its solution."""

from dataclasses import replace
from typing import NamedTuple

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import JointState, finite_rows, is_still
from ur5lib.force.force_input import ForceInput, force_input
from ur5lib.force.residual_model import ResidualModel, Residuals
from ur5lib.force.shown_friction import MIN_SHARE, shown_friction
from ur5lib.force.wrench_estimate import (
    WrenchEstimate,
    contact_log_odds,
    estimate_wrench,
    used_rows,
)
from ur5lib.records.currents import Currents
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.quality import Contradictions
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array, Labels, Mask


class Problem(NamedTuple):
    """What the contact wrench is estimated from: an external torque with its motion, and the model
    of that torque without contact.
    """

    input: ForceInput
    model: ResidualModel

    @property
    def rows(self) -> Labels:
        """Return the numbers (M,) of the rows that the estimate uses."""
        return used_rows(self.input.segment, self.input.period, self.model.cutoff)

    def solve(
        self,
        jacobian: Array,
        prior: ContactPrior,
        place: Array | None = None,
        arm: Robot | None = None,
    ) -> WrenchEstimate:
        """Return the contact wrench; arguments as of `estimate_wrench`, at `rows`; arm: whose links
        may be touched in motion, None: the last one alone.
        """
        frames = None if arm is None else link_frames(arm, self.input.q[self.rows])
        return estimate_wrench(self.input, jacobian, self.model, prior, place, frames)

    def contact_log_odds(self, added: Array, jacobian: Array, prior: ContactPrior) -> list[Array]:
        """Return only the log-odds (N,) of contact, with each of some additional external torques
        (R, N, 6) [Nm]; jacobian: as of `solve`.
        """
        return contact_log_odds(self.input, added, jacobian, self.model, prior)

    def held(self, tared: Mask) -> "Problem":
        """Return the problem with the state TARED for joints at rest in the samples (N,) to which a
        tare applies.
        """
        states = self.input.states.copy()
        states[tared & is_still(states)] = JointState.TARED
        return Problem(replace(self.input, states=states), self.model.with_tare())


def is_fitted(friction: Friction, contradictions: Contradictions) -> bool:
    """Return whether friction is fitted or taken over from another study, or withheld because
    recordings contradict the study.
    """
    return bool(
        friction.from_ or friction.fit.joints or friction.stopped or contradictions.stop_signs
    )


def fmap_problem(motion: Motion, currents: Currents, residuals: Residuals) -> Problem | None:
    """Return the problem of F̂ᵐᵃᵖ; None where its torque is unknown, as in half a second, or the
    currents show `unusual_friction`.
    """
    problem = _problem(motion, currents, residuals)
    if problem is None or unusual_friction(motion, currents, residuals) is not None:
        return None
    return problem if currents.tared is None else problem.held(currents.tared)


def unusual_friction(motion: Motion, currents: Currents, residuals: Residuals) -> float | None:
    """Return the share of the usual friction that the currents show, if nothing was fitted and it
    is below MIN_SHARE; None otherwise.

    A hand then leads the arm, and contacts cannot be recognised by friction.
    """
    problem = _problem(motion, currents, residuals)
    if problem is None or not problem.model.usual:
        return None
    share = shown_friction(problem.input, problem.model.breakaway)
    return share if share < MIN_SHARE else None


def _problem(motion: Motion, currents: Currents, residuals: Residuals) -> Problem | None:
    torque, model = currents.external_torque, residuals.tau_ext
    if torque is None or model is None or not finite_rows(torque).any():
        return None
    return Problem(force_input(motion, torque, currents, model.cutoff), model)
