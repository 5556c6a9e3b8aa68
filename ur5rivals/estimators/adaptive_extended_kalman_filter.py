"""An extended Kalman filter that adapts friction and torque constants [Jung et al. 2006].

    x = (d, α, κ) of each joint, a random walk;   k i = (τ_model + e^α τ_f - d) e^-κ + n

The state is the external torque d and the logarithms α of friction / predicted friction and κ of
torque constant / given constant. The torque varies quickly and the logarithms slowly, which
separates them; all are zero at first, because all estimators are given the same friction and
constants. The paper filters angles and velocities of three joints and adapts the noise of the
unknown input; here, the motion is given, the motor's torque k i is measured, and friction and
torque constant adapt, as the thesis suggests in Section 6.3 (an adaptive observer).

J. Jung, J. Lee, K. Huh: Robust contact force estimation for robot manipulators in three-dimensional
space. Proceedings of the Institution of Mechanical Engineers, Part C 220(9) (2006).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import product

import numpy as np

from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators.adaptive_kalman_filter import sample_noise
from ur5rivals.run import Run
from ur5rivals.tuning import tuned

WANDERINGS = (1.0, 3.0, 10.0)  # standard deviation of d's random walk after 1 s / torque noise
DRIFTS = (0.001, 0.01)  # the same of the logarithms


@dataclass(frozen=True)
class AdaptiveExtendedKalman:
    """An extended Kalman filter of each joint, which estimates external torque, friction and torque
    constant together.

    wandering, drift: random walks of d, and of α and κ [1/√s]; noise: of the motors' torque (6,)
    [Nm].
    """

    wandering: float
    drift: float
    noise: Array = field(repr=False)

    def torque(self, run: Run) -> Array:
        """Return the external torque (N, 6) [Nm], NaN where it is unknown."""
        result = np.full_like(run.torque, np.nan)
        motor = run.model + run.friction - run.torque
        for rows in run.stretches(motor):
            result[rows] = self.follow(
                motor[rows], run.model[rows], run.friction[rows], run.period
            )[..., 0]
        return result

    def follow(self, motor: Array, model: Array, friction: Array, period: float) -> Array:
        """Return the states (d, α, κ) (n, 6, 3) of successive samples; motor, model, friction:
        torques (n, 6) [Nm].
        """
        walk = np.zeros((6, 3, 3))
        walk[:, 0, 0] = (self.wandering * self.noise) ** 2 * period
        walk[:, 1, 1] = walk[:, 2, 2] = self.drift**2 * period
        state, covariance = np.zeros((6, 3)), np.zeros((6, 3, 3))
        states = np.empty((len(motor), 6, 3))
        for k, measured in enumerate(motor):
            covariance = covariance + walk
            predicted, slope = motor_torque(state, model[k], friction[k])
            shared = (covariance @ slope[..., None])[..., 0]  # P Hᵀ (6, 3)
            gain = shared / ((slope * shared).sum(axis=1) + self.noise**2)[:, None]
            state = state + gain * (measured - predicted)[:, None]
            covariance = covariance - gain[:, :, None] * shared[:, None, :]
            states[k] = state
        return states


def motor_torque(state: Array, model: Array, friction: Array) -> tuple[Array, Array]:
    """Return the motors' torque (6,) [Nm] of a state (6, 3), and its derivative (6, 3) by it."""
    external, of_friction, of_constant = state.T
    scaled, scale = np.exp(of_friction) * friction, np.exp(-of_constant)
    torque = (model + scaled - external) * scale
    return torque, np.stack([-scale, scaled * scale, -torque], axis=1)


def learn(runs: Sequence[Run]) -> Learned:
    """Return the filter with its random walks tuned on the runs: of the torque, and of friction and
    torque constant.
    """
    noise = sample_noise(runs)
    tried = product(WANDERINGS, DRIFTS)
    return tuned([AdaptiveExtendedKalman(*constants, noise) for constants in tried], runs)


ESTIMATORS = [Contender("extended Kalman filter, adaptive", "Jung et al. 2006", True, learn)]
