"""A recording as the fit of its motor currents sees it."""

from functools import partial

import pandas as pd

from ur5lib.identification.samples import Record, Smooth
from ur5lib.tables import channel, period
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import by_segment


def current_record(
    name: str, signals: pd.DataFrame, motion: pd.DataFrame, torques: pd.DataFrame, model: str
) -> Record | None:
    """Measured motion and currents, and the torque of a link model and payload at that motion.

    None where no currents were recorded.
    """
    if "actual_current_0" not in signals:
        return None
    return Record(
        name=name,
        period=period(signals),
        segment=signals["segment"].to_numpy(),
        q=channel(motion, "q"),
        qd=channel(motion, "qd"),
        torque=channel(torques, f"tau_measured_{model}") + channel(torques, "payload_torque"),
        current=channel(signals, "actual_current"),
    )


def smoother(order: int, cutoff: float) -> Smooth:
    """A zero-phase low-pass of a recording's samples, within its unbroken stretches."""

    def smooth(values: Array, record: Record) -> Array:
        lowpass = partial(zero_phase_lowpass, rate=1 / record.period, order=order, cutoff=cutoff)
        return by_segment(lowpass, values, record.segment)

    return smooth
