"""Checks to which joint's motion a current belongs, by how both change from frame to frame.

A servo answers each small disturbance of its own joint, also of joints that rest or move alike.
Therefore, the innovations of a current, which its own past does not predict, follow from the
changes of its own joint's position and velocity more than from those of any other's.
"""

import numpy as np
import pandas as pd

from ur5lib.channels import Effort
from ur5lib.checks.block_means import SMALLEST_SIZE
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Labels, Mask

# Frames with longer steps [s] show the motion of all joints more than disturbances.
MAX_STEP = 0.02
# Share of frames with currents that differ from the previous ones. With fewer, currents are
# repeated.
MIN_SHARE_FRESH = 0.9
# Share of the currents' changes that is new. It is 0.5 to 1 as recorded, 0.2 if smoothed.
MIN_SHARE_NEW = 0.3
MIN_FRAMES, MAX_FRAMES = 100, 20_000  # frames that are looked at
PREDICTOR_ORDER = 3  # this many frames predict a current
# Frames before and after, within which a current answers a motion, and a motion a current.
RESPONSE_FRAMES = 2
DECORRELATION_FRAMES = 2  # frames between innovations that count as independent
# Quantiles of changes. Larger ones are jumps of all channels at once.
JUMP_QUANTILES = (0.005, 0.995)
RIDGE = 1e-6  # relative to the motions' unit size, it regularises motions that are nil or alike


def innovation_likelihoods(robot: pd.DataFrame, step: float, shifts: Labels) -> Array:
    """Return the log-likelihoods (S, 6, 6) of currents by the joints' motions, for each of the
    shifts (S,) by which the currents are late [frames].

    Row j: the current of joint j; column k: what the motion of joint k explains of it beyond that
    of the other joints. Zero where the currents show nothing. robot: a repaired table with
    positions and currents; step: between its frames [s].
    """
    most = max(RESPONSE_FRAMES, *np.abs(shifts))
    rows = np.flatnonzero(_received(robot)[most : len(robot) - most]) + most
    rows = rows[:: 1 + len(rows) // MAX_FRAMES]
    changes = _changes(channel(robot, Effort.measured_in(robot).channel))
    count = changes.shape[1]
    innovations = _innovations(changes)
    too_few = len(rows) < MIN_FRAMES or step > MAX_STEP
    if too_few or not _as_sampled(changes[rows], innovations[rows]):
        return np.zeros((len(shifts), count, count))
    q = channel(robot, "actual_q")
    qd = channel(robot, "actual_qd") if "actual_qd_0" in robot else np.gradient(q, axis=0)
    near = _near(np.stack([_changes(q), _changes(qd)], axis=2), rows)
    late = np.concatenate([innovations[rows + shift] for shift in shifts], axis=1)  # (n, 6 S)
    gains = _gains(near, late, count).reshape(count, len(shifts), count).transpose(1, 2, 0)
    return len(rows) / DECORRELATION_FRAMES / 2 * gains


def _as_sampled(changes: Array, innovations: Array) -> bool:
    """Return whether currents with these changes and innovations (n, 6) are neither repeated nor
    smoothed.
    """
    fresh = (changes != 0).any(axis=1).mean()
    new = np.mean(innovations.var(axis=0) / (changes.var(axis=0) + SMALLEST_SIZE))
    return bool(fresh > MIN_SHARE_FRESH and new > MIN_SHARE_NEW)


def _received(robot: pd.DataFrame) -> Mask:
    """Return which frames were received together with the frame before."""
    whole = ~robot["interpolated"].to_numpy(bool)
    whole[1:] &= whole[:-1] & (np.diff(robot["segment"]) == 0)
    return whole


def _changes(values: Array) -> Array:
    """Return the changes of (N, 6) since the previous frame, without jumps; zero if unknown."""
    changes = np.nan_to_num(np.diff(values, axis=0, prepend=values[:1]))
    return np.asarray(np.clip(changes, *np.quantile(changes, JUMP_QUANTILES, axis=0)))


def _innovations(changes: Array) -> Array:
    """Return the part of each column (N, 6) that its own past does not predict."""
    past = np.stack([np.roll(changes, k, axis=0) for k in range(1, PREDICTOR_ORDER + 1)], axis=2)
    coefficients = [
        np.linalg.lstsq(past[:, j], changes[:, j], rcond=None)[0] for j in range(changes.shape[1])
    ]
    return np.asarray(changes - np.einsum("njk,jk->nj", past, coefficients))


def _near(motion: Array, rows: Labels) -> Array:
    """Return the motions (N, 6, 2) in the frames around each of n rows as columns (n, m), joint
    after joint, each of mean zero and unit size.
    """
    frames = np.arange(-RESPONSE_FRAMES, RESPONSE_FRAMES + 1)
    windows = motion[rows[:, None] + frames]  # (n, frames, 6, 2)
    near = windows.swapaxes(1, 2).reshape(len(rows), -1)
    near = near - near.mean(axis=0)
    return np.asarray(near / (np.linalg.norm(near, axis=0) + SMALLEST_SIZE))


def _gains(near: Array, innovations: Array, joints: int) -> Array:
    """Return ln(1 + F) (k, c) of what each of k joints explains of c currents beyond the others.

    near: motions (n, m), joint after joint; innovations: (n, c) of the currents. F: share by which
    the sum of squares that all joints leave grows without this joint; a Wald test by the inverse of
    the Gram matrix. Where motion and noise grow together, as of an arm that rests for a while,
    chance explains more: F is divided by the mean of the product of their squares over the product
    of the means.
    """
    inverse = np.linalg.inv(near.T @ near + RIDGE * np.eye(near.shape[1]))
    products = near.T @ innovations
    solution = inverse @ products
    squares = (innovations - near @ solution) ** 2
    left = squares.sum(axis=0) + SMALLEST_SIZE
    of_joints, size = solution.reshape(joints, -1, innovations.shape[1]), len(inverse) // joints
    every = range(joints)
    blocks = inverse.reshape(joints, size, joints, size)[every, :, every]  # of each joint's own
    beyond = np.linalg.solve(blocks, of_joints)
    moves = (near**2).reshape(len(near), joints, -1).mean(axis=2)
    together = len(near) * moves.T @ squares / left
    return np.asarray(np.log1p((of_joints * beyond).sum(axis=1) / left / np.maximum(together, 1)))
