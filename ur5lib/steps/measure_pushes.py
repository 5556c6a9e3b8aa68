"""The smallest push that F̂ᵐᵃᵖ detects on an arm, by trial pushes on contact-free recordings."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ur5lib.force.contact_place import jacobian_at
from ur5lib.force.contact_prior import GATE_SIZES, ContactPrior
from ur5lib.force.estimators import LEADING
from ur5lib.force.external_torque import is_still
from ur5lib.force.gate import TorqueVariances
from ur5lib.force.problem import Problem, fmap_problem
from ur5lib.force.push_directions import Needed, Place, places_of, push_directions
from ur5lib.force.residual_model import Residuals
from ur5lib.force.thresholds import alarms
from ur5lib.force.trial_contacts import (
    PUSH_DURATION,
    TRIAL_SIZES,
    Curve,
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
from ur5lib.records.pushes import (
    SPEEDS,
    Basis,
    PushDirection,
    PushesFound,
    Reason,
    SmallestPush,
)
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import Span

FLANGE_SPEEDS = (*SPEEDS, np.inf)  # m/s
TRIAL_ROUNDS = 2  # of trial pushes
MIN_TRIALS = 900  # of an arm: a hundred for each axis and range of speeds
FELT_SIZE = GATE_SIZES[-1] / TRIAL_SIZES[-1]  # of the largest trial: the gate expects no more
SETTLING_SPEED = 0.1  # m/s: an arm that settles is slow, and not at rest
MIN_TRIALS_OF_A_LIMIT = 10  # of which some are detected and some are not
FORCES_OF_A_CURVE = 40  # from the smallest to the largest trial


class DetectedPushes(NamedTuple):
    """Which pushes are detected on an arm: along axes, by direction, and by their force."""

    pushes: list[SmallestPush]
    directions: list[PushDirection]
    curve: list[PushesFound]


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
) -> DetectedPushes:
    """Return which pushes are detected, nothing where no push can be tried.

    By direction and force, nothing of an arm fitted to a single path.

    motion to premises: of contact-free recordings; contact_force_n: [N], of a typical contact,
    None: by the arm's payload.
    """
    trials, places = dict[str, Trials](), list[Place]()
    least = MIN_TRIALS // max(1, len(motion))
    for name, moved in motion.items():
        if LEADING not in threshold or predictions[name].is_loaded:
            continue
        problem = fmap_problem(moved, currents[name], residuals)
        odds = forces[name].log_odds.get(LEADING)
        if problem is not None and odds is not None:
            place = premises[name].place
            prior = ContactPrior.of(arm, contact_force_n, place)
            run = untouched(problem, kinematics[name], place, alarms(odds, threshold[LEADING]))
            trials[name] = pushed(run, problem, prior, threshold[LEADING], least)
            places += places_of(name, run, moved, kinematics[name])
    tried = [name for name, own in trials.items() if len(own.force)]
    if not tried:
        return DetectedPushes([], [], [])
    basis: Basis = "fit" if all(predictions[name].fitted for name in tried) else "unseen"
    together = Trials.joined([trials[name] for name in tried])
    rows = [*smallest_pushes(together, basis, has_one_path=friction.paths == 1)]
    if friction.paths == 1:
        return DetectedPushes(rows, [], [])
    most = float(together.force.max())
    felt = together.where(together.felt(FELT_SIZE * most))
    stated = dict(needed(felt))
    directions = push_directions(places, stated, FELT_SIZE * most, most)
    return DetectedPushes(rows, [*directions], [*found_by_force(felt, {*stated}, most)])


def untouched(
    problem: Problem, kinematics: Kinematics, place: ContactPlace, raised: list[Span]
) -> Untouched:
    """Return a contact-free recording, pushed where contacts are assumed; raised: its alarms."""
    one = problem.input
    jacobian = jacobian_at(kinematics.jacobian, place.on(kinematics.rotation))
    speed = flange_speed(kinematics.jacobian, one.qd)
    speed = np.where(is_still(one.states), 0.0, np.maximum(speed, SETTLING_SPEED))
    hiding = TorqueVariances.of(one.states, problem.model, one.load_std()).hiding()
    return Untouched(jacobian, speed, one.period, raised, hiding)


def pushed(
    run: Untouched, problem: Problem, prior: ContactPrior, threshold: float, least: int
) -> Trials:
    """Return trial pushes on a contact-free recording; least: their number, if there is a time for
    any.
    """
    one, random = problem.input, np.random.default_rng(0)
    time = np.arange(len(run.speed), dtype=np.float64) * one.period
    stiction, used = problem.model.stiction * problem.model.breakaway, run.jacobian[problem.rows]
    friction = np.random.default_rng(1)

    def log_odds_of(torque: Array) -> Array:
        felt = felt_push(torque, time, one.states, one.gears, stiction, friction)
        return problem.pushed(felt).contact_log_odds(used, prior)

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
    for motion, moving in by_motion(trials):
        for axis, name in enumerate("xyz"):
            own = moving.along(axis)
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


def by_motion(trials: Trials) -> Iterator[tuple[str, Trials]]:
    """Yield the trials of each motion."""
    for (low, high), motion in zip(pairwise(FLANGE_SPEEDS), SPEEDS.values(), strict=True):
        yield motion, trials.within(low, high)


def needed(felt: Trials) -> Iterator[tuple[str, Needed]]:
    """Yield the push that is detected in units of its place, the axes together, by each motion in
    which trials determine it; felt: trials, but for poses in which joints hardly feel any.
    """
    for motion, own in by_motion(felt):
        in_units = replace(own, force=own.force / own.unit, unit=np.ones_like(own.unit))
        limit = detectable(in_units, np.inf)
        if limit.value is not None and limit.std_error is not None:
            yield motion, Needed(limit.value, limit.std_error)


def found_by_force(felt: Trials, motions: set[str], most: float) -> Iterator[PushesFound]:
    """Yield which share of pushes up to the largest trial [N] is found in some motions.

    felt: trials, but for poses in which joints hardly feel any.
    """
    for motion, own in by_motion(felt):
        if motion in motions:
            force = np.geomspace(felt.force.min(), most, FORCES_OF_A_CURVE)
            shares = Curve.of(own.force, own.found, own.unit).share(force, own.unit)
            for size, share in zip(force.tolist(), shares.tolist(), strict=True):
                yield PushesFound(motion=motion, force=size, share=share)


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
