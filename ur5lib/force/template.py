"""Repeat-aware: contact-free runs of the same trajectory tell what friction does along it.

Friction depends on position and direction more than any formula says, but repeats. Where a run
passes the configuration of a contact-free one in the same direction and at the same speed, that
one's external torque is taken off. Friction warms and cools from run to run: how well it repeats
is learned by taking contact-free runs of the trajectory off each other.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from ur5lib.force.external_torque import (
    RESTING,
    STATES,
    Mask,
    States,
    at_rest,
    finite_rows,
    unbroken,
)
from ur5lib.force.residual_model import ResidualModel, fit_residual_model

Array = NDArray[np.float64]

NEAR_POSITION, NEAR_VELOCITY = 0.02, 0.1  # rad, rad/s: the root sum of squares over all joints
SAME = 0.9  # share of a run's motion that must match


@dataclass(frozen=True)
class Run:
    """q, qd, external torque, joint states, (N, 6) each, NaN where unknown; segment: (N,)."""

    q: Array
    qd: Array
    torque: Array
    states: States
    segment: NDArray[np.int64]

    def moves(self) -> Mask:
        """(N,) where it moves and its motion is known."""
        return finite_rows(self.q) & finite_rows(self.qd) & ~at_rest(self.states)


class Repeated(NamedTuple):
    """External torque (N, 6) without its template, and the states and model that go with it."""

    torque: Array
    states: States
    model: ResidualModel


def repeat_aware(
    run: Run, contact_free: list[Run], model: ResidualModel, period: float, cutoff: float
) -> Repeated | None:
    """What `estimate_wrench` needs for the repeat-aware estimate of a run.

    contact_free: other runs without contact, of any trajectory; model: of contact-free residuals
    without template, which goes on holding where nothing matches; period: [s]; cutoff: [Hz].
    None where no run is of the same trajectory. Where only one is, nothing tells how well it
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
    repeated = matched & (run.states != RESTING)
    states = np.where(repeated, run.states + STATES, run.states)
    return Repeated(torque, states, model.beside(learn_repeats(same, period, cutoff)))


def learn_repeats(runs: list[Run], period: float, cutoff: float) -> ResidualModel:
    """Residual model of contact-free runs of one trajectory, each less the template of the others.

    period: [s]; cutoff: [Hz]. Raises InputError for runs that are too short.
    """
    stretches = []
    for index, run in enumerate(runs):
        left = run.torque - template(run, runs[:index] + runs[index + 1 :])
        stretches += [(left[rows], run.states[rows]) for rows in unbroken(run.segment)]
    return fit_residual_model(stretches, period, cutoff)


def same_trajectory(run: Run, contact_free: Run) -> bool:
    """Whether the other run passes nearly everywhere where this one moves."""
    moves = run.moves()
    matched = finite_rows(template(run, [contact_free]))
    return bool(moves.any() and matched[moves].mean() >= SAME)


def template(run: Run, contact_free: list[Run]) -> Array:
    """External torque (N, 6) of the nearest sample of the contact-free runs, in (q, qd).

    NaN where the run rests, or none of their samples is near.
    """
    known = [free.moves() & finite_rows(free.torque) for free in contact_free]
    places = [_place(free)[rows] for free, rows in zip(contact_free, known, strict=True)]
    torques = [free.torque[rows] for free, rows in zip(contact_free, known, strict=True)]
    result = np.full_like(run.torque, np.nan)
    moves = np.flatnonzero(run.moves())
    tree = cKDTree(np.concatenate(places))
    distance, index = tree.query(_place(run)[moves], distance_upper_bound=1.0)
    near = np.isfinite(distance)
    result[moves[near]] = np.concatenate(torques)[index[near]]
    return result


def _place(run: Run) -> Array:
    return np.concatenate([run.q / NEAR_POSITION, run.qd / NEAR_VELOCITY], axis=1)
