"""A recording as the fit of its motor currents uses it, and the prior of its torque constants."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ur5lib.identification.population import Population, typical_of
from ur5lib.identification.prior import (
    Prior,
    makers_covariance,
    standstill_ratio,
    torque_constant_prior,
)
from ur5lib.identification.samples import Record
from ur5lib.pipeline.records.dynamics import Torques
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment

# Relative: of the maker's constants, and among joints with motors of one size.
MAKERS = 0.3, 0.1
CONTROLLERS = 0.1  # relative, of the controller's ratio


def current_record(
    name: str, signals: Signals, motion: Motion, torques: Torques, model: str
) -> Record | None:
    """Return motion and currents as measured, and the torque of a link model and the payload.

    None where no currents were recorded.
    """
    if signals.actual_current is None:
        return None
    return Record(
        name=name,
        period=signals.period,
        segment=signals.segment,
        q=motion.q,
        qd=motion.motor_qd,
        torque=torques.measured[model] + torques.payload_torque,
        current=signals.actual_current,
        temperature=signals.joint_temperatures,
    )


@dataclass(frozen=True)
class Smoother:
    """A zero-phase low-pass of a recording's samples within its segments; cutoff: [Hz]."""

    order: int
    cutoff: float

    def __call__(self, values: Array, record: Record) -> Array:
        """Return values (N, M), low-passed."""
        rate = 1 / record.period
        return by_segment(zero_phase_lowpass, values, record.segment, rate, self.order, self.cutoff)


def controllers_ratio(signals: Signals, motion: Motion, odd: Sequence[int] = ()) -> Array:
    """Return the controller's own torque constants (6,) [Nm/A], NaN where undetermined.

    odd: joints from 1 whose `target_current` is not that of their motors.
    """
    if signals.target_moment is None or signals.target_current is None:
        return np.full(motion.q.shape[1], np.nan)
    ratio = standstill_ratio(signals.target_moment, signals.target_current, motion.motor_qd)
    ratio[[joint - 1 for joint in odd]] = np.nan
    return ratio


def prior_of(robot: Robot, ratios: Sequence[Array], population: Population | None = None) -> Prior:
    """Return the prior of an arm, whose friction is that of a population, or unknown without one.

    Its torque constants come from the population, else from the manufacturer, and from the
    controller's ratios (n,) [Nm/A] of recordings. Raises RefusalError if they do not suffice.
    """
    joints = range(1, len(robot.joints) + 1)
    columns = [
        [own[joint - 1] for own in ratios if np.isfinite(own[joint - 1])] for joint in joints
    ]
    controller = np.array([np.median(column) if column else np.nan for column in columns])
    torque_max = np.array(robot.torque_limits())
    known = np.array(robot.maker_torque_constants())
    typical = typical_of(robot, population)
    if (ratio := typical.pop("torque_constant", None)) is not None:
        family = np.array(robot.family_torque_constants()) * ratio.mean
        measured = np.isfinite(family)
        known = np.where(measured, family, known)
    covariance = makers_covariance(known, controller, robot.joints, *MAKERS)
    if ratio is not None:
        covariance = np.where(np.outer(measured, measured), ratio.covariance, covariance)
    constants = torque_constant_prior(known, covariance, controller, CONTROLLERS)
    return Prior(constants, torque_max, typical=typical)
