"""How well efforts are explained by the whole motion: by the declared links, and by any links.

D: the torque of the declared links (gravity, inertia, what their speeds need) with friction and an
offset of each joint. F: any links on the declared axes, one set of inertial parameters for all
joints, with the same friction. Both are judged on stretches of time that their fits left out, by
the logarithm of the mean square of what they leave: a difference of 0.1 is 10 % of a square.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ur5lib.checks.block_means import BlockMeans
from ur5lib.channels import MEASURED_CURRENT
from ur5lib.robots.description import Robot
from ur5lib.robots.drives import shaft_matrix
from ur5lib.robots.newton_euler import torque_regressor
from ur5lib.robots.inertia import inertial_parameters, rigid_bodies
from ur5lib.timeseries.arrays import Array

STRETCHES = 10  # of time, each of which is left out once
FRICTION_SPEED = 0.02  # rad/s
FRICTION_COLUMNS = 3  # of a joint: dry, viscous, offset
RIDGE = 1e-4  # of columns of unit size
NOISE = 0.02  # Nm
WEIGHING_ROUNDS = 3
MAX_BLOCKS = 1200
MAX_SLOPE = 1.75


def friction_columns(arm: Robot, qd: Array) -> Array:
    n = qd.shape[1]
    shafts = shaft_matrix(arm)
    rate = qd @ shafts.T
    cols = np.zeros((len(qd), n, 3 * n))
    for k in range(n):
        cols[:, :, k] = np.tanh(rate[:, k] / FRICTION_SPEED)[:, None] * shafts[k]
        cols[:, :, n + k] = rate[:, k, None] * shafts[k]
        cols[:, k, 2 * n + k] = 1.0
    return cols


class Fit:
    """columns (M, n, C)."""

    def __init__(self, columns: Array, ridge: Array | float = RIDGE):
        M, n, C = columns.shape
        self.columns = columns
        self.fold = np.arange(M) * STRETCHES // M
        scale = np.sqrt((columns**2).mean(axis=(0, 1)))
        self.scale = np.where(scale > 1e-9 * max(scale.max(initial=0), 1e-300), scale, 1.0)
        self.X = columns / self.scale
        self.X = np.where(scale > 1e-9, self.X, 0.0)
        self.edges = np.searchsorted(self.fold, np.arange(STRETCHES + 1))
        self.grams = np.stack(
            [self._g(self.X[a:b]) for a, b in zip(self.edges[:-1], self.edges[1:])]
        )  # F, n, C, C
        self.ridge = np.broadcast_to(ridge, (C,))

    @staticmethod
    def _g(X):
        Xj = X.swapaxes(0, 1)
        return Xj.mT @ Xj

    def result(self, y: Array):
        M, n = y.shape
        prods = np.stack(
            [
                np.einsum("mjc,mj->jc", self.X[a:b], y[a:b])
                for a, b in zip(self.edges[:-1], self.edges[1:])
            ]
        )
        G, P = self.grams.sum(0), prods.sum(0)
        w = 1 / (y.var(axis=0) + NOISE**2)
        for _ in range(WEIGHING_ROUNDS):
            beta = self._solve(G, P, w, M)
            r = y - self.X @ beta
            w = 1 / ((r**2).mean(0) + NOISE**2)
        left = np.empty_like(y)
        betas = []
        for f, (a, b) in enumerate(zip(self.edges[:-1], self.edges[1:])):
            bf = self._solve(G - self.grams[f], P - prods[f], w, M)
            betas.append(bf / self.scale)
            left[a:b] = y[a:b] - self.X[a:b] @ bf
        return left, beta / self.scale, np.array(betas)

    def _solve(self, G, P, w, M):
        A = np.einsum("j,jcd->cd", w, G)
        b = w @ P
        A = A + np.diag(self.ridge * M * w.mean())
        return np.linalg.solve(A, b)


def score(left: Array, noise: float = NOISE) -> Array:
    return np.log((left**2).mean(0) + noise**2)
