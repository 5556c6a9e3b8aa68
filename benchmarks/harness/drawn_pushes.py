"""Pushes at the flange of a recorded arm, drawn with a seed."""

from collections.abc import Iterator

import numpy as np

from ur5lib.study.model import CurrentLowpass
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import zero_phase_lowpass

FORCES, LEVER = (5.0, 80.0), 0.1  # N, m; range of forces; moments are up to LEVER times the force
LASTS, PAUSES = (0.5, 3.0), (2.0, 6.0)  # s
DRAWS, SEED = 3, 0


def drawn_pushes(time: Array, lowpass: CurrentLowpass) -> Iterator[Array]:
    """Yield DRAWS series of the wrenches (N, 6) [N, Nm] of pushes, low-passed like torques.

    time: (N,) [s], in equal steps.
    """
    random, rate = np.random.default_rng(SEED), (len(time) - 1) / (time[-1] - time[0])
    for _ in range(DRAWS):
        wrench = np.zeros((len(time), 6))
        start = time[0] + random.uniform(*PAUSES)
        while start < time[-1]:
            end = start + random.uniform(*LASTS)
            size = np.exp(random.uniform(*np.log(FORCES)))
            way, lever = (own / np.linalg.norm(own) for own in random.normal(size=(2, 3)))
            force, point = size * way, random.uniform(0, LEVER) * lever
            wrench[(time >= start) & (time < end)] = [*force, *np.cross(point, force)]
            start = end + random.uniform(*PAUSES)
        yield zero_phase_lowpass(wrench, rate=rate, order=lowpass.order, cutoff=lowpass.cutoff_hz)
