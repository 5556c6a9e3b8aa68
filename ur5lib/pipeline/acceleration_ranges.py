"""How far encoders and IMU differ in the end effector's acceleration, by range of frequency."""

from collections.abc import Callable
from typing import Any

import numpy as np

from ur5lib.timeseries.arrays import Array

CUTOFFS = {"below 2 Hz": (None, 2.0), "below 5 Hz": (None, 5.0), "5 to 20 Hz": (5.0, 20.0)}
MOVING = 0.02  # rad/s of the fastest joint, beyond which the arm is in motion
LEVELS = np.linspace(0, 1, 101)  # shares of which quantiles are stated

Difference = Callable[[float], Array]
"""Returns the difference of both accelerations (N, 6), low-passed at a cut-off [Hz]."""


def by_range(difference: Difference, qd: Array) -> dict[str, Any]:
    """Return how far both differ, by range of frequency, in motion and at rest.

    qd: (N, 6) [rad/s]. For each range and state: mean squares (6,) of x, y, z [m/s²] and
    rx, ry, rz [rad/s²], and quantiles (101, 6) of the absolute difference. A state without any
    sample is left out.
    """
    moving = np.abs(qd).max(axis=1) > MOVING
    low = {cutoff: difference(cutoff) for cutoff in (2.0, 5.0, 20.0)}
    ranges: dict[str, Any] = {}
    for name, (above, below) in CUTOFFS.items():
        within = low[below] - (low[above] if above else 0)
        known = np.isfinite(within).all(axis=1)
        states = {"motion": within[known & moving], "rest": within[known & ~moving]}
        ranges[name] = {state: _summed(part) for state, part in states.items() if len(part)}
    return ranges


def _summed(difference: Array) -> dict[str, Array]:
    quantiles = np.quantile(np.abs(difference), LEVELS, axis=0)
    return {"square": np.mean(difference**2, axis=0), "quantiles": quantiles}
