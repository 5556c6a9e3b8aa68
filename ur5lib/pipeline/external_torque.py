"""External torque: measured current against that of the same motion without contact."""

from functools import partial

from ur5lib.force.external_torque import external_torque, without_edges
from ur5lib.identification.samples import Record, Smooth
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import causal_lowpass
from ur5lib.timeseries.segments import by_segment


def smoothed_external_torque(
    record: Record, predicted: Array, constant: Array, smooth: Smooth, cutoff: float
) -> Array:
    """Return the external torque (N, 6) [Nm], the environment acting on the arm, low-passed.

    predicted: current without contact (N, 6) [A]; constant: torque constants (6,) [Nm/A]; cutoff:
    of `smooth` [Hz].
    """
    currents = (smooth(current, record) for current in (record.current, predicted))
    torque = external_torque(constant, *currents)
    return without_edges(torque, record.segment, edge(record, cutoff))


def causal_external_torque(
    record: Record, predicted: Array, constant: Array, cutoff: float
) -> Array:
    """Return the external torque (N, 6) [Nm] from each sample and those before it.

    Arguments as above. The low-pass is of first order, which delays slow changes by 1 / (2π f_c).
    """
    torque = external_torque(constant, record.current, predicted)
    lowpass = partial(causal_lowpass, rate=1 / record.period, order=1, cutoff=cutoff)
    return by_segment(lowpass, torque, record.segment)


def edge(record: Record, cutoff: float) -> int:
    """Return the number of samples at the ends of a stretch where a low-pass [Hz] extrapolates."""
    return round(0.5 / cutoff / record.period)
