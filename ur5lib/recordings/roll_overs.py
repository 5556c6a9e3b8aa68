"""Clocks of 32 bits that begin again on the way, made continuous: their step is fixed."""

import numpy as np

from ur5lib.timeseries.arrays import Array

ROLL_OVERS = 2**32 * 1e-6, 2**32 * 1e-3  # s, where counters of µs and of ms begin again
MAX_STEP = 5.0  # usual steps, from the last stamp before a roll-over to the next one


def without_roll_over(time: Array) -> Array:
    """Return stamps (N,) [s] that continue where a 32-bit counter of µs or ms begins again.

    There, the stamps fall by the counter's whole range less a usual step.
    """
    steps = np.diff(time)
    if not (steps < -ROLL_OVERS[0] / 2).any():
        return time
    usual = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    for period in ROLL_OVERS:
        rolled = (steps + period > 0) & (steps + period < MAX_STEP * usual)
        time = time + period * np.cumsum(np.append(False, rolled))
    return time
