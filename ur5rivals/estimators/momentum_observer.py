"""The first-order momentum observer [De Luca and Mattone 2003; De Luca et al. 2006].

    r = K (p - ∫ (τ_m - τ_f + Cᵀ q̇ - g + r) dt),   dr/dt = K (τ_ext - r)

One estimator is causal; two are offline, forwards and backwards with the same K: by least squares
and as F̂ᵐᵃᵖ.

A. De Luca, R. Mattone: Actuator failure detection and isolation using generalized momenta. ICRA
(2003). A. De Luca, A. Albu-Schäffer, S. Haddadin, G. Hirzinger: Collision detection and safe
reaction with the DLR-III lightweight manipulator arm. IROS (2006).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import signal

from ur5lib.force.external_torque import finite_rows
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import unbroken, without_ends
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators.ours import OURS
from ur5rivals.force import CUTOFF_HZ, breakaway_of, learned_noise, most_probable
from ur5rivals.momentum import LinearObserver
from ur5rivals.run import Run
from ur5rivals.tuning import tuned, untuned

OBSERVER_GAINS = (10.0, 15.0, 18.0, 20.0, 22.0, 25.0, 30.0, 40.0, 60.0)  # 1/s
SOURCE = "De Luca and Mattone 2003; De Luca et al. 2006"


@dataclass(frozen=True)
class FirstOrder(LinearObserver):
    """The first-order momentum observer, which estimates the external torque; gain: K [1/s]."""

    gain: float

    def gains(self, period: float) -> tuple[float, float]:
        """Return a and b of ẑ = z and r_k = r_k-1 + K T (τ_ext - r_k), solved for r_k."""
        return 1.0, self.gain / (1 + self.gain * period)


def observe(
    momentum: Array, rate: Array, segment: Labels, period: float, bandwidth: float
) -> Array:
    """Return the external torque r (N, 6) [Nm], the environment acting on the arm.

    momentum: p = D(q) qd, (N, 6) [Nm s], rotors included; rate: (N, 6) [Nm]; segment: (N,); period:
    [s]; bandwidth: K / (2 pi) [Hz]. The residual r(t) = K (p - integral of (rate + r)) is computed
    forwards and backwards over each unbroken part of the recording, so that it has no delay. NaN
    rows divide it.
    """
    result = np.full_like(momentum, np.nan)
    # r_k+1 = r_k + K T (dp/dt - rate - r_k+1), an exponential average of dp/dt - rate
    step = 2 * np.pi * bandwidth * period
    share = step / (1 + step)
    finite = finite_rows(momentum + rate)
    for rows in unbroken(segment, finite):
        if finite[rows.start] and rows.stop - rows.start > 4:
            # one joint at a time, to save memory
            for observed, p, change in zip(
                result[rows].T, momentum[rows].T, rate[rows].T, strict=True
            ):
                # dp/dt - rate at the middle of each step
                growth = np.diff(p) / period - (change[1:] + change[:-1]) / 2
                torque = signal.filtfilt([share], [1, share - 1], growth, padlen=3)
                # back to the samples: the mean of both neighbouring steps
                steps = np.pad(torque, 1, mode="edge")
                observed[:] = (steps[:-1] + steps[1:]) / 2
    return result


def learn_causal(runs: Sequence[Run]) -> Learned:
    """Return the observer with the gain tuned on the runs."""
    return tuned([FirstOrder(gain) for gain in OBSERVER_GAINS], runs)


def learn_offline(runs: Sequence[Run]) -> Learned:
    """Return the observer that runs forwards and backwards, with the gain of the causal one."""
    gain = learn_causal(runs).constants["gain"]
    bandwidth = gain / (2 * np.pi)

    def both_ways(run: Run) -> Array:
        return observe(run.momentum, run.rate, run.segment, run.period, bandwidth)

    return untuned(both_ways, runs)._replace(constants={"gain": gain})


def learn_gated(runs: Sequence[Run]) -> Learned:
    """Return F̂ᵐᵃᵖ from the observer that runs forwards and backwards, with the bandwidth of the
    study's low-pass and the noise that the runs show.
    """

    def observed(run: Run) -> Array:
        torque_of_observer = observe(run.momentum, run.rate, run.segment, run.period, CUTOFF_HZ)
        return without_ends(torque_of_observer, run.segment, run.period, CUTOFF_HZ)

    noise = learned_noise(observed, runs, breakaway_of(runs))
    return Learned(lambda run: most_probable(run, observed(run), noise), {})


ESTIMATORS = [
    Contender("momentum observer", SOURCE, True, learn_causal),
    Contender("momentum observer, zero-phase", SOURCE, False, learn_offline),
    Contender(f"{OURS}, observer", "ours", False, learn_gated),
]
