"""The base of momentum observers: the generalised momentum z that an external torque has added.

    z(t) = p(t) - ∫ (τ_m - τ_f + Cᵀ q̇ - g) dt,   dz/dt = τ_ext

[De Luca and Mattone 2003]. An observer follows z by a state ẑ and its rate d, the estimate of the
external torque:

    ẑ⁻ = ẑ + T d,   e = z - ẑ⁻,   ẑ = ẑ⁻ + (momentum's correction),   d = d + (torque's correction)

A linear observer has the corrections a e and b e. Its transfer function from z to d is
b (1 - p) / (1 + (a + T b - 2) p + (1 - a) p²), where p is a delay by one sample.
"""

from abc import ABC, abstractmethod

import numpy as np
from scipy.signal import lfilter

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.timeseries.arrays import Array
from ur5rivals.run import Run


def momentum_rate(weightless: LinkModel, q: Array, qd: Array, qdd: Array, torque: Array) -> Array:
    """Return the rate τ_m - τ_f + Cᵀ q̇ - g (N, 6) [Nm] of an arm without contact.

    weightless: its model without gravity, with its payload; q, qd, qdd: (N, 6) [rad, rad/s,
    rad/s²]; torque: external, τ_ext (N, 6) [Nm], τ_m less friction and inverse dynamics at this
    motion. The rate is D q̈ + C q̇ + Cᵀ q̇ - τ_ext, in which q̈ cancels.
    """
    rate = weightless.inverse_dynamics(q, qd, qdd) + weightless.coriolis_torque(q, qd)
    return rate - torque


def added_momentum(run: Run, rows: slice) -> Array:
    """Return z (n, 6) [Nm s] of successive samples, zero at the first; rows: of these samples in
    the run.

    The rate is integrated by trapezoids up to each sample, without later ones.
    """
    momentum, rate = run.momentum[rows], run.rate[rows]
    between = (rate[1:] + rate[:-1]) / 2
    motors = np.concatenate([np.zeros((1, 6)), np.cumsum(between * run.period, axis=0)])
    return momentum - momentum[0] - motors


class MomentumObserver(ABC):
    """A causal observer of the external torque, by the momentum that this torque has added."""

    def torque(self, run: Run) -> Array:
        """Return the external torque (N, 6) [Nm], NaN where momentum or its rate is unknown."""
        result = np.full_like(run.momentum, np.nan)
        for rows in run.known():
            result[rows] = self.follow(added_momentum(run, rows), run.period)
        return result

    @abstractmethod
    def follow(self, added: Array, period: float) -> Array:
        """Return d (n, 6) [Nm] at each of successive samples, which begin with ẑ = z and d = 0.

        added: z (n, 6) [Nm s]; period: T [s].
        """


class LinearObserver(MomentumObserver):
    """A momentum observer with corrections a e and b e, proportional to the error e of the
    momentum.
    """

    @abstractmethod
    def gains(self, period: float) -> tuple[float, float]:
        """Return the gains a, and b [1/s], of the corrections; period: T [s]."""

    def follow(self, added: Array, period: float) -> Array:
        """Return d (n, 6) [Nm] by the transfer function; added: z (n, 6) [Nm s]; period: T [s]."""
        a, b = self.gains(period)
        past = [1.0, a + period * b - 2.0, 1.0 - a]
        return np.asarray(lfilter([b, -b], past, added - added[0], axis=0))
