"""A Kalman filter that weights a torque by its predicted variance [Akbıyık et al. 2025].

    d_k = d_k-1 + v,   τ_k - μ_k = d_k + n,   var n = σ²_k

K-VARK learns mean μ and variance σ² of the residual torque τ of friction and model, as functions of
the motion, and filters the external torque d with them; the noise of v adapts by variational Bayes.
This is from the paper's abstract. The rest is this benchmark's own: `regime_process`, with noise
that depends on the joint and its regime (at rest, reversing, slow, fast), replaces the movement
primitives, each joint is filtered separately, and the prior variance of a sample adapts by the rule
of Huang et al. 2018.

O. Akbıyık, N. Alhousani, F. J. Abu-Dakka: K-VARK: Kernelized variance-aware residual Kalman filter
for sensorless force estimation in collaborative robots. arXiv 2512.13009 (2025). Y. Huang,
Y. Zhang, Z. Wu, N. Li, J. Chambers: A novel adaptive Kalman filter with inaccurate process and
measurement noise covariance matrices. IEEE Transactions on Automatic Control 63(2) (2018).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators.gaussian_process import SAMPLE_STEP
from ur5rivals.force import TorqueEstimate
from ur5rivals.learned_residual import cross_fitted
from ur5rivals.regime_process import motion, train
from ur5rivals.run import Run
from ur5rivals.tuning import tuned

# Standard deviations of d's random walk after 1 s, in units of the usual σ.
WANDERINGS = (1.0, 1.5, 2.0, 2.5, 3.0, 4.0, 6.0)
PRIOR_WEIGHT, ROUNDS = 3.0, 3  # of a sample's prior variance; of its adaptation


@dataclass(frozen=True)
class VarianceAware:
    """A Kalman filter of each joint's external torque that weights a measured torque by its
    predicted variance.

    wandering: random walk of d; usual: the median of σ² (6,) [N²m²]; residual: function of a run
    that returns μ and σ² (N, 12) [Nm, N²m²].
    """

    wandering: float
    usual: Array = field(repr=False)
    residual: TorqueEstimate = field(repr=False)

    def torque(self, run: Run) -> Array:
        """Return the external torque (N, 6) [Nm], NaN where it is unknown."""
        result, (mean, variance) = np.full_like(run.torque, np.nan), moments(self.residual(run))
        for rows in run.stretches(run.torque - mean):
            result[rows] = self.follow((run.torque - mean)[rows], variance[rows], run.period)
        return result

    def follow(self, measured: Array, variance: Array, period: float) -> Array:
        """Return d (n, 6) [Nm] of successive samples; measured, variance: torque less its predicted
        mean, and its predicted variance (n, 6) [Nm, N²m²].
        """
        walk = self.wandering**2 * self.usual * period
        torque, spread, found = np.zeros(6), np.zeros(6), np.empty_like(measured)
        for k, (value, noise) in enumerate(zip(measured, variance, strict=True)):
            before = expected = spread + walk
            for _ in range(ROUNDS):
                gain = expected / (expected + noise)
                change, spread = gain * (value - torque), (1 - gain) * expected
                expected = (PRIOR_WEIGHT * before + spread + change**2) / (PRIOR_WEIGHT + 1)
            torque = torque + change
            found[k] = torque
        return found


def moments(values: Array) -> tuple[Array, Array]:
    """Return mean and variance, (N, 6) each, from the columns (N, 12) of a prediction."""
    return values[:, :6], values[:, 6:]


def learn(runs: Sequence[Run]) -> Learned:
    """Return the filter with a process fitted without each path in turn, and a tuned random walk.
    Raises as `cross_fitted`.
    """
    learnt = cross_fitted(train, runs, SAMPLE_STEP, motion)
    kept = lru_cache(maxsize=32)(learnt)  # all candidates are tried on the same runs
    usual = np.nanmedian(np.concatenate([moments(kept(run))[1] for run in runs]), axis=0)
    return tuned([VarianceAware(wandering, usual, kept) for wandering in WANDERINGS], runs)


ESTIMATORS = [Contender("variance-aware Kalman filter, K-VARK", "Akbıyık et al. 2025", True, learn)]
