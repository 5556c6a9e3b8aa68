"""A recording as the estimators of its contact wrench take it."""

from functools import cached_property
from typing import Any

from ur5lib.force.causal_gate import causal_log_odds
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import past_states
from ur5lib.force.residual_model import Residuals
from ur5lib.force.wrench_estimate import WrenchEstimate, used_rows
from ur5lib.pipeline.force_estimates import (
    Problem,
    direct_problems,
    is_fitted,
    repeat_problem,
    repeated_runs,
)
from ur5lib.pipeline.force_input import force_input
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.motion import Motion
from ur5lib.tables import read_json, read_record
from ur5lib.timeseries.arrays import Array


class ForceRun:
    """A recording; what its estimators share is read and solved once, when it is asked for.

    files: paths of its records and of its arm's parameters, by the names of the step's inputs;
    settings: the step's.
    """

    def __init__(self, files: Any, settings: Any) -> None:
        self.files, self.settings = files, settings
        self.prior = ContactPrior(force=settings.contact_force_n)

    @cached_property
    def motion(self) -> Motion:
        """Return the smoothed motion."""
        return Motion.read(self.files.motion)

    @cached_property
    def currents(self) -> Currents:
        """Return the predicted currents and external torques."""
        return Currents.read(self.files.currents)

    @cached_property
    def residuals(self) -> Residuals:
        """Return the residual models."""
        return read_record(Residuals, self.files.residuals)

    @cached_property
    def is_fitted(self) -> bool:
        """Return whether the arm's friction was fitted, and may be used on this recording."""
        return is_fitted(read_json(self.files.friction), read_json(self.files.contradictions))

    @cached_property
    def jacobian(self) -> Array:
        """Return the Jacobians (M, 6, 6) at `used_rows`."""
        rows = used_rows(self.motion.segment, self.motion.period)
        return Kinematics.read(self.files.kinematics, rows).jacobian

    @cached_property
    def problems(self) -> dict[str, Problem]:
        """Return the problems of `direct_problems`, none without fitted friction."""
        if not self.is_fitted:
            return {}
        return direct_problems(self.motion, self.currents, self.residuals)

    @cached_property
    def fmap(self) -> WrenchEstimate | None:
        """Return F̂ᵐᵃᵖ."""
        return self.solved(self.problems.get("Fmap"))

    def solved(self, problem: Problem | None) -> WrenchEstimate | None:
        """Return the most probable wrench of a problem, if there is one."""
        return None if problem is None else problem.solve(self.jacobian, self.prior)

    def repeat(self) -> Problem | None:
        """Return the problem of F̂ᵐᵃᵖ less the torque of the same trajectory without contact."""
        if (direct := self.problems.get("Fmap")) is None:
            return None
        index, load = read_json(self.files.free_runs), read_json(self.files.load).get("load")
        files = repeated_runs(direct.input, self.settings.recording, load, index)
        alike = ((Currents.read(currents), Motion.read(motion)) for currents, motion in files)
        return repeat_problem(direct, alike, self.settings.cutoff_hz)

    def causal_odds(self) -> Array | None:
        """Return the log-odds (N,) of contact from past currents, None where they are unknown."""
        torque = self.currents.causal_torque if self.is_fitted else None
        if torque is None or (model := self.residuals.tau_causal) is None:
            return None
        given = force_input(self.motion, torque, self.currents, past_states)
        return causal_log_odds(given, self.jacobian, model, self.prior)
