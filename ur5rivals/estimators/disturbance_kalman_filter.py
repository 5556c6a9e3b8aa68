"""The disturbance Kalman filter [Hu and Xiong 2018]: the external torque as a random walk.

    z_k = z_k-1 + T (d_k-1 + w),   d_k = d_k-1 + v,   measured: z + n

The stationary gains depend only on the ratios of the noises; w is set to 1. One estimator is
causal, one offline with the smoother of Rauch, Tung and Striebel and the same noises. The paper's
semiparametric model of the friction is left out: all estimators are given the same friction.

J. Hu, R. Xiong: Contact force estimation for robot manipulator using semiparametric model and
disturbance Kalman filter. IEEE Transactions on Industrial Electronics 65(4) (2018).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.linalg import solve_discrete_are

from ur5lib.timeseries import kalman
from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Contender, Learned
from ur5rivals.momentum import LinearObserver, added_momentum
from ur5rivals.run import Run
from ur5rivals.tuning import tuned, untuned

WANDERINGS = (1.0, 2.0, 3.0, 5.0, 10.0, 20.0)  # standard deviation of d's walk after 1 s / w
MEASUREMENT_NOISES = (0.1, 1.0, 3.0)  # noise n / change of z by w in a step
SOURCE = "Hu and Xiong 2018"


@dataclass(frozen=True)
class DisturbanceKalman(LinearObserver):
    """A Kalman filter of the added momentum z, with the external torque d as a random walk.

    wandering: random walk of d in a second; measured: noise of z; both relative to the noise w.
    """

    wandering: float
    measured: float

    def system(self, period: float) -> tuple[Array, Array, float]:
        """Return transition (2, 2), process noise (2, 2) and the variance of the measurement."""
        process = np.diag([period**2, self.wandering**2 * period])
        return np.array([[1.0, period], [0.0, 1.0]]), process, (self.measured * period) ** 2

    def gains(self, period: float) -> tuple[float, float]:
        """Return the stationary Kalman gains of momentum and torque, P Hᵀ (H P Hᵀ + R)⁻¹, by
        Riccati's equation.
        """
        transition, process, variance = self.system(period)
        predicted = solve_discrete_are(
            transition.T, np.array([[1.0], [0.0]]), process, np.array([[variance]])
        )
        of_momentum, of_torque = predicted[:, 0] / (predicted[0, 0] + variance)
        return float(of_momentum), float(of_torque)

    def smoothed(self, run: Run) -> Array:
        """Return the external torque (N, 6) [Nm] given all samples."""
        result = np.full_like(run.momentum, np.nan)
        for rows in run.known():
            added = added_momentum(run, rows)
            for part in kalman.smooth(self.on(added, run.period), len(added)):
                result[rows][part.rows] = part.states.mean[..., 1]
        return result

    def on(self, added: Array, period: float) -> kalman.System:
        """Return the system that measures z (n, 6) [Nm s], each joint on its own."""
        transition, process, variance = self.system(period)

        def part(rows: slice) -> kalman.LinearSystem:
            measured = added[rows, :, None]  # (n, 6, 1)
            F, Q, H = (
                np.broadcast_to(matrix, (len(measured), 6, *matrix.shape))
                for matrix in (transition, process, np.array([[1.0, 0.0]]))
            )
            return kalman.LinearSystem(F, Q, H, measured, R=np.full_like(measured, variance))

        return part


def learn_causal(runs: Sequence[Run]) -> Learned:
    """Return the filter with the two ratios of noises tuned on the runs."""
    return tuned(
        [DisturbanceKalman(*ratios) for ratios in product(WANDERINGS, MEASUREMENT_NOISES)], runs
    )


def learn_offline(runs: Sequence[Run]) -> Learned:
    """Return the smoother with the ratios of the causal filter."""
    constants = learn_causal(runs).constants
    return untuned(DisturbanceKalman(**constants).smoothed, runs)._replace(constants=constants)


ESTIMATORS = [
    Contender("disturbance Kalman filter", SOURCE, True, learn_causal),
    Contender("disturbance Kalman filter, smoothed", SOURCE, False, learn_offline),
]
