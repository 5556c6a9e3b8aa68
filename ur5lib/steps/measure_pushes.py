"""The smallest push that F̂ᵐᵃᵖ detects on an arm, by trial pushes on contact-free recordings."""

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ur5lib.force.contact_place import jacobian_at
from ur5lib.force.contact_prior import GATE_SIZES, ContactPrior
from ur5lib.force.estimators import LEADING
from ur5lib.force.external_torque import is_still
from ur5lib.force.gate import TorqueVariances
from ur5lib.force.problem import Problem, fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.force.thresholds import alarms
from ur5lib.force.trial_contacts import (
    PUSH_DURATION,
    TRIAL_SIZES,
    Trials,
    Untouched,
    felt_push,
    flange_speed,
    smallest_force,
    try_each_place,
)
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.pushes import SPEEDS, Basis, Reason, SmallestPush
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

FLANGE_SPEEDS = (*SPEEDS, np.inf)  # m/s
TRIAL_ROUNDS = 2  # of trial pushes
MIN_TRIALS = 900  # of an arm: a hundred for each axis and range of speeds
FELT_SIZE = GATE_SIZES[-1] / TRIAL_SIZES[-1]  # of the largest trial: the gate expects no more
SETTLING_SPEED = 0.1  # m/s: an arm that settles is slow, and not at rest
MIN_TRIALS_OF_A_LIMIT = 10  # of which some are detected and some are not


def measure_pushes(
    motion: Mapping[str, Motion],
    currents: Mapping[str, Currents],
    kinematics: Mapping[str, Kinematics],
    forces: Mapping[str, Forces],
    predictions: Mapping[str, Prediction],
    premises: Mapping[str, Premises],
    friction: Friction,
    residuals: Residuals,
    threshold: dict[str, float],
    arm: Robot,
    contact_force_n: float | None,
) -> list[SmallestPush]:
    """Return the smallest pushes by motion and axis, none where no push can be tried.

    motion to premises: of contact-free recordings; contact_force_n: [N], of a typical contact,
    None: by the arm's payload.
    """
    trials, least = dict[str, Trials](), MIN_TRIALS // max(1, len(motion))
    for name, moved in motion.items():
        if LEADING not in threshold or predictions[name].is_loaded:
            continue
        problem = fmap_problem(moved, currents[name], residuals)
        odds = forces[name].log_odds.get(LEADING)
        if problem is not None and odds is not None:
            place = premises[name].place
            prior = ContactPrior.of(arm, contact_force_n, place)
            given = problem, kinematics[name], place, prior
            trials[name] = pushed(*given, threshold[LEADING], odds, least)
    tried = [name for name, own in trials.items() if len(own.force)]
    if not tried:
        return []
    basis: Basis = "fit" if all(predictions[name].fitted for name in tried) else "unseen"
    together = Trials.joined([trials[name] for name in tried])
    return [*smallest_pushes(together, basis, has_one_path=friction.paths == 1)]


def pushed(
    problem: Problem,
    kinematics: Kinematics,
    place: ContactPlace,
    prior: ContactPrior,
    threshold: float,
    odds: Array,
    least: int,
) -> Trials:
    """Return trial pushes on a contact-free recording, where contacts are assumed.

    odds: without any push (N,); least: number of pushes, if there is a time for any.
    """
    one, random = problem.input, np.random.default_rng(0)
    jacobian = jacobian_at(kinematics.jacobian, place.on(kinematics.rotation))
    speed = flange_speed(kinematics.jacobian, one.qd)
    speed = np.where(is_still(one.states), 0.0, np.maximum(speed, SETTLING_SPEED))
    hiding = TorqueVariances.of(one.states, problem.model, one.load_std()).hiding()
    time = np.arange(len(speed), dtype=np.float64) * one.period
    stiction, used = problem.model.stiction * problem.model.breakaway, jacobian[problem.rows]
    friction = np.random.default_rng(1)

    def log_odds_of(torque: Array) -> Array:
        felt = felt_push(torque, time, one.states, one.gears, stiction, friction)
        return problem.pushed(felt).contact_log_odds(used, prior)

    run = Untouched(jacobian, speed, one.period, alarms(odds, threshold), hiding)
    given = log_odds_of, run, threshold, random, prior.force
    first = try_each_place(*given)
    rounds = max(TRIAL_ROUNDS, -(-least // max(1, len(first.force))))
    more = [try_each_place(*given, later=number / rounds) for number in range(1, rounds)]
    return Trials.joined([first, *more])


def smallest_pushes(
    trials: Trials, basis: Basis, has_one_path: bool = False
) -> Iterator[SmallestPush]:
    """Yield the smallest push by motion along x, y and z, where any was tried.

    basis: of the trials; has_one_path: whether the fit knows a single path, so that none was left
    out to show how far its predictions are off, and smaller pushes may stand out than with more.
    """
    most = float(trials.force.max())
    for (low, high), motion in zip(pairwise(FLANGE_SPEEDS), SPEEDS.values(), strict=True):
        for axis, name in enumerate("xyz"):
            own = trials.within(low, high).along(axis)
            if not len(own.force):
                continue
            limit = detectable(own, most)
            reason: Reason = "" if limit.value is not None else "undetermined"
            reason = "fitted" if basis == "fit" and not reason else reason
            if has_one_path:
                limit, reason = Limit(bound=limit.bound), "one_path"
            yield SmallestPush(
                motion=motion,
                axis=name,
                **limit._asdict(),
                largest_tried=most,
                seconds=PUSH_DURATION,
                trials=len(own.force),
                blind=int((~own.felt(FELT_SIZE * most)).sum()),
                basis=basis,
                reason=reason,
            )


class Limit(NamedTuple):
    """A push that is detected with 95 % [N], its standard error and 95 % interval; None where the
    trials do not determine it; bound: ">" of one beyond `value`, the largest trial.
    """

    value: float | None = None
    std_error: float | None = None
    low: float | None = None
    high: float | None = None
    bound: str = ""


def detectable(trials: Trials, most: float) -> Limit:
    """Return the push that a logistic curve of trials of one axis and motion shows to be detected,
    but for poses in which joints hardly feel any; most: the largest trial of all [N].

    Beyond this, the curve tells nothing: the push is the largest one. One whose 95 % interval
    reaches zero is not determined.
    """
    felt = trials.where(trials.felt(FELT_SIZE * most))
    if len(trials.found) < MIN_TRIALS_OF_A_LIMIT:
        return Limit()
    if len(felt.found) < MIN_TRIALS_OF_A_LIMIT:
        return Limit(value=most, bound=">")
    force, std = smallest_force(felt.force, felt.found, felt.unit)
    if force > most:
        return Limit(value=most, bound=">")
    low, high = force - NORMAL95 * std, force + NORMAL95 * std
    return Limit(force, std, low, high) if low > 0 else Limit()
