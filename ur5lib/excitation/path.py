"""The trajectories of a design: Fourier series of six joints that begin and end at rest."""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.fourier import fourier_terms


class States(NamedTuple):
    """States along a path, (N, 6) each [rad, rad/s, rad/s², rad/s³]."""

    q: Array
    qd: Array
    qdd: Array
    jerk: Array


@dataclass(frozen=True)
class Path:
    """q(t) = posture + Σ_k a_k sin(2πkt/T) + b_k cos(2πkt/T), with T the duration.

    posture: (6,) [rad], at which it begins and ends; coefficients: (2 H, 6) [rad], of the sines,
    then of the cosines; seconds: T.
    """

    posture: Array
    coefficients: Array
    seconds: float

    def at(self, time: Array) -> States:
        """Return the states at times (N,) [s]."""
        terms = fourier_terms(self.seconds, len(self.coefficients) // 2, time)
        q, qd, qdd, jerk = (term @ self.coefficients for term in terms)
        return States(q + self.posture, qd, qdd, jerk)

    def sampled(self, rate: float) -> tuple[Array, States]:
        """Return times (N,) [s] from beginning to end at a rate [Hz], and the states there."""
        time = np.linspace(0, self.seconds, 1 + round(self.seconds * rate))
        return time, self.at(time)

    def shrunk(self, share: float | Array) -> "Path":
        """Return the path scaled about its posture; share: one factor, or one per joint (6,)."""
        return replace(self, coefficients=self.coefficients * share)
