"""What momentum observers share: the generalised momentum that an external torque has added.

    z(t) = p(t) - ∫ (τ_m - τ_f + Cᵀ q̇ - g) dt,   dz/dt = τ_ext

[De Luca and Mattone 2003]. An observer follows z by a state ẑ and its rate d, the estimate of the
external torque:

    ẑ⁻ = ẑ + T d,   e = z - ẑ⁻,   ẑ = ẑ⁻ + (momentum's correction),   d = d + (torque's correction)
"""

from abc import ABC, abstractmethod

import numpy as np

from benchmarks.harness.run import Run
from ur5lib.timeseries.arrays import Array

Corrections = tuple[Array, Array]  # of ẑ [Nm s] and d [Nm], (6,) each


def added_momentum(run: Run, rows: slice) -> Array:
    """Return z (n, 6) [Nm s] of an unbroken stretch, zero at its first sample.

    The rate is integrated by trapezoids, which end at the sample itself: nothing later is used.
    """
    momentum, rate = run.momentum[rows], run.rate[rows]
    between = (rate[1:] + rate[:-1]) / 2
    motors = np.concatenate([np.zeros((1, 6)), np.cumsum(between * run.period, axis=0)])
    return momentum - momentum[0] - motors


class MomentumObserver(ABC):
    """A causal observer of the external torque, given by its corrections."""

    @abstractmethod
    def correct(self, innovation: Array, period: float) -> Corrections:
        """Return what is added to ẑ and d; innovation: e (6,) [Nm s]; period: T [s]."""

    def torque(self, run: Run) -> Array:
        """Return the external torque (N, 6) [Nm], NaN where momentum or its rate is unknown."""
        result = np.full_like(run.momentum, np.nan)
        for rows in run.known():
            result[rows] = self.follow(added_momentum(run, rows), run.period)
        return result

    def follow(self, added: Array, period: float) -> Array:
        """Return d (n, 6) [Nm] at each sample of an unbroken stretch; added: z (n, 6) [Nm s]."""
        result = np.empty_like(added)
        momentum, torque = added[0], np.zeros(6)
        for k, measured in enumerate(added):
            if k:
                momentum = momentum + period * torque
            of_momentum, of_torque = self.correct(measured - momentum, period)
            momentum, torque = momentum + of_momentum, torque + of_torque
            result[k] = torque
        return result
