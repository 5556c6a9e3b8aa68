"""Contact wrenches from the external torque: each estimate's problem, and its solution."""

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5lib.force.causal_gate import causal_log_odds
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import past_states
from ur5lib.force.force_input import ForceInput, Gears, may_repeat
from ur5lib.force.residual_model import ResidualModel, Residuals
from ur5lib.force.template import repeat_aware
from ur5lib.force.wrench_estimate import Ablation, WrenchEstimate, estimate_wrench, used_rows
from ur5lib.identification.payload import JudgedLoad
from ur5lib.pipeline.force_input import force_input, inputs
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.prediction import Prediction
from ur5lib.recordings.quality import Contradictions
from ur5lib.tables import read_record
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.metrics import NORMAL95

WHOLE = Ablation()


class Problem(NamedTuple):
    """An external torque with its motion, and its residual model without contact."""

    input: ForceInput
    model: ResidualModel

    @property
    def rows(self) -> Labels:
        """Return the rows (M,) of the samples that the estimate uses."""
        return used_rows(self.input.segment, self.input.period)

    def with_gears(self, gears: Gears) -> "Problem":
        """Return the problem with other gears."""
        return self._replace(input=replace(self.input, gears=gears))

    def solve(
        self, jacobian: Array, prior: ContactPrior, ablation: Ablation = WHOLE
    ) -> WrenchEstimate:
        """Return the contact wrench; jacobian: (M, 6, 6), at `rows`."""
        return estimate_wrench(self.input, jacobian, self.model, prior, ablation)

    def pushed(self, torque: Array) -> "Problem":
        """Return the problem with an additional external torque (N, 6) [Nm]."""
        return self._replace(input=replace(self.input, torque=self.input.torque + torque))

    def odds_under(self, pushed: Array, jacobian: Array, prior: ContactPrior) -> Array:
        """Return the log-odds (N,) of contact with an additional external torque (N, 6) [Nm]."""
        return self.pushed(pushed).solve(jacobian, prior).log_odds


def is_fitted(friction: Friction, contradictions: Contradictions) -> bool:
    """Return whether friction is known, or withheld as recordings contradict the study."""
    return bool(
        friction.from_ or friction.fit.joints or friction.stopped or contradictions.stop_signs
    )


def direct_problems(motion: Motion, currents: Currents, residuals: Residuals) -> dict[str, Problem]:
    """Return the problems of Fmap, by the external torque, and of the observer, by its own.

    Without those whose torque is not known.
    """
    found = {}
    for name, torque, model in (
        ("Fmap", currents.external_torque, residuals.tau_ext),
        ("observer", currents.observed_torque, residuals.tau_observer),
    ):
        if torque is not None and model is not None:
            found[name] = Problem(force_input(motion, torque, currents), model)
    return found


def causal_odds(
    motion: Motion,
    currents: Currents,
    residuals: Residuals,
    jacobian: Array,
    prior: ContactPrior,
) -> Array | None:
    """Return the log-odds (N,) of contact from past currents, None where their torque is not known.

    jacobian: (M, 6, 6), at `used_rows`.
    """
    if currents.causal_torque is None or residuals.tau_causal is None:
        return None
    run = force_input(motion, currents.causal_torque, currents, past_states)
    return causal_log_odds(run, jacobian, residuals.tau_causal, prior)


def repeat_problem(
    fmap: Problem, alike: Iterable[tuple[Currents, Motion]], cutoff: float
) -> dict[str, Problem]:
    """Return the problem "repeat": Fmap less the external torque of the same trajectory without
    contact.

    alike: contact-free recordings of `repeated_runs`; cutoff: of the torques [Hz]. Empty where none
    of them is of the same trajectory.
    """
    repeated = repeat_aware(fmap.input, inputs(alike), fmap.model, cutoff)
    if repeated is None:
        return {}
    own = replace(fmap.input, torque=repeated.torque, states=repeated.states)
    return {"repeat": Problem(own, repeated.model)}


class FreeRun(NamedTuple):
    """A contact-free run: how its currents are predicted, and the files of these and of motion."""

    known: Prediction
    currents: str
    motion: str

    @classmethod
    def of(cls, known: str, currents: str, motion: str) -> "FreeRun":
        """Return the run by its files."""
        return cls(read_record(Prediction, known), currents, motion)


def repeated_runs(
    run: ForceInput, own: Prediction, others: Iterable[FreeRun]
) -> list[tuple[str, str]]:
    """Return the files of currents and motion of the contact-free runs that may repeat a run.

    Those are the others that may carry the same and pass where it moves. own: of the run.
    """
    return [
        (other.currents, other.motion)
        for other in others
        if _same_load(own.load, other.known.load)
        and other.known.extent is not None
        and may_repeat(run, other.known.extent)
    ]


def _same_load(own: JudgedLoad | None, other: JudgedLoad | None) -> bool:
    if own is None or other is None:
        return False
    error = np.hypot(own.std_error, other.std_error)
    return bool(abs(other.carried - own.carried) <= NORMAL95 * error)
