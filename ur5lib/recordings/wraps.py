"""Angles that wrap around by a whole turn, as at 360° or ±π, made continuous."""

import re

import numpy as np
import pandas as pd

from ur5lib.records.codes import Found
from ur5lib.records.phrases import numbered
from ur5lib.records.quality import Finding, add_finding
from ur5lib.timeseries.arrays import Array, Labels, Mask

TURN = 2 * np.pi  # rad
# All in turns, between rows that were received.
MAX_MOTION = 0.25  # at a wrap, by which its jump differs from a turn
MAX_SMOOTH_STEP = 0.125  # to the rows around a wrap
TOLERANCE = 0.005  # share of the motion at a wrap, in addition to what the rows around it move
MAX_SPREAD = 1.002  # of an angle that wraps, without a few damaged rows
MAX_SHARE_DAMAGED = 0.005  # of the rows, to either side
MIN_SHARE_SMOOTH = 0.95  # of the steps; postures leap from row to row
ANGLE = re.compile(r"(actual|target)_q_(\d+)")


def without_wraps(table: pd.DataFrame) -> tuple[pd.DataFrame, list[Finding]]:
    """Return a robot's table with positions and targets made continuous, and a note on those that
    wrapped.

    They begin in the turn nearest to zero, or in that of a target that does not wrap; targets are
    in the turn of the positions.
    """
    time, findings = table["time"].to_numpy(float), list[Finding]()
    angles = {name: table[name].to_numpy(float) for name in table if ANGLE.fullmatch(name)}
    whole = {name: unwrapped(angle, time) for name, angle in angles.items()}
    wraps = {name: count for name, (_, count) in whole.items() if count}
    for name in sorted(wraps):  # actual_q first
        kind, joint = ANGLE.fullmatch(name).groups()  # type: ignore[union-attr]
        other = f"{'target' if kind == 'actual' else 'actual'}_q_{joint}"
        angle = whole[name][0]
        if other in table and (kind == "target" or other not in wraps):
            angle = _in_the_turn_of(table[other].to_numpy(float), angle)
        table = table.assign(**{name: angle})
    joints = sorted({int(name.rpartition("_")[2]) + 1 for name in wraps})
    detail = f"angles that wrap around by a whole turn, of {numbered(joints)}; made continuous"
    add_finding(findings, "robot", Found.WRAPPED_ANGLES, "note", sum(wraps.values()), detail)
    return table, findings


def unwrapped(angle: Array, time: Array, turn: float = TURN) -> tuple[Array, int]:
    """Return an angle (N,) made continuous, and how often it wrapped.

    time: (N,) [s]; turn: one whole turn in the angle's unit. An angle that wraps begins in the turn
    nearest to zero; any other is returned as it is.
    """
    known = np.flatnonzero(np.isfinite(angle))
    turns = angle[known] / turn
    wraps = _wraps(turns, time[known])
    if not wraps.any():
        return angle, 0
    added = -np.cumsum(np.append(0.0, np.where(wraps, np.rint(np.diff(turns)), 0.0)))
    whole = angle.astype(float)
    whole[known] += turn * (added - np.rint(turns[0]))
    return whole, int(wraps.sum())


def _wraps(turns: Array, time: Array) -> Mask:
    """Return at which steps (N - 1,) an angle [turns] wraps.

    At a wrap, it jumps by a turn less the motion from row to row before and after.
    """
    step = np.diff(turns)
    size = np.abs(step)
    far, smooth = (size >= 1 - MAX_MOTION) & (size <= 1 + MAX_MOTION), size <= MAX_SMOOTH_STEP
    nowhere = np.zeros(len(step), bool)
    if not far.any() or far.all() or np.mean(smooth | far) < MIN_SHARE_SMOOTH:
        return nowhere
    if np.ptp(np.quantile(turns, [MAX_SHARE_DAMAGED, 1 - MAX_SHARE_DAMAGED])) > MAX_SPREAD:
        return nowhere
    length = _lengths(time)
    before, after = _nearest(~far)
    paces = step[before] / length[before], step[after] / length[after]
    moved, most = length * np.mean(paces, axis=0), length * np.abs(paces).max(axis=0)
    rest = step - np.rint(step)
    beside = smooth[before] & smooth[after]
    proven = far & beside & (np.abs(rest - moved) <= TOLERANCE + most)
    # of an angle that wraps, a single jump by more than half a turn, as over lost rows, is one too
    single = beside & (after - before == 2) & (size > 0.5) & (size <= 1 + MAX_MOTION)
    return proven | (single & proven.any())


def _lengths(time: Array) -> Array:
    """Return the steps between times (N,) in multiples of the usual step (N - 1,), at least one."""
    steps = np.diff(time)
    forward = steps[steps > 0]
    usual = float(np.median(forward)) if len(forward) else 1.0
    return np.fmax(steps / usual, 1.0)


def _nearest(wanted: Mask) -> tuple[Labels, Labels]:
    """Return, for each place, the nearest wanted places before and after it (N,); at an end, the
    same one twice.
    """
    places, every = np.flatnonzero(wanted), np.arange(len(wanted))
    before = np.searchsorted(places, every) - 1
    after = np.minimum(np.searchsorted(places, every, side="right"), len(places) - 1)
    return places[np.where(before < 0, after, before)], places[after]


def _in_the_turn_of(beside: Array, angle: Array) -> Array:
    """Return an angle (N,) [rad] shifted by whole turns to be as near as possible to another one
    (N,).
    """
    both = np.isfinite(beside) & np.isfinite(angle)
    away = np.median(beside[both] - angle[both]) if both.any() else 0.0
    return angle + TURN * np.rint(away / TURN)
