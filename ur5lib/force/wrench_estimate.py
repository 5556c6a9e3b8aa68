"""The contact wrench over a recording, its band, and the odds that there is a contact.

tau_ext = J^T F + b + e, with the slow part b and the quick part e of `ResidualModel`. Smoothing b
with contacts left out, and weighing at each sample whether there is one, take turns.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ur5lib.force.background import Smoothed, smooth
from ur5lib.force.external_torque import RESTING, STATES, States, finite_rows, unbroken
from ur5lib.force.hidden_markov import log_odds, probability
from ur5lib.force.hypotheses import ContactPrior, Hypotheses
from ur5lib.force.residual_model import ResidualModel

Array = NDArray[np.float64]

ROUNDS = 6  # from five on, forces change by less than 1 N, also at rest


@dataclass(frozen=True)
class WrenchEstimate:
    """Environment on arm, base axes, at the origin of frame 6.

    wrench, std: (N, 6) [N, Nm], wrench ± 1.96 std is the 95 % band; log_odds: (N,), of contact
    against none; background: (N, 6) [Nm], the slow part of the external torque.
    """

    wrench: Array
    std: Array
    log_odds: Array
    background: Array


def estimate_wrench(
    torque: Array,
    jacobian: Array,
    states: States,
    segment: NDArray[np.int64],
    period: float,
    model: ResidualModel,
    prior: ContactPrior,
) -> WrenchEstimate:
    """The wrench of each unbroken stretch, by all of its samples (it is an offline estimate).

    torque: external, low-passed, (N, 6) [Nm], rows of NaN where it is unknown; jacobian:
    (N, 6, 6); states: (N, 6), of `model`; segment: (N,); period: [s]. Rows without a Jacobian,
    where the arm's pose is unknown, come out as NaN.
    """
    posed = finite_rows(jacobian.reshape(-1, 36))
    torque = np.where(posed[:, None], torque, np.nan)
    jacobian = np.where(posed[:, None, None], jacobian, 0.0)
    parts = []
    for rows in unbroken(segment):
        hypotheses = Hypotheses.of(jacobian[rows], states[rows], model, prior)
        parts.append(_estimate(torque[rows], states[rows], period, model, hypotheses))
    columns = [np.concatenate(column) for column in zip(*parts, strict=True)]
    for column in columns:
        column[~posed] = np.nan
    return WrenchEstimate(*columns)


def _estimate(
    torque: Array, states: States, period: float, model: ResidualModel, hypotheses: Hypotheses
) -> tuple[Array, Array, Array, Array]:
    prior = hypotheses.prior
    worth = period / model.independent  # of an independent value, that each sample has
    free, contact = hypotheses.when_free(), hypotheses.in_contact()
    spread = model.covariance(model.spread, states)
    resting = states % STATES == RESTING  # where a push redraws what stiction holds
    likely = np.full(len(torque), prior.share())
    for _ in range(ROUNDS):
        noise = free + likely[:, None, None] * (contact - free)
        redrawn = resting * likely[:, None] / prior.duration
        decay = np.exp(-period * (model.rate[states] + redrawn))
        slow = smooth(torque, noise / worth, spread, decay)
        evidence = worth * hypotheses.evidence(torque - slow.mean, slow.covariance)
        odds = log_odds(evidence, period / prior.pause, period / prior.duration)
        likely = probability(odds)
    wrench, std = _mixture(torque, slow, likely, hypotheses)
    return wrench, std, odds, slow.mean


def _mixture(
    torque: Array, slow: Smoothed, likely: Array, hypotheses: Hypotheses
) -> tuple[Array, Array]:
    """Mean and standard deviation: in contact F̂ᵐᵃᵖ, otherwise none but what may be hidden."""
    contact = hypotheses.contact_wrench(torque - slow.mean)
    by_slow = contact.gain @ slow.covariance @ contact.gain.mT
    in_contact = _diagonal(contact.covariance + by_slow) + contact.mean**2
    hidden = _diagonal(hypotheses.hidden_wrench(torque))
    wrench = likely[:, None] * contact.mean
    second = likely[:, None] * in_contact + (1 - likely[:, None]) * hidden
    return wrench, np.sqrt(np.maximum(second - wrench**2, 0.0))


def _diagonal(matrices: Array) -> Array:
    return np.diagonal(matrices, axis1=1, axis2=2)
