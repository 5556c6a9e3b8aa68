"""The smallest push that the live estimator finds on an arm, by trials as in `measure_pushes`."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from ur5lib.force.problem import Problem, fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.force.smallest_pushes import pushed, pushes_of_arm, where_pushed
from ur5lib.force.trial_contacts import Trials, Untouched
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.friction import Friction
from ur5lib.records.measured import Measured
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import Span
from ur5lib.topics.live.live import Live
from ur5lib.topics.live.live_file import LiveFit, few_rows, numbers
from ur5lib.topics.live.live_recording import alarms_of_each, follow
from ur5lib.topics.live.rows import LivePush


class Inputs(Opened):
    """What is read of a recording."""

    kinematics: Kinematics
    signals: Signals
    motion: Motion
    premises: Premises
    currents: Currents
    prediction: Prediction


@step("arm", "live_pushes.csv", recordings="drawn")
def measure_live_pushes(
    recordings: Mapping[str, Inputs],
    friction: Friction,
    residuals: Residuals,
    live: LiveFit,
    arm: Robot,
    gravities: dict[str, list[float] | None],
    contact_force_n: float | None,
    trial_pushes: int,
) -> list[LivePush]:
    """Return the smallest pushes that the live estimator finds, by motion and axis; empty if no
    push can be tried.

    recordings, gravities: of contact-free recordings; for each, the fit without its path is used;
    contact_force_n: of a typical contact [N], None: from the arm's payload; trial_pushes: least
    number on all recordings together.
    """
    trials, least = dict[str, Trials](), trial_pushes // max(1, len(recordings))
    for name, recording in recordings.items():
        run = Measured.of(recording.signals)
        problem = fmap_problem(recording.motion, recording.currents, residuals)
        if run is None or problem is None or recording.prediction.is_loaded or not live.known:
            continue
        payload, place = recording.premises.load.payload, recording.premises.place
        about = friction, name, payload, place, contact_force_n
        file = numbers(arm.mounted(gravities[name]), *about) | live.known
        jacobian, speed = where_pushed(problem, recording.kinematics, place)
        trials[name] = live_trials(file, run, problem, jacobian, speed, least)
    pushes = pushes_of_arm(trials, friction)
    return [LivePush(**vars(push)) for push in pushes]


def live_trials(
    file: dict[str, Any],
    run: Measured,
    problem: Problem,
    jacobian: Array,
    speed: Array,
    least: int,
) -> Trials:
    """Return trial pushes on the first minutes of a contact-free recording.

    A push changes only the currents, by felt torque / torque constant; encoders do not move.
    jacobian, speed: as `where_pushed` returns them; least: number of pushes to try at least, if the
    recording has time for any.
    """
    rows, estimator = few_rows(run.period), Live(file)
    some = run.at(rows)
    own = follow(file, some)
    of_states = own.state, estimator.joint
    variance = estimator.noise[of_states] ** 2 + estimator.hidden[of_states] ** 2
    hiding = np.where(own.known[:, None], variance, np.inf)

    def alarms(felt: Array) -> list[list[Span]]:
        return alarms_of_each(file, some, some.current - np.nan_to_num(felt) / estimator.constant)

    free = Untouched(jacobian[rows], speed[rows], some.period, own.alarms(), hiding)
    part = problem._replace(input=problem.input.thinned(rows.step, rows))
    return pushed(part, free, alarms, file["contacts"]["typical"], least)
