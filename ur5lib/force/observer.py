"""External torque from the generalised momentum, without accelerations [De Luca et al. 2006]."""

import numpy as np
from scipy import signal

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import unbroken


def momentum_rate(motor: Array, friction: Array, coriolis: Array, gravity: Array) -> Array:
    """Return the rate of momentum of an arm without contact: tau - tau_f + C^T qd - g, (N, 6) [Nm].

    motor, friction, gravity: (N, 6) [Nm]; coriolis: C(q, qd)^T qd, which is dD/dt qd - C qd.
    """
    return motor - friction + coriolis - gravity


def observe(
    momentum: Array, rate: Array, segment: Labels, period: float, bandwidth: float
) -> Array:
    """Return the external torque r (N, 6) [Nm], the environment acting on the arm.

    momentum: p = D(q) qd, (N, 6) [Nm s], rotors included; rate: (N, 6) [Nm]; segment: (N,); period:
    [s]; bandwidth: K / (2 pi) [Hz]. The residual r(t) = K (p - integral of (rate + r)) is computed
    forwards and backwards over each unbroken stretch, so that it has no delay. NaN rows divide a
    stretch.
    """
    result = np.full_like(momentum, np.nan)
    # r_k+1 = r_k + K T (dp/dt - rate - r_k+1), an exponential average of dp/dt - rate
    step = 2 * np.pi * bandwidth * period
    share = step / (1 + step)
    finite = finite_rows(momentum + rate)
    for rows in unbroken(segment, finite):
        if finite[rows.start] and rows.stop - rows.start > 4:
            # joint by joint, which takes less memory
            for own, p, change in zip(result[rows].T, momentum[rows].T, rate[rows].T, strict=True):
                # dp/dt - rate at the middle of each step
                growth = np.diff(p) / period - (change[1:] + change[:-1]) / 2
                torque = signal.filtfilt([share], [1, share - 1], growth, padlen=3)
                # back to the samples: the mean of both neighbouring steps
                steps = np.pad(torque, 1, mode="edge")
                own[:] = (steps[:-1] + steps[1:]) / 2
    return result
