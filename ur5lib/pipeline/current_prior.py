"""Prior of an arm's torque constants."""

from collections.abc import Sequence

import numpy as np

from ur5lib.errors import RefusalError
from ur5lib.identification.prior import Prior, standstill_ratio, torque_constant_prior
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

# Relative: of the maker's constants, among joints with motors of one size, of the controller's.
WIDTHS = (0.3, 0.1, 0.1)


def controllers_ratio(signals: Signals, motion: Motion) -> Array:
    """Return the controller's own torque constants (6,) [Nm/A], NaN where undetermined."""
    if signals.target_moment is None or signals.target_current is None:
        return np.full(6, np.nan)
    return standstill_ratio(signals.target_moment, signals.target_current, motion.motor_qd)


def prior_of(robot: Robot, ratios: Sequence[Array]) -> Prior:
    """Return the prior from the manufacturer and the controller's ratios (6,) [Nm/A] of recordings.

    Raises RefusalError if they do not suffice, or without recordings.
    """
    if not ratios:
        raise RefusalError("no fit recording")
    columns = [column[np.isfinite(column)] for column in np.array(ratios).T]
    controller = np.array([np.median(column) if len(column) else np.nan for column in columns])
    maker = np.array(robot.maker_torque_constants())
    torque_max = np.array([robot.motor(joint).torque_max for joint in range(1, 7)])
    return Prior(torque_constant_prior(maker, controller, robot.joints, WIDTHS), torque_max)
