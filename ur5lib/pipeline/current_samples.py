"""A recording as the fit of its motor currents uses it, and the prior of its torque constants."""

from collections.abc import Sequence
from functools import partial

import numpy as np

from ur5lib.errors import RefusalError
from ur5lib.identification.prior import Prior, standstill_ratio, torque_constant_prior
from ur5lib.identification.samples import Record, Smooth
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import Torques
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment

# Relative: of the maker's constants, among joints with motors of one size, of the controller's.
WIDTHS = (0.3, 0.1, 0.1)


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


def smoother(order: int, cutoff: float) -> Smooth:
    """Return a zero-phase low-pass of a recording's samples within its segments; cutoff: [Hz]."""

    def smooth(values: Array, record: Record) -> Array:
        lowpass = partial(zero_phase_lowpass, rate=1 / record.period, order=order, cutoff=cutoff)
        return by_segment(lowpass, values, record.segment)

    return smooth


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
