"""In which frame a wrench is: the one by which it explains the efforts."""

from typing import Any

import numpy as np

from ur5lib.recordings.block_means import BlockMeans, size
from ur5lib.recordings.readings import SURE, Order
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import gravity_torque, link_frames
from ur5lib.timeseries.arrays import Array


def wrench_frame(
    means: BlockMeans, effort: str, wrench: Array, arm: Robot, order: Order
) -> tuple[str | None, float]:
    """Return base or flange, None where neither is proven, and the difference to the next best.

    wrench: force and torque (M, 6) at the blocks. Both axes are tried with both signs. A wrench in
    the base's axes must be that of the arm on its surroundings, which takes from the efforts, and
    one in the flange's that of these on the arm: only so can a study name them.
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
    torques = {("base", "arm"): base, ("base", "world"): -base}
    torques |= {("flange", "arm"): flange, ("flange", "world"): -flange}
    gains = {name: _gain(means, effort, torque, arm, order) for name, torque in torques.items()}
    best, second = sorted(gains, key=lambda name: gains[name], reverse=True)[:2]
    apart = gains[best] - gains[second]
    usable = best in (("base", "arm"), ("flange", "world"))
    return (best[0] if usable and apart > SURE else None), apart


def _gain(means: BlockMeans, effort: str, torque: Array, arm: Robot, order: Order) -> float:
    """Return the log-likelihood that torques (M, 6) [Nm] add to what explains the efforts."""
    gravity = gravity_torque(arm, arm.chosen_model, means.q[:, order])
    total = 0.0
    for joint, column in enumerate(order):
        own = means.currents[effort][:, column]
        columns = [gravity[:, joint], *means.friction(column).T, *means.qdd.T, np.ones(len(own))]
        without = _solved(np.column_stack(columns), own)[1]
        solution, left = _solved(np.column_stack([*columns, torque[:, joint]]), own)
        if solution[-1] > 0:
            total += float(means.log_likelihood(np.square(left / without)))
    return total


def _solved(columns: Any, values: Any) -> tuple[Array, float]:
    solution = np.linalg.lstsq(columns, values, rcond=None)[0]
    return solution, size(values - columns @ solution)
