"""The extended state observer of the momentum, of second order [Ren et al. 2018; Gao 2003].

    dẑ/dt = d + 2 ω (z - ẑ),   dd/dt = ω² (z - ẑ)

Both poles lie at the bandwidth ω, in discrete time at exp(-ω T).

T. Ren, Y. Dong, D. Wu, K. Chen: Collision detection and identification for robot manipulators based
on extended state observer. Control Engineering Practice 79 (2018). Z. Gao: Scaling and
bandwidth-parameterization based controller tuning. American Control Conference (2003).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ur5rivals.estimator import Contender, Learned
from ur5rivals.momentum import LinearObserver
from ur5rivals.run import Run
from ur5rivals.tuning import tuned

BANDWIDTHS = (20.0, 30.0, 35.0, 40.0, 45.0, 50.0, 60.0, 80.0, 120.0)  # rad/s


@dataclass(frozen=True)
class ExtendedState(LinearObserver):
    """An observer of the added momentum with the external torque as an additional state; bandwidth:
    ω [rad/s].
    """

    bandwidth: float

    def gains(self, period: float) -> tuple[float, float]:
        """Return a and b that place both poles at exp(-ω T)."""
        pole = float(np.exp(-self.bandwidth * period))
        return 1 - pole**2, (1 - pole) ** 2 / period


def learn(runs: Sequence[Run]) -> Learned:
    """Return the observer with the bandwidth tuned on the runs."""
    return tuned([ExtendedState(bandwidth) for bandwidth in BANDWIDTHS], runs)


ESTIMATORS = [Contender("extended state observer", "Ren et al. 2018; Gao 2003", True, learn)]
