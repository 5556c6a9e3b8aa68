"""The errors of an arm that do not repeat between runs of one path."""

from collections.abc import Mapping

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.contact_wrench import regularised_wrench
from ur5lib.force.external_torque import finite_rows
from ur5lib.force.gate import diagonal
from ur5lib.force.problem import fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.identification.currents import torque_constants
from ur5lib.identification.repetition import path_run, repetition
from ur5lib.recordings.copies import same_runs
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.friction import CurrentFit, Friction
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.prediction import Prediction
from ur5lib.records.quality import Quality
from ur5lib.records.repetition import Repeated
from ur5lib.records.signals import Signals, slowly
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array


class Inputs(Opened):
    """What is read of a recording."""

    quality: Quality
    kinematics: Kinematics
    signals: Signals
    motion: Motion
    torques: Torques
    currents: Currents
    prediction: Prediction


@step("arm", "repetition.csv", recordings="drawn")
def measure_repetition(
    recordings: Mapping[str, Inputs],
    friction: Friction,
    residuals: Residuals,
    arm: Robot,
    contact_force_n: float | None,
) -> list[Repeated]:
    """Return the errors of an arm that do not repeat; empty where no path was repeated.

    recordings: without contact, of which copies do not count; contact_force_n: [N], of a typical
    contact, None: by the arm's payload.
    """
    prior, runs = ContactPrior.of(arm, contact_force_n, ContactPlace()), []
    prints = {name: recording.quality.fingerprint for name, recording in recordings.items()}
    copies = {other for _, other in same_runs(prints)}
    for name, recording in recordings.items():
        if not recording.prediction.is_loaded and name not in copies:
            errors = {
                "torque": torque_error(recording, arm.fullest_model()),
                "current": current_error(recording.currents, friction.fit_for(name)),
                "force": force_error(recording, residuals, prior),
            }
            runs.append(path_run(recording.motion, errors))
    return [*repetition(runs)]


def torque_error(recording: Inputs, model: str) -> Array | None:
    """Return a link model's torque minus the controller's (N, n) [Nm], below 2 Hz, if recorded."""
    # read again, so that they are not in memory while forces are computed
    signals, torques = recording.signals.anew(), recording.torques.anew()
    if signals.target_moment is None:
        return None
    known = torques.target if model in torques.target else torques.measured
    return slowly(known[model] - signals.target_moment, signals)


def current_error(currents: Currents, fit: CurrentFit) -> Array | None:
    """Return the predicted minus the measured current (N, n) [A], None if not predicted."""
    torque = currents.external_torque
    return None if torque is None else torque / torque_constants(fit)


def force_error(recording: Inputs, residuals: Residuals, prior: ContactPrior) -> Array | None:
    """Return the force (N, 3) [N] that a contact would need to cause the error of the currents;
    None without F̂ᵐᵃᵖ.
    """
    problem = fmap_problem(recording.motion, recording.currents, residuals)
    if problem is None:
        return None
    one, model = problem
    noise = diagonal(model.variance(model.spread, one.states))  # S
    jacobian = recording.kinematics.jacobian
    wrench = regularised_wrench(one.torque, jacobian, noise, prior.unknown()).mean
    return np.where(finite_rows(one.torque)[:, None], wrench[:, :3], np.nan)
