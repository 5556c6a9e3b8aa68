"""Repeat-aware estimate: contact-free runs of the same trajectory as a template of friction.

Friction depends on position and direction in a way that no formula describes, but it repeats. Where
a run passes the configuration of a contact-free one at the same velocity, the external torque of
that one is subtracted. Friction changes with temperature from run to run: its repeatability is
estimated by subtracting contact-free runs of the trajectory from one another.
"""

from dataclasses import replace

import numpy as np

from ur5lib.force.external_torque import RESTING, STATES, finite_rows
from ur5lib.force.force_input import ForceInput
from ur5lib.force.residual_model import ResidualModel, Stretch, few_paths, fit_residual_model
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import unbroken
from ur5lib.timeseries.trajectories import SAME, nearest, place


def repeat_aware(
    run: ForceInput, contact_free: list[ForceInput], model: ResidualModel, cutoff: float
) -> tuple[ForceInput, ResidualModel] | None:
    """Return the run without its template, with its states of the model that is returned, too.

    contact_free: other runs without contact and with the same payload, of any trajectory; model: of
    contact-free residuals without template, used where no sample matches; cutoff: [Hz]. None if no
    run is of the same trajectory. With a single one, the repeatability is unknown, and `model` is
    used everywhere.
    """
    same = [free for free in contact_free if same_trajectory(run, free)]
    if not same:
        return None
    residual = run.torque - template(run, same)
    matched = finite_rows(residual)[:, None]
    torque = np.where(matched, residual, run.torque)
    if len(same) < 2:
        return replace(run, torque=torque), model
    repeated = matched & (run.states < RESTING)
    states = np.where(repeated, run.states + STATES, run.states)
    both = model.beside(learn_repeats(same, cutoff, model.breakaway))
    return replace(run, torque=torque, states=states), both


def learn_repeats(runs: list[ForceInput], cutoff: float, breakaway: Array) -> ResidualModel:
    """Fit the residual model to contact-free runs of one trajectory without their templates.

    Each run's template is from the others. cutoff: [Hz]; breakaway: (6,) [Nm]. Widened by Student's
    t for few runs. Raises InputError for runs that are too short.
    """
    stretches = []
    for index, run in enumerate(runs):
        residual = run.torque - template(run, runs[:index] + runs[index + 1 :])
        stretches += [
            Stretch(residual[rows], run.states[rows], run.period) for rows in unbroken(run.segment)
        ]
    return fit_residual_model(stretches, cutoff, breakaway).wider(few_paths(len(runs)))


def same_trajectory(run: ForceInput, contact_free: ForceInput) -> bool:
    """Return whether the other run passes nearly all states in which this one moves."""
    moves = run.moves()
    matched = finite_rows(template(run, [contact_free]))
    return bool(moves.any() and matched[moves].mean() >= SAME)


def template(run: ForceInput, contact_free: list[ForceInput]) -> Array:
    """Return the external torque (N, 6) of the nearest sample of the contact-free runs in (q, qd).

    NaN where the run rests, or none of their samples is near.
    """
    pairs = [(free, free.offered()) for free in contact_free]
    places = np.concatenate([place(free.q, free.qd)[rows] for free, rows in pairs])
    torques = np.concatenate([free.torque[rows] for free, rows in pairs])
    result = np.full_like(run.torque, np.nan)
    moves = np.flatnonzero(run.moves())
    if len(places) and len(moves):
        near, index = nearest(place(run.q, run.qd)[moves], places)
        result[moves[near]] = torques[index[near]]
    return result
