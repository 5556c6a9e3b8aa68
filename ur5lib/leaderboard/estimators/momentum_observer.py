"""The first-order momentum observer [De Luca and Mattone 2003; De Luca et al. 2006].

    r = K (p - ∫ (τ_m - τ_f + Cᵀ q̇ - g + r) dt),   dr/dt = K (τ_ext - r)

Causal, and offline as `ur5lib.force.observer` runs it forwards and backwards with the same K.

A. De Luca, R. Mattone: Actuator failure detection and isolation using generalized momenta. ICRA
(2003). A. De Luca, A. Albu-Schäffer, S. Haddadin, G. Hirzinger: Collision detection and safe
reaction with the DLR-III lightweight manipulator arm. IROS (2006).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ur5lib.force.observer import observe
from ur5lib.leaderboard.estimator import Estimator, Learned
from ur5lib.leaderboard.momentum import LinearObserver
from ur5lib.leaderboard.run import Run
from ur5lib.leaderboard.tuning import tuned, untuned
from ur5lib.timeseries.arrays import Array

GAINS = (10.0, 15.0, 18.0, 20.0, 22.0, 25.0, 30.0, 40.0, 60.0)  # 1/s


@dataclass(frozen=True)
class FirstOrder(LinearObserver):
    """gain: K [1/s]."""

    gain: float

    def gains(self, period: float) -> tuple[float, float]:
        """ẑ = z; r_k = r_k-1 + K T (τ_ext - r_k), solved for r_k."""
        return 1.0, self.gain / (1 + self.gain * period)


def learn_causal(runs: Sequence[Run]) -> Learned:
    """Tune the gain."""
    return tuned([FirstOrder(gain) for gain in GAINS], runs)


def learn_offline(runs: Sequence[Run]) -> Learned:
    """Take the gain of the causal observer."""
    gain = learn_causal(runs).constants["gain"]
    bandwidth = gain / (2 * np.pi)

    def both_ways(run: Run) -> Array:
        return observe(run.momentum, run.rate, run.segment, run.period, bandwidth)

    return untuned(both_ways, runs)._replace(constants={"gain": gain})


SOURCE = "De Luca and Mattone 2003; De Luca et al. 2006"
ESTIMATORS = [
    Estimator("momentum observer", SOURCE, True, learn_causal),
    Estimator("momentum observer, zero-phase", SOURCE, False, learn_offline),
]
