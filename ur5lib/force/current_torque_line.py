"""Torque constants and offsets by the thesis's regression line (Equation 6.5), and by its reverse.

Where the torque hardly varies about its mean, least squares of the torque on the current shrinks
the torque constant by what the current contains besides the torque, and moves the offset towards
the mean torque. The line of the current on the torque errs the other way.
"""

from typing import NamedTuple

import numpy as np

from ur5lib.timeseries.arrays import Array, Labels


class TorqueLine(NamedTuple):
    """The line torque = k i + b of each joint, (6,) each, NaN where a joint determines none.

    torque_constant: k [Nm/A], offset: b [Nm], and their standard errors.
    """

    torque_constant: Array
    offset: Array
    torque_constant_std: Array
    offset_std: Array


def torque_on_current(current: Array, torque: Array, block: Labels) -> TorqueLine:
    """Return the least-squares lines of the torque (N, 6) [Nm] on the current (N, 6) [A].

    block: (N,) ascending labels from 0, of samples with correlated errors. Standard errors by a
    jackknife over them.
    """
    slope, offset = _leave_one_out(current, torque, block)
    return TorqueLine(slope[-1], offset[-1], _jackknife(slope[:-1]), _jackknife(offset[:-1]))


def current_on_torque(current: Array, torque: Array, block: Labels) -> TorqueLine:
    """Return the least-squares lines of the current on the torque, solved for the torque."""
    slope, intercept = _leave_one_out(torque, current, block)
    constant, offset = 1 / slope, -intercept / slope
    return TorqueLine(constant[-1], offset[-1], _jackknife(constant[:-1]), _jackknife(offset[:-1]))


def _leave_one_out(x: Array, y: Array, block: Labels) -> tuple[Array, Array]:
    """Return slopes and intercepts (K + 1, 6) without each of K blocks, and of all samples."""
    moments = np.stack([np.ones_like(x), x, y, x * x, x * y])  # (5, N, 6)
    firsts = np.flatnonzero(np.diff(block, prepend=-1))
    sums = np.add.reduceat(moments, firsts, axis=1)  # (5, K, 6)
    total = sums.sum(axis=1, keepdims=True)
    n, sx, sy, sxx, sxy = np.concatenate([total - sums, total], axis=1)
    slope = (n * sxy - sx * sy) / (n * sxx - sx**2)
    return slope, (sy - slope * sx) / n


def _jackknife(values: Array) -> Array:
    """Return the standard error (6,) of an estimate from its values (K, 6) without each block."""
    count = len(values)
    return np.sqrt((count - 1) / count * np.sum((values - values.mean(axis=0)) ** 2, axis=0))
