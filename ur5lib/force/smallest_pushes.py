"""The smallest pushes that an estimate finds on an arm, by trials on contact-free recordings."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from ur5lib.force.contact_place import jacobian_at
from ur5lib.force.contact_prior import GATE_SIZES
from ur5lib.force.external_torque import is_still
from ur5lib.force.problem import Problem
from ur5lib.force.push_directions import Needed
from ur5lib.force.trial_contacts import (
    PUSH_DURATION,
    TRIAL_SIZES,
    Curve,
    Trials,
    Untouched,
    felt_push,
    flange_speed,
    pushes_at_each_place,
    smallest_force,
)
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.friction import Friction
from ur5lib.records.pushes import SPEEDS, Basis, PushesFound, Reason, SmallestPush
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import Span

FLANGE_SPEEDS = (*SPEEDS, np.inf)  # m/s
TRIAL_ROUNDS = 2  # trial pushes are made in this many rounds
FELT_SIZE = GATE_SIZES[-1] / TRIAL_SIZES[-1]  # the gate's largest contact over the largest trial
SETTLING_SPEED = 0.1  # m/s: an arm that settles is slow, and not at rest
MIN_TRIALS_OF_A_LIMIT = 10  # fewer trials determine no limit; some must be detected, some not
FORCES_OF_A_CURVE = 40  # points of a curve from the smallest to the largest trial


def where_pushed(
    problem: Problem, kinematics: Kinematics, place: ContactPlace
) -> tuple[Array, Array]:
    """Return the Jacobian (N, 6, n) of the place of contacts, and the flange's speed (N,) [m/s]:
    zero where the whole arm rests, and slow where it settles.
    """
    jacobian = jacobian_at(kinematics.jacobian, place.on(kinematics.rotation))
    speed = np.maximum(flange_speed(kinematics.jacobian, problem.input.qd), SETTLING_SPEED)
    return jacobian, np.where(is_still(problem.input.states), 0.0, speed)


def pushed(
    problem: Problem,
    run: Untouched,
    alarms_of_each: Callable[[Array], list[list[Span]]],
    typical_force: float,
    least: int,
) -> Trials:
    """Return the results of trial pushes on a contact-free recording.

    alarms_of_each: returns the alarms with each of some additional external torques (R, N, 6)
    [Nm], as motors feel them; typical_force: of contacts [N]; least: number of pushes to reach, if
    there is a time for any.
    """
    given = run, np.random.default_rng(0), typical_force
    first = pushes_at_each_place(*given)
    count = max(TRIAL_ROUNDS, -(-least // max(1, len(first.force))))
    later = [pushes_at_each_place(*given, later=number / count) for number in range(1, count)]
    rounds = [one for one in (first, *later) if one.places]
    if not rounds:
        return first.tried(run, [])
    alarms = alarms_of_each(_felt(problem, [one.torque for one in rounds]))
    return Trials.joined([one.tried(run, own) for one, own in zip(rounds, alarms, strict=True)])


def _felt(problem: Problem, torques: list[Array]) -> Array:
    one, friction = problem.input, np.random.default_rng(1)
    time = np.arange(len(one.states), dtype=np.float64) * one.period
    stiction = problem.model.stiction * problem.model.breakaway
    known = time, one.states, one.gears, stiction, friction
    return np.stack([felt_push(torque, *known) for torque in torques])


def pushes_of_arm(trials: Mapping[str, Trials], friction: Friction) -> list[SmallestPush]:
    """Return the smallest pushes that trials on an arm's recordings show to be found; empty without
    any trial.
    """
    tried = [name for name, own in trials.items() if len(own.force)]
    if not tried:
        return []
    basis: Basis = "fit" if {*tried} <= {*friction.from_} else "unseen"
    together = Trials.joined([trials[name] for name in tried])
    return [*smallest_pushes(together, basis, friction.paths)]


def by_motion(trials: Trials) -> Iterator[tuple[str, Trials]]:
    """Yield (motion, trials) for rest, slow and fast motion."""
    for (low, high), motion in zip(pairwise(FLANGE_SPEEDS), SPEEDS.values(), strict=True):
        yield motion, trials.within(low, high)


def smallest_pushes(trials: Trials, basis: Basis, paths: int) -> Iterator[SmallestPush]:
    """Yield the smallest push by motion along x, y and z, where any was tried.

    basis: of the trials; paths: number of fitted paths. Of a single one, no push is stated: without
    a path left out, errors of predictions are not shown, and pushes seem smaller. Without any,
    friction is that of other arms.
    """
    most = float(trials.force.max())
    for motion, moved in by_motion(trials):
        for axis, name in enumerate("xyz"):
            own = moved.along(axis)
            if not len(own.force):
                continue
            limit = detectable(own, most)
            reason: Reason = "" if limit.value is not None else "undetermined"
            reason = "fitted" if basis == "fit" and not reason else reason
            reason = "uncalibrated" if paths == 0 and not reason else reason
            if paths == 1:
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


def needed(felt: Trials) -> Iterator[tuple[str, Needed]]:
    """Yield, by motion, the push that is detected, in units of its place over all axes, where
    trials determine it.

    felt: trials, except at poses in which joints feel almost none.
    """
    for motion, own in by_motion(felt):
        in_units = replace(own, force=own.force / own.unit, unit=np.ones_like(own.unit))
        limit = detectable(in_units, np.inf)
        if limit.value is not None and limit.std_error is not None:
            yield motion, Needed(limit.value, limit.std_error)


def found_by_force(felt: Trials, motions: set[str], most: float) -> Iterator[PushesFound]:
    """Yield the share of pushes found in some motions, by force up to the largest trial [N].

    felt: trials, except at poses in which joints feel almost none.
    """
    for motion, own in by_motion(felt):
        if motion in motions:
            force = np.geomspace(felt.force.min(), most, FORCES_OF_A_CURVE)
            shares = Curve.of(own.force, own.found, own.unit).share(force, own.unit)
            for size, share in zip(force.tolist(), shares.tolist(), strict=True):
                yield PushesFound(motion=motion, force=size, share=share)


class Limit(NamedTuple):
    """The push [N] that is detected with a probability of 95 %, its standard error and 95 %
    interval.

    None where the trials do not determine them; bound: ">" if the push exceeds the largest trial,
    which is then `value`.
    """

    value: float | None = None
    std_error: float | None = None
    low: float | None = None
    high: float | None = None
    bound: str = ""


def detectable(trials: Trials, most: float) -> Limit:
    """Return the push that is detected, by a logistic curve of trials along one axis in one motion.

    Poses in which joints feel almost none are left out. most: the largest trial of all [N], beyond
    which the curve shows nothing. None is returned as value if there are too few trials, or its 95
    % interval reaches zero.
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
