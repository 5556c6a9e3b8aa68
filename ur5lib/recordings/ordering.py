"""Frames in the order the controller sent them, each once."""

import numpy as np
import pandas as pd

from ur5lib.recordings.quality import Device, Finding

RESET_RUN = 50  # frames that must follow a jump back in time to be a reset of the clock


def in_order(frames: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Frames by time, without repeats, with the `epoch` that a reset of the clock begins.

    A frame that only repeats the one before, or its data under a new stamp, holds nothing new and
    is left out; new data under an old stamp are kept for the next slot (their stamp is nudged).
    """
    frames = drop_repeats(frames, "robot", findings)
    epoch = epochs(frames["time"].to_numpy())
    if epoch.max() > 0:
        detail = "the controller's time starts again; the recording is split there"
        findings.append(Finding("robot", "clock reset", "warning", int(epoch.max()), detail))
    ordered = frames.assign(epoch=epoch)
    backwards = int((frames["time"].diff() < 0).sum()) - int(epoch.max())
    if backwards > 0:
        detail = "frames come after later ones; they are put in order"
        findings.append(Finding("robot", "frames out of order", "note", backwards, detail))
        ordered = ordered.sort_values(["epoch", "time"], kind="stable", ignore_index=True)
    ordered = _nudge_stale_stamps(ordered, findings)
    return _drop_stale_data(ordered, findings)


def epochs(time: np.ndarray) -> np.ndarray:
    """How often the clock was reset before each frame (N,)."""
    starts = np.flatnonzero(np.diff(time) < 0) + 1
    bounds = np.concatenate([[0], starts, [len(time)]])
    reset = np.zeros(len(time), dtype=int)
    if len(starts) and np.diff(bounds).min() >= RESET_RUN:
        before = time[bounds[:-2]], time[starts - 1]
        reset[starts] = (time[starts] <= before[0]) | (time[starts + RESET_RUN - 1] < before[1])
    return np.cumsum(reset)  # shorter runs are frames out of order, not a clock that starts again


def drop_repeats(frames: pd.DataFrame, device: Device, findings: list[Finding]) -> pd.DataFrame:
    """Frames without those that repeat another, stamp and all."""
    if frames["time"].is_unique:  # quick to tell, and the rule
        return frames
    time = frames["time"].to_numpy()
    repeated = frames.duplicated()
    if epochs(time[~repeated]).max() > 0:  # a clock that starts again may tell the same anew
        repeated = frames.assign(epoch=epochs(time)).duplicated()
    if repeated.any():
        detail = "rows that say again what was said, left out"
        findings.append(Finding(device, "repeated frames", "note", int(repeated.sum()), detail))
    return frames[~repeated].reset_index(drop=True)


def _nudge_stale_stamps(frames: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """New data whose stamp came before are kept under a later one."""
    stale = frames.duplicated(["epoch", "time"])
    if not stale.any():
        return frames
    detail = "new data under an old stamp; they are put into the next slot"
    findings.append(Finding("robot", "stale stamps", "warning", int(stale.sum()), detail))
    cycle = frames["time"].diff().loc[lambda step: step > 0].median()
    frames = frames.assign(time=frames["time"] + cycle * stale)
    return frames.sort_values(["epoch", "time"], kind="stable", ignore_index=True)


def _drop_stale_data(frames: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Frames whose data are those of the frame before, noise of the currents included."""
    currents = frames.filter(like="actual_current_").columns
    if currents.empty:
        return frames  # without noise, an arm at rest says the same again and again
    channels = frames.columns.difference(["time", "epoch", "received"])
    same = (frames[channels].diff() == 0).all(axis="columns")
    noisy = (frames[currents].diff().abs() > 0).any(axis="columns").mean() > 0.9
    if not (same.any() and noisy):
        return frames
    detail = "the data of the frame before under a new stamp; taken as lost frames"
    findings.append(Finding("robot", "stale data", "warning", int(same.sum()), detail))
    return frames[~same].reset_index(drop=True)
