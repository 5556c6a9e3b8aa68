"""Which friction terms a joint needs, judged on recordings that were left out."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ur5lib.identification.friction import BASE, Term, is_dissipative
from ur5lib.identification.prior import JointPrior
from ur5lib.identification.regression import ROUNDS, Regression, huber_weight, regress
from ur5lib.identification.samples import Samples
from ur5lib.timeseries.arrays import Array

# Of the left-out error's logarithm. Many terms are tried, so one has to win by three standard
# errors over the recordings, and by a twentieth: less is not worth a term.
STANDARD_ERRORS = 3.0
GAIN = 0.05
LOOSE = 10.0  # times the prior's spread: no term is to make up for a torque constant told wrong
FEWEST = 20  # samples (2 s) of a recording or stretch that say how good a model is


def choose_presliding(candidates: Sequence[Samples], prior: JointPrior) -> Samples:
    """Of a joint's samples under several distances of presliding, those that tell most.

    They leave the least error on recordings left out; the first, where none can be.
    """

    def error(samples: Samples) -> float:
        errors = left_out_errors(samples, BASE, prior)
        return float(np.log(errors).mean()) if len(errors) else 0.0

    return min(candidates, key=error)


def choose_terms(samples: Samples, prior: JointPrior) -> tuple[Term, ...]:
    """BASE and the terms that a joint needs besides, one of a kind, in the order they were taken.

    Forward selection: the term that lowers the error on recordings left out the most, among those
    that lower it for certain and leave friction dissipative; and so on until there is none.
    """
    moving = samples.where(samples.moving)
    prior = replace(prior, std=LOOSE * prior.std)
    chosen: tuple[Term, ...] = BASE
    errors = left_out_errors(moving, chosen, prior)
    while len(errors) > 1:
        kinds = {term.kind for term in chosen[len(BASE) :]}
        tried = {
            term: left_out_errors(moving, (*chosen, term), prior)
            for term in samples.terms[len(BASE) :]
            if term.kind not in kinds
        }
        better = [
            term
            for term, error in tried.items()
            if is_better(error, errors) and _brakes(moving, (*chosen, term), prior)
        ]
        if not better:
            break
        best = min(better, key=lambda term: np.log(tried[term]).mean())
        chosen, errors = (*chosen, best), tried[best]
    return chosen


def is_better(error: Array, reference: Array) -> bool:
    """Whether errors (U,) on left-out units are smaller than others for certain."""
    gain = np.log(reference / error)
    uncertainty = gain.std(ddof=1) / np.sqrt(len(gain))
    return bool(gain.mean() > max(GAIN, STANDARD_ERRORS * uncertainty))


def left_out_errors(samples: Samples, terms: Sequence[Term], prior: JointPrior) -> Array:
    """RMSE [A] on each unit with enough samples, of a fit on the other recordings."""
    return _errors(left_out_residuals(samples, terms, prior), samples)


def left_out_residuals(samples: Samples, terms: Sequence[Term], prior: JointPrior) -> Array:
    """Measured minus predicted current (n,) [A], each path predicted from the others.

    NaN where there is no other path.
    """
    residual = np.full(len(samples.current), np.nan)
    present = np.unique(samples.path)
    for one in present if len(present) > 1 else []:
        test = samples.path == one
        others, here = samples.where(~test), samples.where(test)
        coefficients = regress_samples(others, terms, prior).coefficients
        held = held_current(others, terms, coefficients)
        residual[test] = here.current - here.design(terms) @ coefficients - held * here.held
    return residual


def regress_samples(samples: Samples, terms: Sequence[Term], prior: JointPrior) -> Regression:
    """The regression on the torque, an offset and these terms, of the samples in motion."""
    moving = samples.where(samples.moving)
    return regress(moving.design(terms), moving.current, moving.block, prior.over(terms))


def held_current(samples: Samples, terms: Sequence[Term], coefficients: Array) -> float:
    """By how much more current [A] friction holds a joint at rest than one that slides; or less.

    Huber's slope, without offset, of what the samples at rest leave unexplained.
    """
    rest = samples.where(~samples.moving)
    residual = rest.current - rest.design(terms) @ coefficients
    slope, weight = 0.0, np.ones(len(residual))
    for _ in range(ROUNDS if rest.held.any() else 0):
        slope = float((weight * rest.held) @ residual / (weight @ rest.held**2))
        weight = huber_weight(residual - slope * rest.held)
    return slope


def _errors(residual: Array, samples: Samples) -> Array:
    known = np.isfinite(residual)
    units = [residual[known & (samples.unit == one)] for one in np.unique(samples.unit)]
    return np.array([np.sqrt(np.mean(rows**2)) for rows in units if len(rows) >= FEWEST])


def _brakes(samples: Samples, terms: tuple[Term, ...], prior: JointPrior) -> bool:
    coefficients = regress_samples(samples, terms, prior).coefficients
    torque, speed = (np.abs(samples.columns[:, column]) for column in (0, 3))
    speeds = np.linspace(-1, 1, 42) * speed.max()
    loads = np.linspace(torque.min(), torque.max(), 5)
    return is_dissipative(terms, coefficients[2:], speeds, loads)
