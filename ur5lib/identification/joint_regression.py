"""Regression of one joint's samples: in motion, at rest, and with each path left out."""

import numpy as np

from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import REWEIGHTING_ROUNDS, Regression, huber_weight, regress
from ur5lib.identification.samples import JointSamples, apart_from
from ur5lib.timeseries.arrays import Array

HELD_FRICTION_SHARE = -0.45  # `held_current` over Coulomb friction: median of four arms' 24 joints
MIN_SAMPLES = 20  # (2 s) of which an error is stated


def left_out_residuals(samples: JointSamples, prior: Prior) -> Array:
    """Return measured minus predicted current (n,) [A], each path predicted from others.

    They are of other days, too, if these have enough paths. A single path is predicted from itself.
    """
    residual = np.full(len(samples.current), np.nan)
    present = np.unique(samples.path)
    for left_out in present:
        test = samples.path == left_out
        training = samples.where(apart_from(test, samples.path, samples.day) | (len(present) == 1))
        tested = samples.where(test)
        coefficients = regress_samples(training, prior).coefficients
        held_friction = held_current(training, coefficients)
        residual[test] = (
            tested.current - tested.columns @ coefficients - held_friction * tested.held
        )
    return residual


def regress_samples(samples: JointSamples, prior: Prior) -> Regression:
    """Fit torque, offset and friction to the samples in motion."""
    moving = samples.where(samples.moving)
    prior_and_noise = prior.over(samples.terms), float(prior.noise()[0])
    return regress(moving.columns, moving.current, moving.block, *prior_and_noise)


def held_current(samples: JointSamples, coefficients: Array) -> float:
    """Return the current [A] of friction at rest beyond that in motion, may be negative.

    Huber's estimate of s in residual = s held, over the samples at rest. Friction differs from stop
    to stop, and one hardly shows s: HELD_FRICTION_SHARE of Coulomb friction counts as one more, of
    mean length.
    """
    resting, stop = samples.where(~samples.moving), samples.stop[~samples.moving]
    residual = resting.current - resting.columns @ coefficients
    stop_weight = len(stop) / max(1, len(np.unique(stop)))
    usual = slope = HELD_FRICTION_SHARE * max(0.0, float(coefficients[2]))
    for _ in range(REWEIGHTING_ROUNDS if resting.held.any() else 0):
        # s = (Σ w h r + n s₀) / (Σ w h² + n)
        weight = huber_weight(residual - slope * resting.held) * resting.held
        slope = float(
            (weight @ residual + stop_weight * usual) / (weight @ resting.held + stop_weight)
        )
    return slope
