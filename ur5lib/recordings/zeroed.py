"""Detection of cells that a file lost: where nothing was written, arrays read as zeros."""

import numpy as np
import pandas as pd

from ur5lib.recordings.quality import Finding
from ur5lib.timeseries.arrays import Array, Mask

FAR = 5.0  # times the largest usual step; a value that falls to zero by more was not received
USUAL = 0.99  # quantile of a column's steps that is still usual


def drop_zeroed(table: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Return a table with NaN where a column falls to exactly zero at once, and returns as fast."""
    wrong = np.stack([_zeroed(column) for column in table.to_numpy(float).T], axis=1)
    if not wrong.any():
        return table
    detail = "values fall to exactly zero at once, as where a file lost a block; not used"
    count = int(wrong.any(axis=1).sum())
    findings.append(Finding("robot", "zeroed cells", "warning", count, detail))
    return table.mask(wrong)


def _zeroed(column: Array) -> Mask:
    """Return which cells (N,) of a column lie in runs of zeros that begin or end in a leap."""
    zero = column == 0.0
    steps = np.abs(np.diff(column[~zero]))
    wrong = np.zeros(len(column), dtype=bool)
    if not zero.any() or not len(steps):
        return wrong
    leap = FAR * np.nanquantile(steps, USUAL)
    edges = np.flatnonzero(np.diff(np.concatenate([[False], zero, [False]])))
    for start, end in edges.reshape(-1, 2):
        beside = [column[k] for k in (start - 1, end) if 0 <= k < len(column)]
        wrong[start:end] = bool(beside) and max(np.abs(beside)) > leap
    return wrong
