"""External torque by the generalised momentum: no joint accelerations [De Luca et al. 2006]."""

import numpy as np
from scipy import signal

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import unbroken


def momentum_rate(motor: Array, friction: Array, coriolis: Array, gravity: Array) -> Array:
    """What changes the momentum of an arm that nothing touches: tau - tau_f + C^T qd - g.

    motor, friction, gravity: (N, 6) [Nm]; coriolis: C(q, qd)^T qd, which is dD/dt qd - C qd.
    """
    return motor - friction + coriolis - gravity


def observe(
    momentum: Array, rate: Array, segment: Labels, period: float, bandwidth: float
) -> Array:
    """External torque (N, 6) [Nm], the environment acting on the arm: r of K r' = dp/dt - rate - r.

    momentum: D(q) qd, (N, 6) [Nm s], rotors included; rate: (N, 6) [Nm]; segment: (N,); period:
    [s]; bandwidth: K / (2 pi) [Hz]. It is the residual r(t) = K (p - integral of (rate + r)), run
    forwards and backwards over each unbroken stretch, so that it lags behind no contact. NaN rows
    divide a stretch.
    """
    result = np.full_like(momentum, np.nan)
    step = 2 * np.pi * bandwidth * period
    share = step / (1 + step)
    for rows in _known(momentum, rate, segment):
        growth = np.diff(momentum[rows], axis=0) / period - (rate[rows][1:] + rate[rows][:-1]) / 2
        if len(growth) > 3:
            torque = signal.filtfilt([share], [1, share - 1], growth, axis=0, padlen=3)
            result[rows] = (
                torque[[0, *range(len(torque))]] + torque[[*range(len(torque)), -1]]
            ) / 2
    return result


def _known(momentum: Array, rate: Array, segment: Labels) -> list[slice]:
    """Rows of each stretch without gap and without NaN."""
    finite = finite_rows(momentum + rate)
    return [rows for rows in unbroken(segment, finite) if finite[rows.start]]
