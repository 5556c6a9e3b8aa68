"""The sliding-mode momentum observer with linear terms, SOSML [Garofalo et al. 2019].

    dẑ/dt = d + T₁ |e|^½ sign(e) + T₂ e,   dd/dt = S₁ sign(e) + S₂ e,   e = z - ẑ
    T₁ = 2 √S₁,   T₂ = 2 √S₂

The ratios of T to S are this benchmark's: two constants remain, and the linear part is critically
damped. Integrated by Euler's method. S₁ bounds the rate of the external torque, in units of each
joint's torque without contact, so that one number serves joints of all sizes.

G. Garofalo, N. Mansfeld, J. Jankowski, C. Ott: Sliding mode momentum observers for estimation of
external torques and joint acceleration. ICRA (2019).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Contender, Learned
from ur5rivals.momentum import MomentumObserver
from ur5rivals.run import Run
from ur5rivals.tuning import tuned

SWITCHING_RATES = (0.1, 0.3, 1.0, 3.0, 10.0)  # 1/s
BANDWIDTHS = (10.0, 20.0, 30.0, 40.0, 50.0)  # rad/s, √S₂


@dataclass(frozen=True)
class SlidingMode(MomentumObserver):
    """A momentum observer with sliding-mode feedback, which estimates the external torque.

    switching: S₁ [1/s] in units of `scale`; bandwidth: √S₂ [rad/s]; scale: (6,) [Nm].
    """

    switching: float
    bandwidth: float
    scale: Array = field(repr=False)

    def follow(self, added: Array, period: float) -> Array:
        """Return d (n, 6) [Nm] by steps of Euler; added: z (n, 6) [Nm s]; period: T [s]."""
        result, torque = np.empty_like(added), np.zeros(6)
        momentum, switching = added[0], self.switching * self.scale
        for k, measured in enumerate(added):
            momentum = momentum + period * torque
            innovation = measured - momentum
            sign = np.sign(innovation)
            rate = 2 * np.sqrt(switching * np.abs(innovation)) * sign
            momentum = momentum + period * (rate + 2 * self.bandwidth * innovation)
            torque = torque + period * (switching * sign + self.bandwidth**2 * innovation)
            result[k] = torque
        return result


def usual_torque(runs: Sequence[Run]) -> Array:
    """Return the root mean square (6,) [Nm] of the external torque on contact-free runs."""
    torque = np.concatenate([run.smoothed for run in runs])
    return np.sqrt(np.nanmean(torque**2, axis=0))


def learn(runs: Sequence[Run]) -> Learned:
    """Return the observer with the switching gain and the bandwidth tuned on the runs."""
    scale = usual_torque(runs)
    return tuned(
        [SlidingMode(*constants, scale) for constants in product(SWITCHING_RATES, BANDWIDTHS)], runs
    )


ESTIMATORS = [Contender("sliding-mode observer, SOSML", "Garofalo et al. 2019", True, learn)]
