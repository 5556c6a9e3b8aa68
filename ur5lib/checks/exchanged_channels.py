"""Checks of measured channels against their targets: whether they are exchanged, or simulated."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from ur5lib.checks.channels import MIN_MOVING_SPEED, are_recorded
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array, Mask

MIN_MOVING_FRAMES = 20  # channels of a joint are compared if it moves in this many frames
# A pair of channels is exchanged if it is closer by this factor than the targets. In right
# recordings, none is by 0.95.
MAX_DEVIATION_RATIO = 0.5
# In right recordings, actual_current is at least 15 times as rough as target_current.
MAX_ROUGHNESS_RATIO = 0.3
# Share of changing values that equal their targets. In right recordings, it is 0.002 at most.
MIN_SHARE_EQUAL = 0.5
EXCHANGED_QUANTITIES = {  # which quantities are exchanged, by the pair that fits like targets
    ("actual_q", "target_qd"): ("q",),
    ("target_q", "actual_qd"): ("qd",),
    ("actual_q", "actual_qd"): ("q", "qd"),
}


def names_equal_to_targets(robot: pd.DataFrame, step: float) -> Iterator[str]:
    """Yield the measured channels that equal their targets to the last bit: positions of moving
    joints, and currents.

    At rest, coarse positions of a real arm may do so. step: between frames [s].
    """
    for name, least in (("q", MIN_MOVING_SPEED * step), ("current", 0.0)):
        if are_recorded(robot, f"actual_{name}", f"target_{name}"):
            actual, target = _measured(robot, f"actual_{name}", f"target_{name}")
            changes = (np.abs(np.diff(target, axis=0)) > least) & (target[1:] != 0)
            equal = (actual == target)[1:][changes]
            if len(equal) >= MIN_MOVING_FRAMES and np.mean(equal) > MIN_SHARE_EQUAL:
                yield f"actual_{name}"


def exchanged_motion(robot: pd.DataFrame) -> tuple[str, ...]:
    """Return which of q and qd have measured and target channel exchanged: a pair of position and
    velocity that is not that of the targets fits together far better.
    """
    if not are_recorded(robot, "actual_q", "actual_qd", "target_q", "target_qd"):
        return ()
    measured, target = (np.abs(_received(robot, f"{kind}_qd")) for kind in ("actual", "target"))
    moves = (measured > MIN_MOVING_SPEED) & (target > MIN_MOVING_SPEED)
    moving = moves.sum(axis=0) >= MIN_MOVING_FRAMES
    if not moving.any():
        return ()
    of_targets = _median_deviation(robot, moves, "target_q", "target_qd")[moving]
    others = {pair: _median_deviation(robot, moves, *pair)[moving] for pair in EXCHANGED_QUANTITIES}
    best = min(others, key=lambda pair: float(np.median(others[pair])))
    closer = others[best] < MAX_DEVIATION_RATIO * of_targets
    return EXCHANGED_QUANTITIES[best] if np.mean(closer) > 0.5 else ()


def exchanged_current(robot: pd.DataFrame) -> Iterator[str]:
    """Yield "current" if the measured currents are smoother than their targets, as if exchanged."""
    if are_recorded(robot, "actual_current", "target_current"):
        samples = _measured(robot, "actual_current", "target_current")
        measured, target = map(roughness, samples)
        varies = (measured > 0) | (target > 0)
        if varies.any() and np.mean(measured[varies] < MAX_ROUGHNESS_RATIO * target[varies]) > 0.5:
            yield "current"


def roughness(values: Array) -> Array:
    """Return the median size (6,) of third differences of (N, 6), noise more than motion; NaN of
    fewer than four samples.
    """
    if len(values) < 4:
        return np.full(values.shape[1], np.nan)
    return np.asarray(np.nanmedian(np.abs(np.diff(values, 3, axis=0)), axis=0))


def _median_deviation(robot: pd.DataFrame, moves: Mask, position: str, velocity: str) -> Array:
    """Return the median difference (n,) [rad/s] between a position's slope and a velocity.

    moves: (N, n), the frames that count; zero for joints without any.
    """
    step = np.diff(robot["time"].to_numpy()[~robot["interpolated"].to_numpy()])[:, None]
    rate = _received(robot, velocity)
    slope = np.diff(_received(robot, position), axis=0) / step
    apart = np.where(moves[1:], np.abs(slope - (rate[1:] + rate[:-1]) / 2), np.nan)
    apart[:, ~moves[1:].any(axis=0)] = 0.0
    return np.asarray(np.nanmedian(apart, axis=0))


def _measured(robot: pd.DataFrame, *names: str) -> list[Array]:
    """Return channels in the frames in which all of them were received, without filled ones."""
    flags = [flag for name in names if (flag := f"filled_{name}") in robot]
    frames = robot[~robot[["interpolated", *flags]].any(axis=1)]
    return [channel(frames, name) for name in names]


def _received(robot: pd.DataFrame, name: str) -> Array:
    """Return a channel of the frames that were received."""
    return channel(robot, name)[~robot["interpolated"].to_numpy()]
