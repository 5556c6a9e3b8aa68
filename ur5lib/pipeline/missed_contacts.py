"""Up to which size contacts are missed, by trials on the contact-free recordings of a fit."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.residual_model import Residuals
from ur5lib.force.trial_contacts import Tried, largest_of_trials, try_contacts
from ur5lib.pipeline.force_estimates import Problem, direct_problems
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.residual_fit import TORQUES
from ur5lib.timeseries.arrays import Array


def with_trials(
    residuals: Residuals,
    recordings: Sequence[tuple[Currents, Motion, Array]],
    prior: ContactPrior,
) -> Residuals:
    """Return residual models with the size up to which contacts are missed, `missed_to`.

    residuals: of `residual_summary`; recordings: those of the fit, with their Jacobians
    (M, 6, 6), at `used_rows`. Each model counts the size in its own deviations; the trials are
    those of the external torque.
    """
    if residuals.tau_ext is None:
        return residuals
    random, tried = np.random.default_rng(0), []
    for currents, motion, jacobian in recordings:
        if (fmap := direct_problems(motion, currents, residuals).get("Fmap")) is not None:
            tried.append(_tried(fmap, jacobian, prior, random))
    missed_to = largest_of_trials(tried)
    known = {name: getattr(residuals, name) for name in TORQUES}
    tested = {name: model and replace(model, missed_to=missed_to) for name, model in known.items()}
    return replace(residuals, **tested)


def _tried(
    problem: Problem, jacobian: Array, prior: ContactPrior, random: np.random.Generator
) -> Tried:
    def wrench_under(torque: Array) -> Array:
        return problem.pushed(torque).solve(jacobian, prior).wrench

    return try_contacts(wrench_under, problem.input, jacobian, problem.model, prior, random)
