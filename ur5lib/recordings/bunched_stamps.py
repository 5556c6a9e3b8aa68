"""Rows that share a stamp, as of whole seconds, or arrive in bursts, put at equal steps.

A clock of whole seconds gives many rows one stamp; a network's buffer delivers many at once. Rows
that a controller sends at equal steps lie on the line below such stamps.
"""

import numpy as np
import pandas as pd

from ur5lib.channels import JOINT_COLUMNS
from ur5lib.recordings.host_clock import MIN_STAMPS, least_delayed
from ur5lib.recordings.ordering import epochs
from ur5lib.recordings.plausibility import MIN_STEP
from ur5lib.records.codes import Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, add_finding
from ur5lib.timeseries.arrays import Array, Labels, Mask

MIN_SHARE_CLOSE = 0.3  # of steps that are shorter than any log's; pairs of rows have half
MAX_CLOSE_STEP = 1.1 * MIN_STEP  # s, and what stamps are rounded by
MIN_MEAN_STEP = 5.0  # times the usual step of bunched rows
MIN_SHARE_NEW = 0.1  # of close rows with new data; a recorder that polls repeats the others
MAX_SHARE_BACK = 0.1  # of steps, on which a stamp is older than that of the row before
MIN_PAUSE = 1.5  # times the time that the larger of the bunches before and after it takes


def evenly_stamped(frames: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Return frames with `time` [s] at equal steps, if most rows have the stamp of the row before
    or follow it at once.

    Longer pauses between bunches stay. Frames are unchanged if most have a time of their own, or if
    close rows repeat the data of the row before.
    """
    time = frames["time"].to_numpy(float)
    close = close_rows(time)
    of_joints = [name for name in frames if name in JOINT_COLUMNS]
    if not close.any() or not are_new(frames[of_joints].to_numpy(float), close):
        return frames
    even = even_times(time, close)
    step = number(1000 * np.median(np.diff(even)), ".3g")
    detail = (
        "rows share the stamp of the row before, or follow it at once; put at equal steps of "
        f"{step} ms, so that single lost rows cannot be noticed"
    )
    add_finding(findings, "robot", Found.BUNCHED_STAMPS, "warning", close.sum(), detail)
    return frames.assign(time=even)


def close_rows(time: Array) -> Mask:
    """Return which steps (N - 1,) of stamps (N,) [s] are far shorter than a row takes; none if
    these are few.
    """
    steps = np.diff(_forward(time))
    return steps < _far_step(steps) if _are_bunched(steps) else np.zeros(len(steps), bool)


def even_times(time: Array, close: Mask) -> Array:
    """Return stamps (N,) [s] at equal steps between pauses; close: which steps (N - 1,) are in a
    bunch.
    """
    time = _forward(time)
    bunch = np.cumsum(np.append(False, ~close))
    return _on_lines(time, _stretches(time, bunch)[bunch])


def _forward(time: Array) -> Array:
    """Return stamps (N,) [s] that never go back, as of rows in the order of their receipt: a packet
    that was late has the stamp of the one that overtook it. Unchanged if a clock was reset, or if
    many stamps go back, or few follow at once: then rows are in another order.
    """
    steps = np.diff(time)
    if not len(steps) or np.mean(steps < 0) > MAX_SHARE_BACK or epochs(time)[-1] > 0:
        return time
    at_once = (steps >= 0) & (steps < min(MAX_CLOSE_STEP, _far_step(steps)))
    return np.maximum.accumulate(time) if at_once.mean() >= MIN_SHARE_CLOSE else time


def _are_bunched(steps: Array) -> bool:
    """Return whether many steps [s] are shorter than any log's, and others much longer."""
    if len(steps) < MIN_STAMPS or not (steps >= 0).all():
        return False
    close = steps < min(MAX_CLOSE_STEP, _far_step(steps))
    return float(np.mean(close)) >= MIN_SHARE_CLOSE and float(np.mean(steps)) >= MIN_STEP


def _far_step(steps: Array) -> float:
    """Return the step [s] from which on a row is no longer close to the one before."""
    return float(np.mean(steps)) / MIN_MEAN_STEP


def are_new(values: Array, close: Mask) -> bool:
    """Return whether rows (N, M) close to the row before contain other data; close: (N - 1,).

    A log that was polled too fast repeats them, one of several topics leaves cells empty.
    """
    changed = np.any(np.abs(np.diff(values, axis=0)) > 0, axis=1)
    return bool(np.mean(changed[close]) >= MIN_SHARE_NEW)


def _stretches(time: Array, bunch: Labels) -> Labels:
    """Return, for each bunch of rows (M,), the number of pauses before it. bunch: number of each
    row's bunch (N,).
    """
    begins = time[np.flatnonzero(np.diff(bunch, prepend=-1))]
    apart, sizes = np.diff(begins), np.bincount(bunch)
    larger = np.maximum(sizes[1:], sizes[:-1])
    pause = apart > MIN_PAUSE * larger * np.median(apart / sizes[1:])
    return np.cumsum(np.append(False, pause))


def _on_lines(time: Array, stretch: Array) -> Array:
    """Return times (N,) at equal steps, below the stamps of each part between pauses; stretch:
    number of the part (N,).
    """
    row = np.arange(len(time), dtype=float)
    longest = stretch == np.bincount(stretch).argmax()
    step = least_delayed(row[longest], time[longest]).slope
    late = pd.Series(time - step * row)
    return step * row + late.groupby(stretch).transform("min").to_numpy()
