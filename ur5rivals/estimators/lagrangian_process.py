"""A Gaussian process of an arm's energies for the motors' torque [Giacomuzzo et al. 2024].

LIP learns the motors' whole torque without friction or rigid-body model; what is measured beyond
it is the external torque, through the low-pass of causal least squares. In addition to the energies
of `lagrangian_kernel`, each joint has dry and viscous friction, and noise. Unlike in the paper,
both factors of a square weigh alike, the constants have a prior, and samples are few, so that one
processor learns in seconds.

G. Giacomuzzo, R. Carli, D. Romeres, A. Dalla Libera: A black-box physics-informed estimator based
on Gaussian process regression for robot inverse dynamics identification. IEEE Transactions on
Robotics 40 (2024), arXiv 2310.06585.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from ur5lib.timeseries.arrays import Array
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators.gaussian_process import SAMPLE_STEP, most_probable
from ur5rivals.lagrangian_kernel import Energies, Motion, each_torque, torque_covariance
from ur5rivals.learned_residual import (
    Predict,
    TrainingSamples,
    beyond,
    cross_fitted,
    in_parts,
    motor,
    spread_over,
)
from ur5rivals.run import Run

SEARCH_SAMPLES = 120  # the constants are chosen by this many
MAX_SAMPLES, ROWS_TOGETHER = 300, 100  # torques are predicted from the first, the second at once
SMOOTH_SPEED = 0.01  # rad/s; dry friction reverses over it
ROUNDING = 1e-8  # share of the variance added to a matrix without noise, against rounding errors
# Centres of the prior; its width is a factor of e².
SPEED_WEIGHT, ENERGY_SIZE = 0.3, 20.0  # kg m², J
DRY, VISCOUS, NOISE = 3.0, 3.0, 1.0  # Nm, Nm s/rad, Nm
PRIOR_WIDTH = 2.0  # of the logarithms


class Process(NamedTuple):
    """A Gaussian process of the motors' torque, from processes of an arm's energies, friction and
    noise.

    energies: of the arm; dry, viscous: friction (n,) [Nm, Nm s/rad]; noise: (n,) [Nm].
    """

    energies: Energies
    dry: Tensor
    viscous: Tensor
    noise: Tensor

    def covariance(self, first: Motion, second: Motion, right: Tensor) -> Tensor:
        """Return the covariances (C, n, N, M) [N²m²] without noise, as `torque_covariance`."""
        signs = (torch.tanh(motion.qd / SMOOTH_SPEED) for motion in (first, second))
        by_joint = "j, jn, jm -> jnm"
        friction = torch.einsum(by_joint, self.dry**2, *signs)
        friction = friction + torch.einsum(by_joint, self.viscous**2, first.qd, second.qd)
        of_energies = torque_covariance(first, second, self.energies, right)
        return of_energies + friction * right[:, :, None]

    def factor(self, motions: Motion) -> Tensor:
        """Return the Cholesky factor (n M, n M) of the covariance with noise."""
        joints, samples = motions.q.shape
        blocks = self.covariance(motions, motions, each_torque(motions))
        matrix = blocks.permute(1, 2, 0, 3).reshape(joints * samples, joints * samples)
        noise = (self.noise**2).repeat_interleave(samples) + ROUNDING * matrix.diagonal().mean()
        return torch.linalg.cholesky(matrix + noise.diag())


def process_of(logs: Tensor, joints: int) -> Process:
    """Return the process of constants (n² + 5 n + 1,), each in widths of its prior: logarithms of
    their ratios to the prior's centres, logits of `turn` and `posture`.
    """
    rows, columns = torch.tril_indices(joints, joints)
    sizes = [len(rows), len(rows), joints, joints, joints, joints, 1]
    speed, turn, posture, dry, viscous, noise, size = (PRIOR_WIDTH * logs).split(sizes)
    links = logs.new_zeros(2, joints, joints)  # S and w, a row for each link
    links[:, rows, columns] = torch.stack([SPEED_WEIGHT * speed.exp(), turn.sigmoid()])
    energies = Energies(links[0], links[1], ENERGY_SIZE * size.exp(), posture.sigmoid())
    return Process(energies, DRY * dry.exp(), VISCOUS * viscous.exp(), NOISE * noise.exp())


def most_likely(learnt: TrainingSamples) -> Process:
    """Return the process with the most probable constants, given motions and torques."""
    motions, joints = Motion.of(learnt.inputs), learnt.torque.shape[1]
    torque = torch.as_tensor(learnt.torque.T.reshape(-1, 1))

    def misfit(logs: Tensor) -> Tensor:
        root = process_of(logs, joints).factor(motions)
        whitened = torch.linalg.solve_triangular(root, torque, upper=False)
        return (whitened**2).sum() / 2 + root.diagonal().log().sum()

    return process_of(most_probable(misfit, np.zeros(joints**2 + 5 * joints + 1)), joints)


def train(learnt: TrainingSamples, _: TrainingSamples) -> Predict:
    """Return a function that predicts the motors' torque by a fitted process; the left-out path is
    not needed.
    """
    process = most_likely(spread_over(learnt, SEARCH_SAMPLES))
    kept = spread_over(learnt, MAX_SAMPLES)
    motions, torque = Motion.of(kept.inputs), torch.as_tensor(kept.torque.T.reshape(-1, 1))
    weights = torch.cholesky_solve(torque, process.factor(motions)).reshape(1, *motions.q.shape)

    def predict(new: Array) -> Array:
        return process.covariance(Motion.of(new), motions, weights)[0].sum(2).T.numpy()

    return in_parts(predict, ROWS_TOGETHER)


def motion(run: Run) -> TrainingSamples:
    """Return as inputs (q, q̇, q̈) (N, 18) [rad, rad/s, rad/s²], and as torque that of the motors,
    k i [Nm].
    """
    return TrainingSamples(np.concatenate([run.q, run.qd, run.qdd], axis=1), motor(run))


def learn(runs: Sequence[Run]) -> Learned:
    """Return the estimator with a process fitted without each path in turn, and a tuned low-pass.
    Raises as `cross_fitted`.
    """
    return beyond(cross_fitted(train, runs, SAMPLE_STEP, motion), runs)


ESTIMATORS = [Contender("Lagrangian Gaussian process, LIP", "Giacomuzzo et al. 2024", True, learn)]
