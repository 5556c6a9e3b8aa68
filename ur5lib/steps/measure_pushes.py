"""The smallest push that F̂ᵐᵃᵖ detects on an arm, by trial pushes on contact-free recordings."""

from collections.abc import Mapping
from typing import NamedTuple

from ur5lib.errors import InputError
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.estimators import LEADING
from ur5lib.force.gate import TorqueVariances
from ur5lib.force.problem import Problem, fmap_problem
from ur5lib.force.push_directions import Place, at_rest, places_of, push_directions
from ur5lib.force.residual_model import Residuals
from ur5lib.force.smallest_pushes import (
    FELT_SIZE,
    found_by_force,
    needed,
    pushed,
    pushes_of_arm,
    where_pushed,
)
from ur5lib.force.thresholds import alarms
from ur5lib.force.trial_contacts import Trials, Untouched
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.pushes import PushDirection, PushesFound, SmallestPush
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import Span


class DetectedPushes(NamedTuple):
    """The pushes that are detected on an arm: along axes, by direction, and by their force."""

    pushes: list[SmallestPush]
    directions: list[PushDirection]
    curve: list[PushesFound]


class Inputs(Opened):
    """What is read of a recording."""

    kinematics: Kinematics
    motion: Motion
    premises: Premises
    currents: Currents
    prediction: Prediction
    forces: Forces


@step(
    "arm",
    "pushes.csv directions=push_directions.csv curve=push_curve.csv",
    recordings="drawn",
    arm="described",
)
def measure_pushes(
    recordings: Mapping[str, Inputs],
    friction: Friction,
    residuals: Residuals,
    threshold: dict[str, float],
    arm: Robot,
    contact_force_n: float | None,
    trial_pushes: int,
    pushed_posture: list[float] | None = None,
) -> DetectedPushes:
    """Return the pushes that are detected; empty where no push can be tried.

    For an arm fitted to a single path, pushes by direction and by force are left out. recordings:
    without contact; contact_force_n: [N], of a typical contact, None: by the arm's payload;
    trial_pushes: least number on all recordings together; pushed_posture: joints [°], for which
    the push at rest is wanted, too. Raises InputError if it has another number of joints.
    """
    trials, places = dict[str, Trials](), list[Place]()
    least = trial_pushes // max(1, len(recordings))
    for name, recording in recordings.items():
        if LEADING not in threshold or recording.prediction.is_loaded:
            continue
        moved, kinematics = recording.motion, recording.kinematics
        problem = fmap_problem(moved, recording.currents, residuals)
        odds = recording.forces.log_odds.get(LEADING)
        if problem is not None and odds is not None:
            place = recording.premises.place
            prior = ContactPrior.of(arm, contact_force_n, place)
            run = untouched(problem, kinematics, place, alarms(odds, threshold[LEADING]))
            trials[name] = trials_on(problem, run, prior, threshold[LEADING], least)
            places += places_of(name, run, moved, kinematics)
    rows = pushes_of_arm(trials, friction)
    if not rows or friction.paths == 1:
        return DetectedPushes(rows, [], [])
    together = Trials.joined([own for own in trials.values() if len(own.force)])
    most = float(together.force.max())
    felt = together.where(together.felt(FELT_SIZE * most))
    stated = dict(needed(felt))
    yours = None
    if pushed_posture is not None and residuals.tau_ext is not None:
        yours = at_rest(arm, _of_joints(pushed_posture, arm), residuals.tau_ext)
    directions = push_directions(places, stated, FELT_SIZE * most, most, yours)
    return DetectedPushes(rows, [*directions], [*found_by_force(felt, {*stated}, most)])


def _of_joints(posture: list[float], arm: Robot) -> list[float]:
    if len(posture) != len(arm.joints):
        raise InputError(
            f"settings.pushes.posture_deg has {len(posture)} angles; {arm.name} has "
            f"{len(arm.joints)} joints"
        )
    return posture


def untouched(
    problem: Problem, kinematics: Kinematics, place: ContactPlace, raised: list[Span]
) -> Untouched:
    """Return a contact-free recording in the form that trials need, with pushes at the place of
    contacts; raised: its alarms.
    """
    one = problem.input
    jacobian, speed = where_pushed(problem, kinematics, place)
    hiding = TorqueVariances.of(one.states, problem.model, one.load_std()).hiding()
    return Untouched(jacobian, speed, one.period, raised, hiding)


def trials_on(
    problem: Problem, run: Untouched, prior: ContactPrior, threshold: float, least: int
) -> Trials:
    """Return trial pushes on a contact-free recording.

    threshold: of the alarms; least: number of pushes to try at least, if the recording has time for
    any.
    """
    used = run.jacobian[problem.rows]

    def alarms_of_each(felt: Array) -> list[list[Span]]:
        odds = problem.contact_log_odds(felt, used, prior)
        return [alarms(own, threshold) for own in odds]

    return pushed(problem, run, alarms_of_each, prior.force, least)
