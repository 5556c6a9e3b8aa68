"""What an arm's contact-free recordings let one observe.

The smallest push that F̂ᵐᵃᵖ detects along each axis, by the flange's speed; and the share of each
joint's efforts within their stated band, by its velocity.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.estimators import LEADING
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.problem import Problem, fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.force.thresholds import alarms
from ur5lib.force.trial_contacts import (
    MIN_LARGEST_PUSH,
    Trials,
    Untouched,
    felt_push,
    flange_speed,
    smallest_force,
    try_each_place,
)
from ur5lib.identification.currents import torque_constants
from ur5lib.identification.samples import INDEPENDENT_STEP
from ur5lib.identification.validation import (
    MIN_SAMPLES,
    SPEED_BINS,
    ShareBySpeed,
    share_by_speed,
)
from ur5lib.records.contacts import SPEEDS
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces
from ur5lib.records.friction import CurrentFit, Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import STANDARD_GRAVITY
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import BAND_COVERAGE
from ur5lib.topics.observability.rows import LARGEST_PUSH, Observed

FLANGE_SPEEDS = (*SPEEDS, np.inf)  # m/s
TRIAL_ROUNDS = 2  # of trial pushes
MIN_TRIALS = 270  # of an arm: thirty for each axis and range of speeds
MIN_TRIALS_OF_A_LIMIT = 10  # of which some are detected and some are not


def measure_observability(
    motion: Mapping[str, Motion],
    currents: Mapping[str, Currents],
    kinematics: Mapping[str, Kinematics],
    forces: Mapping[str, Forces],
    predictions: Mapping[str, Prediction],
    friction: Friction,
    residuals: Residuals,
    threshold: dict[str, float],
    arm: Robot,
    contact_force_n: float,
) -> list[Observed]:
    """Return what contact-free recordings of an arm let one observe; contact_force_n: [N], of a
    typical contact. Trial pushes end at the weight of the arm's rated payload, or at 100 N.
    """
    prior, trials, errors = ContactPrior(force=contact_force_n), list[Trials](), list[Judged]()
    least = MIN_TRIALS // max(1, len(motion))
    most = max(MIN_LARGEST_PUSH, STANDARD_GRAVITY * (arm.rated_payload or 0.0))
    for name, moved in motion.items():
        predicted = currents[name]
        if predicted.external_torque is None or predictions[name].is_loaded:
            continue
        errors.append(judged(moved, predicted, friction.fit_for(name)))
        problem = fmap_problem(moved, predicted, residuals)
        odds = forces[name].log_odds.get(LEADING)
        if LEADING in threshold and problem is not None and odds is not None:
            jacobian, alarm_odds = kinematics[name].jacobian, threshold[LEADING]
            trials.append(pushed(problem, jacobian, prior, alarm_odds, odds, least, most))
    return [*observability(trials, errors), *at_rest(friction.fit)]


class Judged(NamedTuple):
    """Speeds of joints (n, 6) [rad/s], errors as shares of the 95 % band stated there (n, 6)."""

    speed: Array
    of_band: Array


def pushed(
    problem: Problem,
    jacobian: Array,
    prior: ContactPrior,
    threshold: float,
    odds: Array,
    least: int,
    most: float,
) -> Trials:
    """Return trial pushes of up to `most` [N] on a contact-free recording.

    odds: without any (N,); least: number of pushes, if there is a place for any.
    """
    one, random = problem.input, np.random.default_rng(0)
    speed = flange_speed(jacobian, one.qd)
    time = np.arange(len(speed), dtype=np.float64) * one.period
    stiction, used = prior.stiction * problem.model.breakaway, jacobian[problem.rows]
    friction = np.random.default_rng(1)

    def log_odds_of(torque: Array) -> Array:
        felt = felt_push(torque, time, one.states, one.gears, stiction, friction)
        return problem.pushed(felt).contact_log_odds(used, prior)

    run = Untouched(jacobian, speed, one.period, alarms(odds, threshold))
    first = try_each_place(log_odds_of, run, threshold, random, most)
    rounds = max(TRIAL_ROUNDS, -(-least // max(1, len(first.force))))
    more = [try_each_place(log_odds_of, run, threshold, random, most) for _ in range(rounds - 1)]
    return Trials.joined([first, *more])


def judged(motion: Motion, currents: Currents, fit: CurrentFit) -> Judged:
    """Return the errors of a contact-free recording's current as shares of the band stated there.

    fit: has not seen the recording's path. The external torque is k times the error of the current.
    """
    every = max(1, round(INDEPENDENT_STEP / motion.period))
    torque, stated = currents.external_torque, currents.band
    assert torque is not None
    assert stated is not None
    torque, qd, stated = torque[::every], motion.motor_qd[::every], stated[::every]
    known = finite_rows(torque) & finite_rows(qd)
    of_band = np.abs(torque[known] / torque_constants(fit)) / stated[known]
    return Judged(np.abs(qd[known]), of_band)


def observability(trials: Sequence[Trials], errors: Sequence[Judged]) -> Iterator[Observed]:
    """Yield smallest pushes by speed, and by joint the shares by speed, where they suffice, and
    what the band at rest is worth.
    """
    if trials:
        together = Trials.joined([*trials])
        yield from by_axis(together)
    if errors:
        speed, of_band = (np.concatenate(part) for part in zip(*errors, strict=True))
        known = np.isfinite(of_band).T
        shares = [share_by_speed(speed[k, j], of_band[k, j] <= 1) for j, k in enumerate(known)]
        for joint, share in enumerate(shares, start=1):
            yield from _shares(joint, share)
        for joint, share in enumerate(shares, start=1):
            yield _predicted(joint, *share.suffices())
        for joint in range(speed.shape[1]):
            resting = speed[:, joint] < SPEED_BINS[1]
            yield from _factor_at_rest(joint + 1, of_band[resting, joint])


def at_rest(fit: CurrentFit) -> Iterator[Observed]:
    """Yield how many times as wide as in motion each joint's 95 % band is at rest."""
    for number, joint in enumerate(fit.joints, start=1):
        yield Observed(
            quantity="band_at_rest",
            joint=number,
            speed_low=0.0,
            speed_high=0.0,
            speed_unit="rad/s",
            value=joint.band_standing / joint.band_moving if joint.band_moving else np.nan,
            unit="1",
        )


def _shares(joint: int, shares: ShareBySpeed) -> Iterator[Observed]:
    for low, high, share, samples in shares.rows():
        yield Observed(
            quantity="friction_in_band",
            joint=joint,
            speed_low=low,
            speed_high=high,
            speed_unit="rad/s",
            value=share,
            unit="1",
            samples=samples,
        )


def _factor_at_rest(joint: int, of_band: Array) -> Iterator[Observed]:
    """Yield within how much of their band 95 % of a resting joint's errors are, where they suffice;
    of_band: errors as shares of their band.
    """
    known = of_band[np.isfinite(of_band)]
    if known.size >= MIN_SAMPLES:
        yield Observed(
            quantity="rest_band_factor",
            joint=joint,
            speed_low=0.0,
            speed_high=SPEED_BINS[1],
            speed_unit="rad/s",
            value=float(np.quantile(known, BAND_COVERAGE)),
            unit="1",
            samples=known.size,
        )


def _predicted(joint: int, low: float, high: float) -> Observed:
    """Return the range of speeds in which the stated band of a joint holds."""
    return Observed(
        quantity="least_velocity",
        joint=joint,
        speed_low=low,
        speed_high=high,
        speed_unit="rad/s",
        value=low,
        unit="rad/s",
    )


def by_axis(trials: Trials) -> Iterator[Observed]:
    """Yield the smallest pushes along x, y and z by the flange's speed, where trials suffice, and
    the largest one that was tried.

    Beyond this, a logistic curve tells nothing: the push is the largest, and `bound` ">".
    """
    most = float(trials.force.max(initial=0.0))
    for low, high in pairwise(FLANGE_SPEEDS):
        for axis, name in enumerate("xyz"):
            own = trials.within(low, high).along(axis)
            if len(own.found) < MIN_TRIALS_OF_A_LIMIT:
                continue
            force, std = smallest_force(own.force, own.found)
            beyond = force > most
            yield Observed(
                quantity=f"smallest_push_95_{name}",
                speed_low=low,
                speed_high=high,
                speed_unit="m/s",
                bound=">" if beyond else "",
                value=most if beyond else force,
                std_error=np.nan if beyond else std,
                unit="N",
                samples=len(own.found),
            )
    yield Observed(
        quantity=LARGEST_PUSH,
        speed_low=0.0,
        speed_high=None,
        speed_unit="m/s",
        value=most,
        unit="N",
        samples=len(trials.found),
    )
