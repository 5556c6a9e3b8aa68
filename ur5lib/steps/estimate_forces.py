"""Contact wrench from the external torque, with its band and the log-odds of a contact."""

from dataclasses import replace

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.contact_wrench import MIN_CONSTANT_ERROR, at_rest, static_wrench, torque_std
from ur5lib.force.estimators import ESTIMATORS, Run, Stated
from ur5lib.force.problem import fmap_problem, is_fitted
from ur5lib.force.residual_model import Residuals
from ur5lib.force.wrench_estimate import WrenchEstimate
from ur5lib.identification.current_samples import (
    ZeroPhaseLowpass,
    controllers_ratio,
    current_record,
    prior_of,
)
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.premises import Premises
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.lowpass import Butterworth


class Inputs(AlignedRecording):
    """What is read of a recording."""

    kinematics: Kinematics
    currents: Currents
    premises: Premises


@step("recording", "forces.parquet", arm="described")
def estimate_forces(
    recording: Inputs,
    friction: Friction,
    residuals: Residuals,
    arm: Robot,
    lowpass: Butterworth,
    contact_force_n: float | None,
) -> Forces:
    """Return the contact wrench by every estimator that the recording has the inputs for.

    contact_force_n: of a typical contact [N], None: by the arm's payload.
    """
    motion, currents = recording.motion, recording.currents
    kinematics, premises = recording.kinematics, recording.premises
    wrench = recording.signals.wrench_calc_from_currents
    run = Run(motion.anew(), currents.anew(), kinematics.anew(), wrench)
    prior = ContactPrior.of(arm, contact_force_n, premises.place)
    if is_fitted(friction, premises.contradictions):
        fmap = most_probable(motion, currents, residuals, kinematics, prior, premises.place, arm)
        run = replace(run, fmap=fmap)
    else:
        static = static_forces(recording, arm, lowpass, prior.force)
        run = replace(run, static=static)
    estimates = {name: one.estimate(run) for name, one in ESTIMATORS.items()}
    fmap, time = run.fmap, motion.anew()
    del run  # of a long recording, memory has either all inputs or all results
    return Forces.of(time, estimates, fmap)


def most_probable(
    motion: Motion,
    currents: Currents,
    residuals: Residuals,
    kinematics: Kinematics,
    prior: ContactPrior,
    place: ContactPlace,
    arm: Robot,
) -> WrenchEstimate | None:
    """Return the most probable contact wrench, F̂ᵐᵃᵖ; None where `fmap_problem` finds nothing to
    estimate from.
    """
    problem = fmap_problem(motion, currents, residuals)
    if problem is None:
        return None
    used = kinematics.anew(problem.rows)
    return problem.solve(used.jacobian, prior, place.on(used.rotation), arm)


def static_forces(
    recording: Inputs, robot: Robot, lowpass: Butterworth, typical_force: float
) -> Stated | None:
    """Return the wrench of a resting arm, NaN in motion; None without currents or torque constants.

    lowpass: of currents; typical_force: of contacts [N].
    """
    record = current_record(recording, robot)
    if record is None:
        return None
    try:
        prior = prior_of(robot, [controllers_ratio(recording.signals, recording.motion)])
    except ValueError:  # neither the maker nor the controller gives the constants
        return None
    smooth, inverse = ZeroPhaseLowpass(*lowpass), prior.inverse_constant.mean
    error = np.sqrt(np.diag(np.linalg.inv(prior.inverse_constant.precision))) / inverse
    motor = smooth(record.current, record) / inverse
    torque = smooth(record.torque, record) - motor
    torque[~at_rest(record.qd)] = np.nan
    std = torque_std(motor, np.maximum(error, MIN_CONSTANT_ERROR), prior.torque_max)
    return Stated(*static_wrench(torque, std, recording.kinematics.jacobian, typical_force))
