"""Regression of one joint's samples: in motion, at rest, and with each path left out."""

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import (
    REWEIGHTING_ROUNDS,
    Normal,
    Regression,
    huber_weight,
    posterior_mean,
    regress,
)
from ur5lib.identification.samples import JointSamples, apart_from
from ur5lib.timeseries.arrays import Array, Mask

HELD_FRICTION_SHARE = -0.45  # `held_current` over Coulomb friction: median of four arms' 24 joints
MAX_FOLDS = 10  # cross-fitting has at most this many folds
MIN_SAMPLES = 20  # an error is stated from this many samples (2 s) on


def left_out_residuals(samples: JointSamples, prior: Prior) -> Array:
    """Return measured minus predicted current (n,) [A], where each path is predicted by fits to
    other paths.

    These are of other days, too, if those have enough paths. A single path is predicted from
    itself.
    """
    return unseen_residuals(samples, [*fits_to_others(samples, prior)])


class LeftOutFit(NamedTuple):
    """A fit to some samples. test, fitted: which samples (n,) are left out, and which are fitted;
    coefficients: (P,) in motion.
    """

    test: Mask
    fitted: Mask
    coefficients: Array


def fits_to_others(samples: JointSamples, prior: Prior) -> Iterator[LeftOutFit]:
    """Yield at most MAX_FOLDS fits; each leaves some paths out, and fits samples of other paths and
    days.
    """
    fold = np.unique(samples.path, return_inverse=True)[1] % MAX_FOLDS
    for left_out in np.unique(fold):
        test = fold == left_out
        fitted = apart_from(test, samples.path, samples.day) | bool(test.all())
        coefficients = regress_samples(samples, prior, fitted).coefficients
        yield LeftOutFit(test, fitted, coefficients)


def unseen_residuals(samples: JointSamples, fits: Sequence[LeftOutFit]) -> Array:
    """Return measured minus predicted current (n,) [A], where each sample is predicted by the fit
    that leaves it out.
    """
    residual = np.full(len(samples.current), np.nan)
    for test, fitted, coefficients in fits:
        by_motion = samples.columns[test] @ coefficients
        held = samples.held[test] @ held_current(samples, coefficients, fitted)
        residual[test] = samples.current[test] - by_motion - held
    return residual


def regress_samples(samples: JointSamples, prior: Prior, fitted: Mask | bool = True) -> Regression:
    """Return the regression of torque, offset and friction on the samples in motion; fitted: which
    samples (n,) are used, True for all.
    """
    rows = np.flatnonzero(samples.moving & fitted)
    columns, current = (own.take(rows, axis=0) for own in (samples.columns, samples.current))
    prior_and_noise = prior.over(samples.terms), float(prior.noise()[0])
    return regress(columns, current, samples.block[rows], *prior_and_noise)


def held_current(
    samples: JointSamples, coefficients: Array, fitted: Mask | slice = slice(None)
) -> Array:
    """Return the currents s (1 + D,) [A] by which friction at rest differs from that in motion.

    Huber's estimate of s in residual = H s over the samples at rest, of any sign. Friction differs
    from stop to stop, and one stop shows little of s. A prior therefore counts as one more stop of
    mean length: HELD_FRICTION_SHARE of Coulomb friction, and zero over other distances. fitted:
    which samples (n,) are used, by default all.
    """
    rows = np.arange(len(samples.current))[fitted]
    moving, record = samples.moving[rows], samples.record[rows]
    # label of each stop; a motion of the joint or the start of a recording begins another
    stop = np.cumsum(moving | (np.diff(record, prepend=0) != 0))[~moving]
    resting = rows[~moving]
    held = samples.held[resting]
    residual = samples.current[resting] - samples.columns[resting] @ coefficients
    stop_weight = len(stop) / (1 + np.count_nonzero(np.diff(stop)))
    usual = np.zeros(held.shape[1])
    usual[0] = HELD_FRICTION_SHARE * max(0.0, float(coefficients[2]))
    known, slopes = Normal(usual, stop_weight * np.eye(len(usual))), usual
    for _ in range(REWEIGHTING_ROUNDS if held.any() else 0):
        # (Hᵀ W H + n) s = Hᵀ W r + n s₀
        weighted = held.T * huber_weight(residual - held @ slopes)
        slopes = posterior_mean(weighted @ held, weighted @ residual, known)
    return slopes
