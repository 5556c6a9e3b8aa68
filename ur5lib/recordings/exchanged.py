"""Detection of targets and measurements that were exchanged.

Targets are computed: the derivative of `target_q` is `target_qd`, and `target_current` is smooth.
Measurements contain noise.
"""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ur5lib.recordings.quality import Finding, contradiction
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Mask

MOVES = 0.05  # rad/s; slower joints say nothing about their velocities
FEWEST = 20  # frames
CLOSER = 0.5  # a pair closer by this factor than the targets; in right recordings, none is by 0.95
SMOOTHER = 0.3  # actual_current is at least 15 times as rough as target_current in right recordings
EXCHANGED = {  # which quantities are exchanged, by the pair that fits like targets
    ("actual_q", "target_qd"): ("q",),
    ("target_q", "actual_qd"): ("qd",),
    ("actual_q", "actual_qd"): ("q", "qd"),
}


def exchanged_channels(robot: pd.DataFrame) -> Iterator[Finding]:
    """Find targets and measurements of a repaired robot table that are exchanged."""
    for name in [*_motion(robot), *_current(robot)]:
        yield contradiction("exchanged channels", name=name)


def _received(robot: pd.DataFrame, name: str) -> Array:
    """Return a channel of the frames that were received."""
    return channel(robot, name)[~robot["interpolated"].to_numpy()]


def _motion(robot: pd.DataFrame) -> tuple[str, ...]:
    """Return which of q and qd are exchanged: another pair is closer than that of the targets."""
    names = [f"{kind}_{name}_0" for kind in ("actual", "target") for name in ("q", "qd")]
    if not {*names} <= {*robot}:
        return ()
    measured, target = (np.abs(_received(robot, f"{kind}_qd")) for kind in ("actual", "target"))
    moves = (measured > MOVES) & (target > MOVES)
    moving = moves.sum(axis=0) >= FEWEST
    if not moving.any():
        return ()
    own = _apart(robot, moves, "target_q", "target_qd")[moving]
    others = {pair: _apart(robot, moves, *pair)[moving] for pair in EXCHANGED}
    best = min(others, key=lambda pair: float(np.median(others[pair])))
    return EXCHANGED[best] if np.mean(others[best] < CLOSER * own) > 0.5 else ()


def _apart(robot: pd.DataFrame, moves: Mask, position: str, velocity: str) -> Array:
    """Return the median difference (6,) [rad/s] between a position's slope and a velocity.

    moves: (N, 6), the frames that count; NaN for joints without any.
    """
    step = np.diff(robot["time"].to_numpy()[~robot["interpolated"].to_numpy()])[:, None]
    rate = _received(robot, velocity)
    slope = np.diff(_received(robot, position), axis=0) / step
    apart = np.where(moves[1:], np.abs(slope - (rate[1:] + rate[:-1]) / 2), np.nan)
    apart[:, ~moves[1:].any(axis=0)] = 0.0
    return np.asarray(np.nanmedian(apart, axis=0))


def _current(robot: pd.DataFrame) -> Iterator[str]:
    if {"actual_current_0", "target_current_0"} <= {*robot}:
        kinds = ("actual", "target")
        measured, target = (roughness(_received(robot, f"{kind}_current")) for kind in kinds)
        known = (measured > 0) | (target > 0)
        if known.any() and np.mean(measured[known] < SMOOTHER * target[known]) > 0.5:
            yield "current"


def roughness(values: Array) -> Array:
    """Return the median size (6,) of third differences of (N, 6): noise more than motion."""
    return np.asarray(np.nanmedian(np.abs(np.diff(values, 3, axis=0)), axis=0))
