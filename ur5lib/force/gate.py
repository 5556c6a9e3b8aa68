"""When the arm is in contact: a hidden Markov chain over what may make the torque leave zero.

At each sample the arm is free; or, at rest, hunting: after a touch, stick and slip make joints
wander; or in a contact of one of several sizes and levers, which it keeps to its end. What a free
arm's torque drifts by, the background, is smoothed with contacts left out. Smoothing it, and
weighing the states, take turns.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from ur5lib.force import hidden_markov
from ur5lib.force.background import Smoothed, smooth
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import STATES, STILL, States, finite_rows
from ur5lib.force.residual_model import ResidualModel
from ur5lib.timeseries.arrays import Array, Mask

# How much of the background's uncertainty counts in each round: at first little, so that nothing
# that may be a contact is learnt as background.
ROUNDS = (0.0, 0.25, 0.5, 1.0, 1.0, 1.0)
LEFT_OUT = 0.5  # probability of contact from which a sample tells nothing of the background
HELD = 0.3  # of the breakaway torque: no joint at rest repeats better
CERTAIN = 1e-4
QUICK = 0.3  # share of a load's error that changes within half a push


class Gate(NamedTuple):
    """Probability of contact (N,), the same by past samples alone, and the background."""

    probability: Array
    causal: Array
    background: Smoothed


@dataclass(frozen=True)
class Noise:
    """Covariances (N, 6, 6) [Nm²] of the external torque besides a contact's.

    quick: of the quick part; spread: of all; hidden: what dry friction may take up of a contact;
    still: (N, 6), which joints rest while the whole arm does.
    """

    quick: Array
    spread: Array
    hidden: Array
    still: Mask

    @classmethod
    def of(cls, states: States, model: ResidualModel, prior: ContactPrior, doubt: Array) -> "Noise":
        """Of samples in the given joint states (N, 6); doubt: (N, 6) [Nm], of a load."""
        still = states % STATES == STILL
        held = np.where(still, HELD * model.breakaway, 0.0) ** 2
        taken = np.where(still, prior.stiction, prior.rubbing) * model.breakaway
        return cls(
            quick=model.covariance(model.change, states) + diagonal(QUICK * doubt**2),
            spread=model.covariance(model.spread, states) + diagonal(held + doubt**2),
            hidden=diagonal(taken**2),
            still=still,
        )


def find_contacts(
    torque: Array,
    jacobian: Array,
    states: States,
    period: float,
    noise: Noise,
    model: ResidualModel,
    prior: ContactPrior,
    told: Mask | None = None,
) -> Gate:
    """When a stretch without a gap is in contact; arguments as of `estimate_wrench`.

    told: (N,), where it is by a sensor: then only the background is found.
    """
    known, worth = finite_rows(torque), min(1.0, period / model.independent)
    filled = np.where(known[:, None], torque, 0.0)
    free = _free_covariances(jacobian, noise, model, prior)
    chain = Chain.of(len(free), len(prior.bank()), period, prior)
    slow = held = Smoothed(np.zeros_like(filled), noise.spread)
    for share in ROUNDS:
        evidence = np.stack(
            [
                *(log_density(filled - held.mean, c + share * held.covariance) for c in free),
                *(
                    log_density(
                        filled - slow.mean,
                        noise.quick
                        + noise.hidden
                        + share * slow.covariance
                        + jacobian.mT @ contact @ jacobian,
                    )
                    for contact in prior.bank()
                ),
            ],
            axis=1,
        )
        evidence *= worth * known[:, None]
        weight = hidden_markov.posterior(evidence, chain.transitions, chain.start)
        contact = weight[:, len(free) :].sum(axis=1)
        contact = contact if told is None else told.astype(float)
        measured = _measurement_noise(free, weight, contact) / worth
        # A push may redraw what stiction holds; where none came, it stays.
        redrawn = noise.still * contact[:, None] / prior.duration
        rate = model.rate[states]
        slow = smooth(torque, measured, noise.spread, np.exp(-period * (rate + redrawn)))
        held = slow
        if noise.still.any():
            held = smooth(torque, measured, noise.spread, np.exp(-period * rate))
    past = hidden_markov.filtered(evidence, chain.transitions, chain.start)
    return Gate(contact, np.exp(past[:, len(free) :]).sum(axis=1), slow)


def _free_covariances(
    jacobian: Array, noise: Noise, model: ResidualModel, prior: ContactPrior
) -> list[Array]:
    """Of a free arm: undisturbed, and hunting by several shares of the breakaway torque."""
    undisturbed = noise.quick + jacobian.mT @ prior.when_free() @ jacobian
    return [
        undisturbed + diagonal(np.where(noise.still, share * model.breakaway, 0.0) ** 2)
        for share in (0.0, *prior.hunting)
    ]


def _measurement_noise(free: list[Array], weight: Array, contact: Array) -> Array:
    """Of the torque as a measurement of the background: next to none in contact."""
    share = weight[:, : len(free)] + 1e-12
    share = share / share.sum(axis=1, keepdims=True)
    mean = sum(own[:, None, None] * c for own, c in zip(share.T, free, strict=True))
    told = np.where(contact > LEFT_OUT, CERTAIN, np.maximum(1 - contact, CERTAIN))
    return np.asarray(mean / told[:, None, None])


@dataclass(frozen=True)
class Chain:
    """Transitions (S, S) and start (S,) of the states: free, hunting (several), contacts."""

    transitions: Array
    start: Array

    @classmethod
    def of(cls, free: int, contacts: int, period: float, prior: ContactPrior) -> "Chain":
        """Of `free` states, the first undisturbed, and so many kinds of contact; period: [s]."""
        begins, ends = period / prior.pause, period / prior.duration
        settles, wanders = period / prior.settling, period * prior.unprovoked
        hunting = free - 1
        steps = np.zeros((free + contacts, free + contacts))
        steps[:free, free:] = begins / contacts
        steps[0, 0], steps[0, 1:free] = 1 - begins - wanders, wanders / hunting
        steps[1:free, 1:free] = np.eye(hunting) * (1 - begins - settles)
        steps[1:free, 0] = settles
        steps[free:, free:] = np.eye(contacts) * (1 - ends)
        steps[free:, 1:free] = ends / hunting
        start = [0.6, *[0.3 / hunting] * hunting, *[0.1 / contacts] * contacts]
        return cls(steps, np.array(start))


def diagonal(variance: Array) -> Array:
    """Matrices (N, 6, 6) with variances (N, 6) on their diagonals."""
    return variance[:, :, None] * np.eye(6)


def log_density(x: Array, covariance: Array) -> Array:
    """Log-density (N,) of a normal distribution around zero, up to a constant."""
    factor = np.linalg.cholesky(covariance)
    whitened = np.linalg.solve(factor, x[..., None])[..., 0]
    roots = np.diagonal(factor, axis1=1, axis2=2)
    return np.asarray(-0.5 * (whitened**2).sum(axis=1) - np.log(roots).sum(axis=1))
