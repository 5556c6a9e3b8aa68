"""How far encoders and IMU differ in the end effector's acceleration, by range of frequency."""

from collections.abc import Callable, Mapping
from itertools import product

import numpy as np

from ur5lib.pipeline.records.accelerations import ByRange, Difference
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import DEAD_ZONE

CUTOFFS = {"below 2 Hz": (None, 2.0), "below 5 Hz": (None, 5.0), "5 to 20 Hz": (5.0, 20.0)}
LEVELS = np.linspace(0, 1, 101)  # shares of which quantiles are stated

Differences = Callable[[float], Mapping[str, Array]]
"""Returns by motion how far both differ in acceleration (N, 6), low-passed at a cut-off [Hz]."""


def by_range(differences: Differences, qd: Array) -> dict[str, ByRange]:
    """Return how far both differ, by motion and range of frequency, in motion and at rest.

    qd: (N, 6) [rad/s]. A state without any sample is left out.
    """
    moving = np.abs(qd).max(axis=1) > DEAD_ZONE
    low = {cutoff: differences(cutoff) for cutoff in (2.0, 5.0, 20.0)}
    ranges: dict[str, ByRange] = {name: {} for name in low[2.0]}
    for motion, (name, (above, below)) in product(ranges, CUTOFFS.items()):
        within = low[below][motion] - (low[above][motion] if above else 0)
        known = np.isfinite(within).all(axis=1)
        states = {"motion": within[known & moving], "rest": within[known & ~moving]}
        ranges[motion][name] = {state: _summed(part) for state, part in states.items() if len(part)}
    return ranges


def _summed(difference: Array) -> Difference:
    quantiles = np.quantile(np.abs(difference), LEVELS, axis=0)
    return Difference(np.mean(difference**2, axis=0), quantiles)
