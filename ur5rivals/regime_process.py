"""A Gaussian process of a torque with noise that depends on the joint and its regime of motion.

The mean has the kernel and the prior of `estimators/gaussian_process.py`; each noise has the prior
of the noise there.
"""

from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from ur5lib.force.external_torque import JointState
from ur5lib.timeseries.arrays import Array
from ur5rivals.estimators.gaussian_process import (
    PRIOR_LOGARITHMS,
    kernel,
    most_probable,
)
from ur5rivals.learned_residual import (
    Predict,
    TrainingSamples,
    deviation,
    in_parts,
    residual,
    spread_over,
)
from ur5rivals.run import Run

FAST_SPEED = 0.3  # rad/s; least speed of a fast joint
REST, REVERSAL, SLOW, FAST = REGIMES = range(4)
MAX_SAMPLES = 300  # for learning the process
ROWS_TOGETHER = 1000  # samples predicted at once
KERNEL_PRIOR, NOISE_PRIOR = PRIOR_LOGARITHMS[:4], PRIOR_LOGARITHMS[4:] * 6 * len(REGIMES)


def motion(run: Run) -> TrainingSamples:
    """Return as inputs those of `residual` with the regime of each joint (N, 24), and as torque
    that of `residual`.
    """
    moving = np.where(np.abs(run.qd) > FAST_SPEED, FAST, SLOW)
    conditions = [run.states == JointState.MOVING, run.states == JointState.REVERSING]
    inputs, torque = residual(run)
    regimes = np.select(conditions, [moving, REVERSAL], REST)
    return TrainingSamples(np.concatenate([inputs, regimes], axis=1), torque)


class Points(NamedTuple):
    """The points at which the process is known: motions (n, 18), in units of their standard
    deviations, and regimes (n, 6).
    """

    motions: Tensor
    regimes: Tensor

    @classmethod
    def of(cls, inputs: Array, unit: Array) -> "Points":
        """Return the points of inputs (n, 24), as `motion` returns them; unit: standard deviations
        of the motions (18,).
        """
        motions, regimes = np.split(inputs, [18], axis=1)
        return cls(torch.as_tensor(motions / unit), torch.as_tensor(regimes.astype(int)))

    def noise(self, logs: Tensor) -> Tensor:
        """Return the noise's variances (n, 6) by joint; logs: logarithms of the kernel's constants
        and of the noises (28,).
        """
        by_joint = (2 * logs[len(KERNEL_PRIOR) :]).exp().reshape(6, len(REGIMES))
        return by_joint[torch.arange(6), self.regimes] + 1e-6

    def factors(self, logs: Tensor) -> Tensor:
        """Return the Cholesky factors (6, n, n) of K + Σ of each joint."""
        shared = kernel(self.motions, self.motions, logs)
        return torch.linalg.cholesky(shared + torch.diag_embed(self.noise(logs).T))


def most_likely(points: Points, values: Tensor) -> Tensor:
    """Return the logarithms (28,) of all constants; values: (6, n, 1)."""

    def misfit(logs: Tensor) -> Tensor:
        roots = points.factors(logs)
        whitened = torch.linalg.solve_triangular(roots, values, upper=False)
        return (whitened**2).sum() / 2 + roots.diagonal(dim1=1, dim2=2).log().sum()

    return most_probable(misfit, KERNEL_PRIOR + NOISE_PRIOR)


def train(learnt: TrainingSamples, _: TrainingSamples) -> Predict:
    """Return a function that predicts mean and variance, with noise, of the torque (N, 12)
    [Nm, N²m²].

    The left-out path is not needed.
    """
    inputs, torque = spread_over(learnt, MAX_SAMPLES)
    unit, scale = deviation(inputs[:, :18]), deviation(torque)
    points, values = Points.of(inputs, unit), torch.as_tensor((torque / scale).T[:, :, None])
    logs = most_likely(points, values)
    roots = points.factors(logs)
    inverses, weights = torch.cholesky_inverse(roots), torch.cholesky_solve(values, roots)[..., 0]

    def predict(part: Array) -> Array:
        new = Points.of(part, unit)
        near = kernel(new.motions, points.motions, logs)
        known = ((near @ inverses) * near).sum(2).T
        variance = (2 * logs[3]).exp() - known + new.noise(logs)
        return np.hstack([(near @ weights.T).numpy() * scale, variance.numpy() * scale**2])

    return in_parts(predict, ROWS_TOGETHER)
