"""The adaptive Kalman filter with a moving average of variable length [Cao et al. 2021].

A mode-switching moving average of the joints' torque precedes a disturbance Kalman filter: its
window grows while the torque stays within the noise, and becomes short when the torque leaves it.
This follows the paper's abstract; the rule of switching below, by the mean of a short window, is
this benchmark's own, and the average is taken of the torque, not only of the current, so that the
momentum's change and the motors' torque have the same delay.

F. Cao, P. D. Docherty, S. Ni, X. Chen: Contact force and torque sensing for serial manipulator
based on an adaptive Kalman filter with variable time period. Robotics and Computer-Integrated
Manufacturing 72, 102210 (2021).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators.disturbance_kalman_filter import DisturbanceKalman
from ur5rivals.momentum import added_momentum
from ur5rivals.run import Run
from ur5rivals.tuning import tuned

SHORTEST_WINDOW, LONGEST_WINDOW = 2, 25  # samples, least and greatest length of the window
SWITCHING_DEVIATIONS = (1.0, 2.0, 3.0)  # standard deviations of the short mean that switch the mode
WANDERINGS = (5.0, 10.0, 20.0, 40.0)  # of the Kalman filter
MOMENTUM_NOISE = 0.1  # noise of the momentum / change of momentum in a step by the torque's noise


@dataclass(frozen=True)
class AdaptiveKalman:
    """A moving average of variable length before a disturbance Kalman filter, which estimates the
    external torque.

    outside: number of standard deviations at which the average becomes short; wandering: random
    walk of the filter's disturbance; noise: (6,) [Nm], of the torque from sample to sample.
    """

    outside: float
    wandering: float
    noise: Array = field(repr=False)

    def torque(self, run: Run) -> Array:
        """Return the external torque (N, 6) [Nm]."""
        result = np.full_like(run.momentum, np.nan)
        kalman = DisturbanceKalman(self.wandering, MOMENTUM_NOISE)
        for rows in run.known():
            raw = np.diff(added_momentum(run, rows), axis=0, prepend=0.0) / run.period
            averaged = self.averaged(raw)
            result[rows] = kalman.follow(np.cumsum(averaged, axis=0) * run.period, run.period)
        return result

    def averaged(self, raw: Array) -> Array:
        """Return the moving average (n, 6) of a torque (n, 6) [Nm] over past samples."""
        sums = np.concatenate([np.zeros((1, 6)), np.cumsum(raw, axis=0)])
        length, joints, result = np.full(6, SHORTEST_WINDOW), np.arange(6), np.empty_like(raw)
        limit = self.outside * self.noise / np.sqrt(SHORTEST_WINDOW)
        for k in range(len(raw)):
            length = np.minimum(np.minimum(length + 1, LONGEST_WINDOW), k + 1)
            few = min(SHORTEST_WINDOW, k + 1)
            recent = (sums[k + 1] - sums[k + 1 - few]) / few
            mean = (sums[k + 1] - sums[k + 1 - length, joints]) / length
            length = np.where(np.abs(recent - mean) > limit, few, length)
            result[k] = (sums[k + 1] - sums[k + 1 - length, joints]) / length
        return result


def sample_noise(runs: Sequence[Run]) -> Array:
    """Return the standard deviation (6,) [Nm] of the torque from one sample to the next."""
    steps = np.concatenate([np.diff(run.torque, axis=0) for run in runs])
    return np.nanstd(steps, axis=0) / np.sqrt(2)


def learn(runs: Sequence[Run]) -> Learned:
    """Return the filter with the threshold of the switch and the random walk tuned on the runs."""
    noise = sample_noise(runs)
    return tuned(
        [
            AdaptiveKalman(*constants, noise)
            for constants in product(SWITCHING_DEVIATIONS, WANDERINGS)
        ],
        runs,
    )


ESTIMATORS = [Contender("adaptive Kalman filter", "Cao et al. 2021", True, learn)]
