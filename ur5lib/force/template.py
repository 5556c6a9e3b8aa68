"""Repeat-aware: contact-free runs of the same trajectory tell what friction does along it.

Friction depends on position and direction more than any formula says, but repeats. Where a run
passes the configuration of a contact-free one in the same direction and at the same speed, that
one's external torque is taken off. Friction warms and cools from run to run: how well it repeats
is learned by taking contact-free runs of the trajectory off each other.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

from ur5lib.force.external_torque import (
    RESTING,
    STATES,
    States,
    finite_rows,
    is_still,
)
from ur5lib.force.residual_model import ResidualModel, Stretch, few_paths, fit_residual_model
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.segments import unbroken
from ur5lib.timeseries.trajectories import SAME, nearest, place


@dataclass(frozen=True)
class ForceInput:
    """q, qd, external torque, joint states, (N, 6) each, NaN where unknown; segment: (N,).

    period: [s]; doubt: (N, 6) [Nm], by which a load that was found may be off; None where none was.
    """

    q: Array
    qd: Array
    torque: Array
    states: States
    segment: Labels
    period: float
    doubt: Array | None = None

    def moves(self) -> Mask:
        """(N,) where it moves and its motion is known."""
        return finite_rows(self.q) & finite_rows(self.qd) & ~is_still(self.states)

    def with_torque(self, torque: Array, states: States) -> Self:
        """The same motion with another torque, and states of another model."""
        return replace(self, torque=torque, states=states)


class Repeated(NamedTuple):
    """External torque (N, 6) without its template, and the states and model that go with it."""

    torque: Array
    states: States
    model: ResidualModel


def repeat_aware(
    run: ForceInput, contact_free: list[ForceInput], model: ResidualModel, cutoff: float
) -> Repeated | None:
    """What `estimate_wrench` needs for the repeat-aware estimate of a run.

    contact_free: other runs without contact and with the same payload, of any trajectory; model: of
    contact-free residuals without template, which goes on holding where nothing matches; cutoff:
    [Hz]. None where no run is of the same trajectory. Where only one is, nothing tells how well it
    repeats, and `model` holds everywhere.
    """
    same = [free for free in contact_free if same_trajectory(run, free)]
    if not same:
        return None
    left = run.torque - template(run, same)
    matched = finite_rows(left)[:, None]
    torque = np.where(matched, left, run.torque)
    if len(same) < 2:
        return Repeated(torque, run.states, model)
    repeated = matched & (run.states < RESTING)
    states = np.where(repeated, run.states + STATES, run.states)
    return Repeated(torque, states, model.beside(learn_repeats(same, cutoff, model.breakaway)))


def learn_repeats(runs: list[ForceInput], cutoff: float, breakaway: Array) -> ResidualModel:
    """Residual model of contact-free runs of one trajectory, each less the template of the others.

    cutoff: [Hz]; breakaway: (6,) [Nm]. As wide as so few runs allow (Student's t). Raises
    InputError for runs that are too short.
    """
    stretches = []
    for index, run in enumerate(runs):
        left = run.torque - template(run, runs[:index] + runs[index + 1 :])
        stretches += [
            Stretch(left[rows], run.states[rows], run.period) for rows in unbroken(run.segment)
        ]
    return fit_residual_model(stretches, cutoff, breakaway).wider(few_paths(len(runs)))


def same_trajectory(run: ForceInput, contact_free: ForceInput) -> bool:
    """Whether the other run passes nearly everywhere where this one moves."""
    moves = run.moves()
    matched = finite_rows(template(run, [contact_free]))
    return bool(moves.any() and matched[moves].mean() >= SAME)


def template(run: ForceInput, contact_free: list[ForceInput]) -> Array:
    """External torque (N, 6) of the nearest sample of the contact-free runs, in (q, qd).

    NaN where the run rests, or none of their samples is near.
    """
    known = [free.moves() & finite_rows(free.torque) for free in contact_free]
    pairs = [*zip(contact_free, known, strict=True)]
    places = np.concatenate([place(free.q, free.qd)[rows] for free, rows in pairs])
    torques = np.concatenate([free.torque[rows] for free, rows in pairs])
    result = np.full_like(run.torque, np.nan)
    moves = np.flatnonzero(run.moves())
    if len(places) and len(moves):
        near, index = nearest(place(run.q, run.qd)[moves], places)
        result[moves[near]] = torques[index[near]]
    return result
