"""The static estimate of a recording, where no friction was fitted to its arm."""

import numpy as np

from ur5lib.force.contact_wrench import MIN_CONSTANT_ERROR, at_rest, static_wrench, torque_std
from ur5lib.pipeline.current_prediction import inner
from ur5lib.pipeline.current_samples import Smoother, controllers_ratio, current_record, prior_of
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
    smooth, inverse = Smoother(order, cutoff), prior.inverse_constant.mean
    error = np.sqrt(np.diag(np.linalg.inv(prior.inverse_constant.precision))) / inverse
    motor = smooth(record.current, record) / inverse
    torque = inner(smooth(record.torque, record) - motor, record, cutoff)
    torque[~at_rest(record.qd)] = np.nan
    std = torque_std(motor, np.maximum(error, MIN_CONSTANT_ERROR), prior.torque_max)
    return Stated(*static_wrench(torque, std, jacobian))
