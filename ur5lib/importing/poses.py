"""The arm and the order of the joints by a recorded pose: whose flange is at its position."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ur5lib.recordings.readings import Order
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array

FITS = 0.004  # m; a calibrated arm misses its nominal kinematics by less
WORSE = 3.0  # times the distance of the best; readings farther away are excluded
MOST = 12  # postures that are compared


class Placed(NamedTuple):
    """A reading, and the root mean square distance [m] of its flange from the recorded pose."""

    arm: str
    order: Order
    miss: float


def placed(
    q: Array, position: Array, arms: Sequence[Robot], orders: Sequence[Order]
) -> tuple[list[Placed], bool]:
    """Return the readings, the best first, and whether the pose is that of the flange.

    q: (N, 6) [rad], columns as in the file; position: (N, 3) [m], in the base frame. Otherwise, the
    pose is taken as that of a tool with a constant offset from the flange.
    """
    rows = np.unique(np.linspace(0, len(q) - 1, MOST).astype(int))
    bare = _misses(q[rows], position[rows], arms, orders, tool=False)
    if bare[0].miss < FITS:
        return bare, True
    return _misses(q[rows], position[rows], arms, orders, tool=True), False


def fitting(readings: Sequence[Placed]) -> list[Placed]:
    """Return the readings about as good as the best; none if even that does not fit."""
    best = readings[0].miss
    return [] if best > FITS else [each for each in readings if each.miss <= WORSE * best + 1e-4]


def _misses(
    q: Array, position: Array, arms: Sequence[Robot], orders: Sequence[Order], tool: bool
) -> list[Placed]:
    poses = []
    for arm in arms:
        postures = q[:, np.array(orders)].swapaxes(0, 1)
        rotation, origin = link_frames(arm, postures.reshape(-1, 6))
        away = position - origin[:, 6].reshape(*postures.shape[:2], 3)
        if tool:
            turned = np.einsum(
                "knij,kni->knj", rotation[:, 6].reshape(*postures.shape[:2], 3, 3), away
            )
            away = turned - turned.mean(axis=1, keepdims=True)
        miss = np.sqrt((away**2).sum(axis=2).mean(axis=1))
        poses += [Placed(arm.name, order, float(m)) for order, m in zip(orders, miss, strict=True)]
    return sorted(poses, key=lambda pose: pose.miss)
