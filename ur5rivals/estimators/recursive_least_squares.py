"""Filtered dynamics and recursive least squares with forgetting [Van Damme et al. 2011].

    min Σ_i λ^(k-i) (τ_i - J_vᵀ F_k)ᵀ S⁻¹ (τ_i - J_vᵀ F_k)

The dynamics pass a first-order filter, so that they need no acceleration: their residual is the
torque τ of the first-order momentum observer. The recursion is in information form, with
exponentially weighted sums, and gives the same force. As for all estimators, the joints are
weighted by their noise S, unlike in the paper; the Jacobian, which changes little within the
filter's time constant, is not filtered. The band uses the information of only one sample, because
errors of friction last longer than the memory.

M. Van Damme, P. Beyl, B. Vanderborght, V. Grosu, R. Van Ham, I. Vanderniepen, A. Matthys,
D. Lefeber: Estimating robot end-effector force from noisy actuator torque measurements. ICRA
(2011).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np
from scipy.signal import lfilter

from ur5lib.force.residual_model import ResidualModel
from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators.momentum_observer import FirstOrder
from ur5rivals.force import learned_noise
from ur5rivals.run import Estimate, Run
from ur5rivals.tuning import least_false

FILTER_GAINS = (30.0, 40.0, 60.0, 100.0)  # 1/s
MEMORY_SPANS = (0.01, 0.02, 0.03, 0.04)  # s; a sample of this age has the weight 1/e


@dataclass(frozen=True)
class ForgettingLeastSquares:
    """Least squares of the force with exponential forgetting, from the torque of a first-order
    observer.

    gain: of that filter [1/s]; memory: -T / log λ [s]; noise: of the torque without contact.
    """

    gain: float
    memory: float
    noise: ResidualModel = field(repr=False)

    def estimate(self, run: Run) -> Estimate:
        """Return the force and its standard deviation, NaN where the torque is unknown."""
        torque = FirstOrder(self.gain).torque(run)
        wrench, std = np.full_like(torque, np.nan), np.full_like(torque, np.nan)
        forgetting = np.exp(-run.period / self.memory)
        for rows in run.stretches(torque):
            spread = self.noise.spread[run.states[rows], np.arange(6)]
            jacobian = run.jacobian[rows, :3]
            weighted = jacobian / spread[:, None] ** 2  # J_v S⁻¹ (n, 3, 6)
            information = forgotten(weighted @ jacobian.mT, forgetting)
            covariance = np.linalg.pinv(information, hermitian=True)
            sums = forgotten(weighted @ torque[rows, :, None], forgetting)
            wrench[rows] = std[rows] = 0.0
            wrench[rows, :3] = (covariance @ sums)[..., 0]
            std[rows, :3] = np.sqrt(np.diagonal(covariance, axis1=1, axis2=2))
        return Estimate(wrench, std)

    def torque(self, run: Run) -> Array:
        """Return the joint torques Jᵀ F (N, 6) [Nm] of the force."""
        return (run.jacobian.mT @ self.estimate(run).wrench[..., None])[..., 0]


def forgotten(values: Array, forgetting: float) -> Array:
    """Return the mean (n, ...) of the values up to each sample, weighted by forgetting^age.

    The weights are normalised to the sum 1 at every sample.
    """
    weights = lfilter([1.0], [1.0, -forgetting], np.ones(len(values)))
    sums = lfilter([1.0], [1.0, -forgetting], values, axis=0)
    return np.asarray(sums / weights.reshape(-1, *np.ones(values.ndim - 1, int)))


def learn(runs: Sequence[Run]) -> Learned:
    """Return the estimator with the filter's gain and the memory tuned on the runs."""
    noises = {gain: learned_noise(FirstOrder(gain).torque, runs) for gain in FILTER_GAINS}
    tried = [
        ForgettingLeastSquares(gain, memory, noises[gain])
        for gain, memory in product(FILTER_GAINS, MEMORY_SPANS)
    ]
    return least_false(tried, runs, lambda candidate: candidate.estimate)


ESTIMATORS = [
    Contender("recursive least squares, forgetting", "Van Damme et al. 2011", True, learn)
]
