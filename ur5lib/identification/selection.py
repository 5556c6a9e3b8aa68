"""Selection of friction terms by cross-validation over paths."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import ROUNDS, Regression, huber_weight, regress
from ur5lib.identification.samples import Samples, apart_from
from ur5lib.robots.friction import BASE, Term, is_dissipative
from ur5lib.timeseries.arrays import Array

# Required decrease of the logarithm of the cross-validated error: three standard errors, because
# many terms are tried, and 5 %.
STANDARD_ERRORS = 3.0
GAIN = 0.05
LOOSE = 10.0  # factor on the width of 1/k, so that no term compensates a wrong torque constant
HELD = -0.45  # of Coulomb friction: `held_current`, the median of 24 joints of four arms
FEWEST = 20  # samples (2 s) of a unit that counts


def choose_reversal(
    dahl: Sequence[Samples], karnopp: Samples, prior: Prior
) -> tuple[Samples, tuple[float, ...]]:
    """Return a joint's samples with the model of friction's reversal that predicts others best.

    That is Dahl's with the presliding distance of the least cross-validated error, or Karnopp's if
    it is significantly better, like a term. Beside them are the errors [A] of all, in their order:
    geometric means over units, empty without a second path, where the first samples are returned.
    """
    errors = [left_out_errors(samples, BASE, prior) for samples in (*dahl, karnopp)]
    if not all(map(len, errors)):
        return dahl[0], ()
    means = [float(np.exp(np.log(each).mean())) for each in errors]
    best = int(np.argmin(means[:-1]))
    better = len(errors[-1]) > 1 and is_better(errors[-1], errors[best])
    return karnopp if better else dahl[best], tuple(means)


def choose_terms(samples: Samples, prior: Prior) -> tuple[Term, ...]:
    """Select friction terms of a joint: BASE and at most one term of each further kind.

    Forward selection: of the terms that lower the cross-validated error significantly and keep
    friction dissipative, the one that lowers it most is added, until there is none.
    """
    moving = samples.where(samples.moving)
    inverse = prior.inverse_constant
    wide = replace(inverse, precision=inverse.precision / LOOSE**2)
    prior = replace(prior, inverse_constant=wide)
    chosen: tuple[Term, ...] = BASE
    errors = left_out_errors(moving, chosen, prior)
    while len(errors) > 1:
        # cross-validated errors with one more term
        kinds = {term.kind for term in chosen[len(BASE) :]}
        tried = {
            term: left_out_errors(moving, (*chosen, term), prior)
            for term in samples.terms[len(BASE) :]
            if term.kind not in kinds
        }
        # those that are significantly better, and the best of them
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
    """Return whether errors (U,) on left-out units are significantly smaller than a reference."""
    gain = np.log(reference / error)
    uncertainty = gain.std(ddof=1) / np.sqrt(len(gain))
    return bool(gain.mean() > max(GAIN, STANDARD_ERRORS * uncertainty))


def left_out_errors(samples: Samples, terms: Sequence[Term], prior: Prior) -> Array:
    """Return the cross-validated RMSE [A] of each unit with enough samples."""
    residual = left_out_residuals(samples, terms, prior)
    known = np.isfinite(residual)
    units = [residual[known & (samples.unit == one)] for one in np.unique(samples.unit)]
    return np.array([np.sqrt(np.mean(rows**2)) for rows in units if len(rows) >= FEWEST])


def left_out_residuals(samples: Samples, terms: Sequence[Term], prior: Prior) -> Array:
    """Return measured minus predicted current (n,) [A], each path predicted from others.

    They are of other days, too, if these have enough paths.
    NaN if there is no other path.
    """
    residual = np.full(len(samples.current), np.nan)
    present = np.unique(samples.path)
    for one in present if len(present) > 1 else []:
        test = samples.path == one
        others = samples.where(apart_from(test, samples.path, samples.day))
        here = samples.where(test)
        coefficients = regress_samples(others, terms, prior).coefficients
        held = held_current(others, terms, coefficients)
        residual[test] = here.current - here.design(terms) @ coefficients - held * here.held
    return residual


def regress_samples(samples: Samples, terms: Sequence[Term], prior: Prior) -> Regression:
    """Fit torque, offset and these terms to the samples in motion."""
    moving = samples.where(samples.moving)
    known = prior.over([terms]), float(prior.noise()[0])
    return regress(moving.design(terms), moving.current, moving.block, *known)


def held_current(samples: Samples, terms: Sequence[Term], coefficients: Array) -> float:
    """Return the current [A] of friction at rest beyond that in motion, may be negative.

    Huber's estimate of s in residual = s held, over the samples at rest. Friction differs from stop
    to stop, and one hardly shows s: HELD of Coulomb friction counts as one more, of mean length.
    """
    rest, stop = samples.where(~samples.moving), samples.stop[~samples.moving]
    residual = rest.current - rest.design(terms) @ coefficients
    known = len(stop) / max(1, len(np.unique(stop)))
    usual = slope = HELD * max(0.0, float(coefficients[2]))
    for _ in range(ROUNDS if rest.held.any() else 0):
        # s = (Σ w h r + n s₀) / (Σ w h² + n)
        weight = huber_weight(residual - slope * rest.held) * rest.held
        slope = float((weight @ residual + known * usual) / (weight @ rest.held + known))
    return slope


def _brakes(samples: Samples, terms: tuple[Term, ...], prior: Prior) -> bool:
    """Return whether the fitted friction is dissipative over the samples' speeds and loads."""
    coefficients = regress_samples(samples, terms, prior).coefficients
    torque, speed = (np.abs(samples.columns[:, column]) for column in (0, 3))
    speeds = np.linspace(-1, 1, 42) * speed.max()
    loads = np.linspace(torque.min(), torque.max(), 5)
    return is_dissipative(terms, coefficients[2:], speeds, loads)
