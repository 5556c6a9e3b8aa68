"""Detection of cells that a file lost: where nothing was written, arrays read as zeros."""

import numpy as np
import pandas as pd

from ur5lib.recordings.quality import Finding
from ur5lib.timeseries.arrays import Array, Labels, Mask

FAR = 5.0  # times the largest usual step; a value that falls to zero by more was not received
USUAL = 0.99  # quantile of a column's steps that is still usual
NOISY = "actual_current_"  # channels that are never zero for long while other joints' are not
SLOW = 0.1  # rad/s; drivers round smaller velocities to zero
LONG, POWERED = 5, 50  # rows
SMALLEST = (
    1e-50  # in any unit; single precision ends at 1e-45, what is nearer to zero is stray bytes
)


def drop_zeroed(table: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Return a table with NaN where a column falls to exactly zero at once, or a current is zero
    while those of other joints are not.
    """
    values = table.to_numpy(float)
    stray = (values != 0.0) & (np.abs(values) < SMALLEST)
    fallen = [_fallen(values[:, k], _least(name)) for k, name in enumerate(table)]
    wrong = stray | np.stack(fallen, axis=1)
    noisy = [k for k, name in enumerate(table) if name.startswith(NOISY)]
    if noisy:
        wrong[:, noisy] |= _dead(values[:, noisy])
    if not wrong.any():
        return table
    count = int(wrong.any(axis=1).sum())
    findings.append(Finding("robot", "zeroed cells", "warning", count))
    return table.mask(wrong)


def _least(name: str) -> float:
    """Return the smallest leap of a channel; slow joints have velocities of exactly zero."""
    return SLOW if "_qd_" in name else 0.0


def _fallen(column: Array, least: float) -> Mask:
    """Return which cells (N,) of a column lie in runs of zeros that begin or end in a leap."""
    zero = column == 0.0
    known = column[~zero & (np.abs(column) < np.sqrt(np.finfo(float).max))]
    steps = np.abs(np.diff(known))
    wrong = np.zeros(len(column), dtype=bool)
    if not zero.any() or not len(steps):
        return wrong
    leap = max(least, FAR * np.quantile(steps, USUAL))
    for start, end in _runs(zero):
        beside = [column[k] for k in (start - 1, end) if 0 <= k < len(column)]
        wrong[start:end] = np.nanmax(np.abs(beside)) > leap
    return wrong


def _dead(currents: Array) -> Mask:
    """Return which cells (N, k) lie in long runs of zeros of some joints, or short ones of all.

    An arm without power has zeros of all joints for long.
    """
    off = (currents == 0.0).all(axis=1)
    zero = (currents == 0.0) & ~off[:, None]
    wrong = np.zeros_like(zero)
    for start, end in _runs(off):
        wrong[start:end] = end - start < POWERED
    for joint, column in enumerate(zero.T):
        for start, end in _runs(column):
            wrong[start:end, joint] = end - start >= LONG and not column.all()
    return wrong


def _runs(flags: Mask) -> Labels:
    """Return where runs of True (n, 2) begin and end."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]])))
    return edges.reshape(-1, 2)
