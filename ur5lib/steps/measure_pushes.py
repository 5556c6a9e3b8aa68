"""The smallest push that F̂ᵐᵃᵖ detects on an arm, by trial pushes on contact-free recordings."""

from collections.abc import Mapping

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.estimators import LEADING
from ur5lib.force.gate import TorqueVariances
from ur5lib.force.problem import Problem, fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.force.smallest_pushes import MIN_TRIALS, pushed, pushes_of_arm, where_pushed
from ur5lib.force.thresholds import alarms
from ur5lib.force.trial_contacts import Trials, Untouched
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.pushes import SmallestPush
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import Span


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
            trials[name] = trials_on(*given, threshold[LEADING], odds, least)
    return pushes_of_arm(trials, predictions, friction.paths)


def trials_on(
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
    one = problem.input
    jacobian, speed = where_pushed(problem, kinematics, place)
    hiding = TorqueVariances.of(one.states, problem.model, one.load_std()).hiding()
    used = jacobian[problem.rows]

    def alarms_of(felt: Array) -> list[Span]:
        return alarms(problem.pushed(felt).contact_log_odds(used, prior), threshold)

    run = Untouched(jacobian, speed, one.period, alarms(odds, threshold), hiding)
    return pushed(problem, run, alarms_of, prior.force, least)
