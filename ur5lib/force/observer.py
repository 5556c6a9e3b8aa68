"""External torque by the generalised momentum: no joint accelerations [De Luca et al. 2006]."""

import numpy as np
from numpy.typing import NDArray
from scipy import signal

from ur5lib.force.external_torque import finite_rows, unbroken

Array = NDArray[np.float64]


def momentum_rate(motor: Array, friction: Array, coriolis: Array, gravity: Array) -> Array:
    """What changes the momentum of an arm that nothing touches: tau - tau_f + C^T qd - g.

    motor, friction, gravity: (N, 6) [Nm]; coriolis: C(q, qd)^T qd, which is dD/dt qd - C qd.
    """
    return motor - friction + coriolis - gravity


def observe(
    momentum: Array, rate: Array, segment: NDArray[np.int64], period: float, bandwidth: float
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


def _known(momentum: Array, rate: Array, segment: NDArray[np.int64]) -> list[NDArray[np.int64]]:
    """Rows of each stretch without gap and without NaN."""
    finite = finite_rows(momentum + rate)
    stretches = [np.arange(len(finite))[rows] for rows in unbroken(segment)]
    parts = [np.split(rows, 1 + np.flatnonzero(np.diff(finite[rows]))) for rows in stretches]
    return [part for split in parts for part in split if finite[part[0]]]
