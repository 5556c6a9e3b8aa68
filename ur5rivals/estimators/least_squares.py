"""Weighted least squares without a prior: F = (J_v S⁻¹ J_vᵀ)⁻¹ J_v S⁻¹ τ [Aitken 1936].

Offline from the torque after the study's zero-phase low-pass, at all times or, as in the study,
only in the contacts that F̂ᵐᵃᵖ finds, less the background; causal from the torque after a
first-order low-pass.

A. C. Aitken: On least squares and linear combination of observations. Proceedings of the Royal
Society of Edinburgh 55 (1936).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.signal import lfilter

from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import by_segment
from ur5rivals.estimator import Contender, Learned, ready
from ur5rivals.run import Run
from ur5rivals.tuning import tuned, untuned

TIME_CONSTANTS = (0.015, 0.02, 0.03, 0.04, 0.045, 0.05, 0.06)  # s
SOURCE = "Aitken 1936"


@dataclass(frozen=True)
class LowPassed:
    """The external torque through a first-order low-pass; time_constant: [s]."""

    time_constant: float

    def torque(self, run: Run) -> Array:
        """Return the external torque (N, 6) [Nm]; it begins at zero in each stretch."""
        return self.filtered(run.torque, run)

    def filtered(self, torque: Array, run: Run) -> Array:
        """Return a torque (N, 6) [Nm] of a run through the low-pass."""
        kept = np.exp(-run.period / self.time_constant)
        return by_segment(
            lambda values: lfilter([1 - kept], [1, -kept], values, axis=0), torque, run.segment
        )


def learn_offline(runs: Sequence[Run]) -> Learned:
    """Return the least-squares force with the noise that the runs show; the low-pass is the
    study's.
    """
    return untuned(lambda run: run.smoothed, runs)


def learn_causal(runs: Sequence[Run]) -> Learned:
    """Return the least-squares force from the torque behind a first-order low-pass, with the time
    constant tuned on the runs.
    """
    return tuned([LowPassed(time_constant) for time_constant in TIME_CONSTANTS], runs)


ESTIMATORS = [
    Contender("least squares", SOURCE, False, learn_offline),
    Contender("least squares behind our gate", SOURCE, False, ready("least_squares")),
    Contender("least squares, causal", SOURCE, True, learn_causal),
]
