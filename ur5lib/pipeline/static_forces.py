"""The static estimate of a recording, where no friction was fitted to its arm."""

import numpy as np

from ur5lib.force.contact_wrench import LEAST_ERROR, at_rest, static_wrench, torque_std
from ur5lib.identification.prior import Prior
from ur5lib.identification.samples import Record, Smooth
from ur5lib.pipeline.current_prediction import smoothed_external_torque
from ur5lib.pipeline.current_samples import controllers_ratio, current_record, prior_of, smoother
from ur5lib.pipeline.estimators import Stated
from ur5lib.pipeline.records.dynamics import Torques
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array


def static_forces(
    robot: Robot,
    signals: Signals,
    motion: Motion,
    torques: Torques,
    jacobian: Array,
    order: int,
    cutoff: float,
) -> Stated | None:
    """Return the wrench of a resting arm, NaN in motion; None without currents or known constants.

    jacobian: (N, 6, 6); order, cutoff: of the low-pass of currents, [Hz].
    """
    record = current_record("", signals, motion, torques, robot.fullest_model())
    if record is None:
        return None
    try:
        prior = prior_of(robot, [controllers_ratio(signals, motion)])
    except ValueError:  # neither the maker nor the controller tells the constants
        return None
    torque, std = torque_at_rest(record, prior, smoother(order, cutoff), cutoff)
    return Stated(*static_wrench(torque, std, jacobian))


def torque_at_rest(
    record: Record, prior: Prior, smooth: Smooth, cutoff: float
) -> tuple[Array, Array]:
    """Return the external torque, NaN in motion, and its standard deviation, (N, 6) [Nm].

    prior: of the arm's torque constants; cutoff: of `smooth` [Hz].
    """
    inverse = prior.inverse_constant.mean
    error = np.sqrt(np.diag(np.linalg.inv(prior.inverse_constant.precision))) / inverse
    expected = record.torque * inverse
    torque = smoothed_external_torque(record, expected, 1 / inverse, smooth, cutoff)
    torque[~at_rest(record.qd)] = np.nan
    motor = smooth(record.current, record) / inverse
    return torque, torque_std(motor, np.maximum(error, LEAST_ERROR), prior.torque_max)
