"""An arm under one of its link models: arrays in, arrays out."""

from functools import partial

import numpy as np
import torch

from ur5lib.dynamics import rigid_body
from ur5lib.dynamics.arm import PullBack, build_arm, with_pull_back
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import link_tail
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import in_chunks


class LinkModel:
    """Rigid-body dynamics of an arm under one of its link models.

    q, qd, qdd are arrays (N, n) [rad, rad/s, rad/s²]; torques are (N, n) [Nm]. Raises KeyError
    where the arm has no link model of this name.
    """

    def __init__(self, robot: Robot, model: str) -> None:
        """Build the arm's tensors; see `build_arm`."""
        self.arm = build_arm(robot, model)

    @property
    def parameters(self) -> Array:
        """Return the inertial parameters π (11 n,) of τ = Y π."""
        return self.arm.parameters.numpy()

    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return τ = D(q) q̈ + C(q, q̇) q̇ + g(q)."""
        return rigid_body.inverse_dynamics(self.arm, *map(torch.from_numpy, (q, qd, qdd))).numpy()

    def regressor(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return Y (N, n, 11 n) of τ = Y π."""
        return rigid_body.regressor(self.arm, *map(torch.from_numpy, (q, qd, qdd))).numpy()

    def differentiable_regressor(self, q: Array, qd: Array, qdd: Array) -> tuple[Array, PullBack]:
        """Return Y (N, n, 11 n) of τ = Y π, and the pull-back of its derivative by q, qd, qdd."""
        return with_pull_back(partial(rigid_body.regressor, self.arm), q, qd, qdd)

    def momentum(self, q: Array, qd: Array) -> Array:
        """Return the generalised momentum p = D(q) q̇ (N, n) [Nm s]."""

        def product(q: Array, qd: Array) -> Array:
            return np.matvec(rigid_body.inertia_matrix(self.arm, torch.from_numpy(q)).numpy(), qd)

        return in_chunks(product, q, qd)

    def coriolis_torque(self, q: Array, qd: Array) -> Array:
        """Return Cᵀ(q, q̇) q̇ (N, n) [Nm], a term of the momentum's rate: ṗ = τ + Cᵀ q̇ - g."""

        def product(q: Array, qd: Array) -> Array:
            matrix = rigid_body.coriolis_matrix(self.arm, *map(torch.from_numpy, (q, qd)))
            return np.matvec(matrix.mT.numpy(), qd)

        return in_chunks(product, q, qd)

    def gravity_torque(self, q: Array) -> Array:
        """Return g(q)."""
        return rigid_body.gravity_torque(self.arm, torch.from_numpy(q)).numpy()


def load_regressor(robot: Robot, model: str, q: Array, qd: Array, qdd: Array) -> Array:
    """Return the torque (N, n, 4) per mass [kg] and first moments [kg m] of a load in frame n.

    robot: under the recording's gravity. In Y of τ = Y π, (N, n, 11 n), the moments h of link n are
    about its joint: h = m t + R h_n, with R, t the constant transform from there to frame n.
    """
    poses = robot.link_poses()
    rotation, tail = link_tail(poses[-1])
    last = 10 * (len(poses) - 1)  # its mass in π, then its first moments
    arm = LinkModel(robot, model)

    def per_load(*motion: Array) -> Array:
        mass, moments = np.split(arm.regressor(*motion)[:, :, last : last + 4], [1], axis=2)
        return np.concatenate([mass + moments @ tail[:, None], moments @ rotation], axis=2)

    return in_chunks(per_load, q, qd, qdd)
