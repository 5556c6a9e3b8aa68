"""Axes and sign of a wrench: those with which it explains the efforts."""

from typing import Any, NamedTuple

import numpy as np

from ur5lib.recordings.block_means import BLOCK, INDEPENDENT, BlockMeans, size
from ur5lib.recordings.readings import Order
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque, link_frames
from ur5lib.timeseries.arrays import Array

SURE = 6.0  # difference of log-likelihoods of independent samples that proves a frame


class Frame(NamedTuple):
    """Axes of a wrench (base or flange), and whether it is that of the arm on its surroundings."""

    axes: str
    by_arm: bool


def wrench_frame(
    means: BlockMeans, effort: str, wrench: Array, arm: Robot, order: Order
) -> tuple[Frame | None, float]:
    """Return the frame of a wrench, None if not proven, and its lead in log-likelihood.

    wrench: force and torque (M, 6) [N, Nm] at the blocks. Efforts increase with the wrench of the
    arm on its surroundings, and decrease with the wrench of the surroundings on the arm.
    """
    q = means.q[:, order]
    rotation, origin = link_frames(arm, q)
    axes, lever = rotation[:, :6, :, 2], origin[:, 6:] - origin[:, :6]
    jacobian = np.concatenate([np.cross(axes, lever), axes], axis=2)  # (M, 6 joints, 6)
    base = np.einsum("nji,ni->nj", jacobian, wrench)
    turned = np.concatenate(
        [np.einsum("nij,nj->ni", rotation[:, 6], part) for part in (wrench[:, :3], wrench[:, 3:])],
        axis=1,
    )
    flange = np.einsum("nji,ni->nj", jacobian, turned)
    torques = {Frame("base", True): base, Frame("base", False): -base}
    torques |= {Frame("flange", True): flange, Frame("flange", False): -flange}
    gains = {frame: _gain(means, effort, torque, arm, order) for frame, torque in torques.items()}
    best, second = sorted(gains, key=lambda frame: gains[frame], reverse=True)[:2]
    lead = gains[best] - gains[second]
    return (best if lead >= SURE else None), lead


def _gain(means: BlockMeans, effort: str, torque: Array, arm: Robot, order: Order) -> float:
    """Return the log-likelihood that torques (M, 6) [Nm] add to a model of the efforts."""
    gravity = gravity_torque(arm, arm.chosen_model, means.q[:, order])
    total = 0.0
    for joint, column in enumerate(order):
        measured = means.currents[effort][:, column]
        terms = [gravity[:, joint], *means.friction(column).T, *means.qdd.T, np.ones(len(measured))]
        without = _solved(np.column_stack(terms), measured)[1]
        solution, left = _solved(np.column_stack([*terms, torque[:, joint]]), measured)
        if solution[-1] > 0:
            total += _independent(left) * np.log(size(without) / size(left))
    return float(total)


def _independent(error: Array) -> float:
    """Return the number of independent samples in correlated errors (M,), by an AR(1)."""
    rho = float(np.clip(error[1:] @ error[:-1] / size(error) ** 2, 0.0, 1.0))
    return len(error) * min(BLOCK / INDEPENDENT, (1 - rho) / (1 + rho))


def _solved(columns: Any, values: Any) -> tuple[Array, Array]:
    """Return the coefficients of least squares, and the residuals."""
    solution = np.linalg.lstsq(columns, values, rcond=None)[0]
    return solution, np.asarray(values - columns @ solution)
