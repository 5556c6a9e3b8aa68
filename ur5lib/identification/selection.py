"""Selection of an arm's further friction terms, by errors of fits on paths or dates left out.

In motion, an arm may lack the root of the velocity, or have its square or Stribeck friction, too;
at rest, a part of a joint's friction may reverse over one other distance.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from typing import NamedTuple

import numpy as np

from ur5lib.identification.joint_regression import (
    LeftOutFit,
    fits_to_others,
    left_out_residuals,
    unseen_residuals,
)
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import MIN_PATHS, JointSamples
from ur5lib.robots.friction import INERTIA, REST_DISTANCES, SPEED_TERMS, STRIBECK
from ur5lib.timeseries.arrays import Array

# A change reduces the squared error on left-out parts by at least this share, in motion and at
# rest, and by this many standard errors.
MIN_SHARE, MIN_SHARE_AT_REST, MIN_DEVIATIONS = 0.02, 0.1, 2.0
MIN_SHARE_OF_GAIN = 0.1  # the same for a gain that replaces the prior's
States = tuple[bool, ...]  # of a joint: whether it moves
MOVING, RESTING = (True,), (False,)


class Shown(NamedTuple):
    """The friction terms selected so far. prior: with these terms; fits: of each joint, without
    each part; left: the residuals (n,) [A] of each joint by these fits.
    """

    prior: Prior
    fits: list[list[LeftOutFit]]
    left: list[Array]


def with_shown_terms(samples: Sequence[JointSamples], prior: Prior) -> tuple[Prior, list[Array]]:
    """Return the prior with the terms and the distance that reduce errors on left-out samples, and
    each joint's residuals (n,) [A] then.

    samples: of the joints, with all columns. With fewer paths than MIN_PATHS, parts of recordings
    are left out. They show no Stribeck friction: it would be wrong at other speeds.
    """
    parts = [*map(in_units, samples)]
    fits = fits_of(parts, prior)
    shown = Shown(prior, fits, residuals(parts, prior, fits))
    for term in (one for one in SPEED_TERMS if one in prior.tried):
        shown = _changed_by(term, parts, shown)
    shown = _over_distance(parts, shown)
    if STRIBECK in prior.tried and all(len(np.unique(own.path)) >= MIN_PATHS for own in samples):
        shown = _changed_by(STRIBECK, parts, shown)
    return shown.prior, shown.left


def _changed_by(term: str, samples: Sequence[JointSamples], shown: Shown) -> Shown:
    """Return the selection with one term added, or removed if it has it, if that reduces the
    errors; else unchanged.

    Stribeck friction, which is largest at rest, has to reduce errors of motion and rest together.
    """
    others = tuple(own for own in shown.prior.terms if own != term)
    has = term in shown.prior.terms
    prior = replace(shown.prior, terms=others if has else (*others, term))
    fits = fits_of(samples, prior)
    left = residuals(samples, prior, fits)
    states = MOVING + RESTING if term == STRIBECK else MOVING
    return Shown(prior, fits, left) if shows(samples, shown.left, left, states) else shown


def _over_distance(samples: Sequence[JointSamples], shown: Shown) -> Shown:
    """Return the selection with the best of REST_DISTANCES, if that reduces the error at rest; else
    unchanged.
    """
    prior, fits, known = shown
    trials = {
        distance: residuals(samples, replace(prior, distances=(distance,)), fits)
        for distance in REST_DISTANCES
    }
    best = min(trials, key=lambda own: float(np.sum(errors(samples, known, trials[own], RESTING))))
    if not shows(samples, known, trials[best], RESTING):
        return shown
    return Shown(replace(prior, distances=(best,)), fits, trials[best])


def in_units(samples: JointSamples) -> JointSamples:
    """Return samples in which units count as paths, and are left out instead of these, if paths are
    few.
    """
    if len(np.unique(samples.path)) >= MIN_PATHS:
        return samples
    return replace(samples, path=samples.unit, day=0 * samples.day)


def fits_of(samples: Sequence[JointSamples], prior: Prior) -> list[list[LeftOutFit]]:
    """Return the fits of each joint, each without some of its samples."""
    return [
        [*fits_to_others(own.of(prior.terms, ()), prior.of_joint(joint))]
        for joint, own in enumerate(samples)
    ]


def residuals(
    samples: Sequence[JointSamples], prior: Prior, fits: Sequence[Sequence[LeftOutFit]]
) -> list[Array]:
    """Return the residuals (n,) [A] of each joint's samples by the fits that leave them out."""
    chosen = [own.of(prior.terms, prior.distances) for own in samples]
    return [*map(unseen_residuals, chosen, fits)]


def errors(
    samples: Sequence[JointSamples], known: Sequence[Array], left: Sequence[Array], states: States
) -> Array:
    """Return the squared errors of each path (G,), Σ r² / mean(r₀²), summed over joints and states.

    left, known: residuals r (n,) [A] of each joint, and r₀, those before the change.
    """
    count = 1 + max(int(own.path.max(initial=0)) for own in samples)
    total = np.zeros(count)
    each = zip(samples, known, left, strict=True)
    for (own, usual, residual), moving in product(each, states):
        rows = own.moving == moving
        size = max(float(np.sum(usual[rows] ** 2)), np.finfo(float).tiny) / max(1, int(rows.sum()))
        total += np.bincount(own.path[rows], residual[rows] ** 2 / size, count)
    return total


def shows(
    samples: Sequence[JointSamples], known: Sequence[Array], trial: Sequence[Array], states: States
) -> bool:
    """Return whether the squared errors of `trial` residuals are surely less than those of `known`
    ones, in the states.
    """
    before, after = (errors(samples, known, left, states) for left in (known, trial))
    met = before > 0
    share = MIN_SHARE_AT_REST if states == RESTING else MIN_SHARE
    return is_less(after[met], before[met], share, MIN_DEVIATIONS)


def shows_gain(samples: JointSamples, prior: Prior, joint: int) -> bool:
    """Return whether a fitted gain predicts left-out parts of a joint, from 0, surely better than
    the prior's gain.

    The gain is fitted to the other parts, with the prior; inertia alone shows none.
    """
    wider = replace(prior, terms=(*prior.terms, INERTIA))
    own = in_units(samples.of(wider.terms, wider.distances))
    pinned = wider.with_pinned(np.arange(len(wider.torque_max)) == joint)
    left = (left_out_residuals(own, one.of_joint(joint)) for one in (wider, pinned))
    parts = np.unique(own.path[own.moving])
    trial, known = (
        np.array([np.sum(one[own.moving & (own.path == part)] ** 2) for part in parts])
        for one in left
    )
    return is_less(trial, known, MIN_SHARE_OF_GAIN, MIN_DEVIATIONS)


def is_less(trial: Array, errors: Array, share: float, deviations: float) -> bool:
    """Return whether squared errors on left-out parts (G,) fall from `errors` to `trial`, by at
    least a share, and surely.

    A paired test: the mean of log(errors / trial) exceeds `share` and `deviations` standard errors.
    """
    if len(errors) < MIN_PATHS:
        return False
    gain = np.log(errors / trial)
    error = gain.std(ddof=1) / np.sqrt(len(gain))
    return bool(gain.mean() > max(share, deviations * error))
