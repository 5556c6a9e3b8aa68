"""A recording as the fit of its motor currents uses it."""

from functools import partial

from ur5lib.identification.samples import Record, Smooth
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import Torques
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment


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
