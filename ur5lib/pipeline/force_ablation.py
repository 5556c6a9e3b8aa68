"""Ablation of the force estimate: its error in contact without one part."""

from dataclasses import replace

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.detection import contacts, in_contact
from ur5lib.force.wrench_estimate import Ablation
from ur5lib.pipeline.force_estimates import Problem
from ur5lib.pipeline.records.force_errors import Ablated
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import coverage, interval_score, mean_absolute_error
from ur5lib.timeseries.segments import marked


def variants(
    problem: Problem, jacobian: Array, prior: ContactPrior, reference: Array
) -> dict[str, tuple[Array, Array]]:
    """Return wrench and standard deviation of F̂ᵐᵃᵖ with one part replaced or omitted.

    jacobian: (M, 6, 6), at the problem's `rows`; reference: the sensor's force (N, 3) [N].
    """
    touched = marked(contacts(np.linalg.norm(reference, axis=1)), len(reference))
    settings = {
        "contacts by the sensor": (prior, Ablation(contacts=touched)),
        "no background": (prior, Ablation(background=False)),
        "usual contact": (prior, Ablation(learning=False)),
    }
    estimates = {name: problem.solve(jacobian, *own) for name, own in settings.items()}
    if (gears := problem.input.gears) is not None:
        for name, other in {
            "no load friction": replace(gears, loss=0 * gears.loss),
            "friction of the fit": replace(gears, friction=0 * gears.friction),
        }.items():
            changed = problem._replace(input=replace(problem.input, gears=other))
            estimates[name] = changed.solve(jacobian, prior)
    return {name: (own.wrench, own.std) for name, own in estimates.items()}


def figures_in_contact(wrench: Array, std: Array, reference: Array) -> Ablated:
    """Return error, coverage and interval score (3,) in contact, by the sensor's force (N, 3)."""
    where = in_contact(np.linalg.norm(reference, axis=1)) & np.isfinite(wrench).all(axis=1)
    part = wrench[where, :3], std[where, :3], reference[where]
    return Ablated(mean_absolute_error(part[0], part[2]), coverage(*part), interval_score(*part))
