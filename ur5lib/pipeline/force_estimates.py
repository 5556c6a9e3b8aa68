"""Contact wrenches from the external torque: each estimate's problem, and its solution."""

from collections.abc import Iterable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5lib.force.causal_gate import causal_log_odds
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import finite_rows, past_states
from ur5lib.force.force_input import ForceInput, may_repeat
from ur5lib.force.residual_model import ResidualModel, Residuals
from ur5lib.force.template import repeat_aware
from ur5lib.force.wrench_estimate import (
    NOTHING_LEFT_OUT,
    Ablation,
    WrenchEstimate,
    estimate_wrench,
    used_rows,
)
from ur5lib.pipeline.force_input import force_input, inputs
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.friction import Friction
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.prediction import Prediction
from ur5lib.recordings.quality import Contradictions
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.metrics import NORMAL95


class Problem(NamedTuple):
    """An external torque with its motion, and its residual model without contact."""

    input: ForceInput
    model: ResidualModel

    @property
    def rows(self) -> Labels:
        """Return the rows (M,) of the samples that the estimate uses."""
        return used_rows(self.input.segment, self.input.period)

    def solve(
        self, jacobian: Array, prior: ContactPrior, ablation: Ablation = NOTHING_LEFT_OUT
    ) -> WrenchEstimate:
        """Return the contact wrench; jacobian: (M, 6, 6), at `rows`."""
        return estimate_wrench(self.input, jacobian, self.model, prior, ablation)

    def pushed(self, torque: Array) -> "Problem":
        """Return the problem with an additional external torque (N, 6) [Nm]."""
        return self._replace(input=replace(self.input, torque=self.input.torque + torque))


def is_fitted(friction: Friction, contradictions: Contradictions) -> bool:
    """Return whether friction is known, or withheld as recordings contradict the study."""
    return bool(
        friction.from_ or friction.fit.joints or friction.stopped or contradictions.stop_signs
    )


def direct_problems(motion: Motion, currents: Currents, residuals: Residuals) -> dict[str, Problem]:
    """Return the problems of Fmap, by the external torque, and of the observer, by its own.

    Without those whose torque is not known, as throughout a recording of half a second.
    """
    found = {}
    for name, torque, model in (
        ("Fmap", currents.external_torque, residuals.tau_ext),
        ("observer", currents.observed_torque, residuals.tau_observer),
    ):
        if torque is not None and model is not None and finite_rows(torque).any():
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

    alike: contact-free recordings that `may_be_template`; cutoff: of the torques [Hz]. Empty where
    none of them is of the same trajectory.
    """
    repeated = repeat_aware(fmap.input, inputs(alike), fmap.model, cutoff)
    return {} if repeated is None else {"repeat": Problem(*repeated)}


def may_be_template(run: ForceInput, own: Prediction, other: Prediction) -> bool:
    """Return whether a contact-free run may be of the same trajectory and load as another.

    It passes where the other moves, and the masses agree within their 95 % band.
    """
    if own.load is None or other.load is None or other.extent is None:
        return False
    error = np.hypot(own.load.std_error, other.load.std_error)
    alike = abs(other.load.carried - own.load.carried) <= NORMAL95 * error
    return bool(alike) and may_repeat(run, other.extent)
