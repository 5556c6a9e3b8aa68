"""Ordering of frames: as the controller sent them, each once."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pandas as pd

from ur5lib.channels import JOINT_COLUMNS
from ur5lib.records.codes import Found
from ur5lib.records.quality import Device, Finding, add_finding
from ur5lib.timeseries.arrays import Array, Labels, Mask

# A jump back in time that fewer frames follow is disorder, not a clock reset.
MIN_RESET_FRAMES = 50
MIN_TRAVEL = 1e-3  # rad a cycle, of all joints: ten times the noise of positions
MIN_FREE_CYCLES = 1.5  # cycles to the next stamp, from which on a slot between is free
MIN_LATENESS = 0.5  # of a cycle, by which a frame must be late on both sides


def in_order(frames: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Return the frames sorted by time, without repeats. `epoch` counts the clock's resets, after
    which the time continues.

    Frames that repeat the previous one, or only its data with a new timestamp, are discarded. New
    data with an old timestamp are moved to the next slot.
    """
    sent = ["time", *(name for name in frames if name in JOINT_COLUMNS)]
    frames = drop_repeats(frames, "robot", findings, sent)
    epoch = epochs(frames["time"].to_numpy())
    detail = (
        "the controller's clock restarts; the recording is split there and goes on one step later, "
        "since nothing tells how long the clock stood still"
    )
    add_finding(findings, "robot", Found.CLOCK_RESET, "warning", epoch.max(), detail)
    ordered = frames.assign(epoch=epoch)
    backwards = int((frames["time"].diff() < 0).sum()) - int(epoch.max())
    if backwards > 0:
        detail = "frames come after later ones; sorted by time"
        add_finding(findings, "robot", Found.FRAMES_OUT_OF_ORDER, "note", backwards, detail)
        ordered = ordered.sort_values(["epoch", "time"], kind="stable", ignore_index=True)
    ordered = _nudge_stale_stamps(ordered, findings)
    ordered = _return_lost_data(_drop_stale_data(ordered, findings), findings)
    time = continued(ordered["time"].to_numpy(), ordered["epoch"].to_numpy())
    return ordered.assign(time=time)


def epochs(time: np.ndarray) -> np.ndarray:
    """Return how often the clock was reset before each frame (N,)."""
    starts = np.flatnonzero(np.diff(time) < 0) + 1
    bounds = np.concatenate([[0], starts, [len(time)]])
    reset = np.zeros(len(time), dtype=int)
    if len(starts) and np.diff(bounds).min() >= MIN_RESET_FRAMES:
        before = time[bounds[:-2]], time[starts - 1]
        reset[starts] = (time[starts] <= before[0]) | (
            time[starts + MIN_RESET_FRAMES - 1] < before[1]
        )
    return np.cumsum(reset)  # shorter runs are frames out of order, not a clock reset


def continued(time: Array, epoch: Labels) -> Array:
    """Return timestamps (N,) [s] that continue by one usual step where the clock was reset.

    epoch: (N,), from `epochs`. How long the clock stopped is unknown.
    """
    if not epoch.any():
        return time
    steps, going_on = np.diff(time), time.copy()
    usual = np.median(steps[steps > 0])
    for before, after in pairwise(np.unique(epoch)):
        end = going_on[epoch == before].max()
        going_on[epoch == after] += end + usual - time[epoch == after].min()
    return going_on


def drop_repeats(
    frames: pd.DataFrame, device: Device, findings: list[Finding], sent: Sequence[str] = ()
) -> pd.DataFrame:
    """Return the frames without exact repeats, timestamps included.

    sent: columns that the device sends, by default all; a recorder that polls faster than the
    device sends repeats these with stamps of its own.
    """
    if frames["time"].is_unique:  # the usual case, and quick to test
        return frames
    time, data = frames["time"].to_numpy(), frames[[*sent] or [*frames]]
    repeated = data.duplicated()
    if epochs(time[~repeated]).max() > 0:  # after a reset, timestamps may legitimately recur
        repeated = data.assign(epoch=epochs(time)).duplicated()
    detail = "rows that repeat an earlier one, as a recorder does that is faster; discarded"
    add_finding(findings, device, Found.REPEATED_FRAMES, "note", repeated.sum(), detail)
    return frames[~repeated].reset_index(drop=True)


def _nudge_stale_stamps(frames: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Return frames with new data under an already used timestamp moved to the next slot, where
    they replace what is there.

    Where a recorder reads the stamp before the data, the stamps after a stale one are stale, too.
    """
    stale = frames.duplicated(["epoch", "time"]).to_numpy()
    if not stale.any():
        return frames
    detail = "new data with an old timestamp; moved to the next slot"
    add_finding(findings, "robot", Found.STALE_STAMPS, "warning", stale.sum(), detail)
    time, stamp = frames["time"].to_numpy(), np.cumsum(~stale) - 1
    steps = np.append(np.diff(time[~stale]), np.inf)  # from each stamp to the next
    steps[np.flatnonzero(np.diff(frames["epoch"].to_numpy()[~stale]))] = np.inf
    cycle = np.median(steps[np.isfinite(steps)])
    # exactly the next stamp's time, or frames would lie apart by a rounding error
    next_slot = np.where(
        steps < MIN_FREE_CYCLES * cycle, np.append(time[~stale][1:], np.inf), time[~stale] + cycle
    )
    moved = frames.assign(time=np.where(stale, next_slot[stamp], time))
    moved = moved.sort_values(["epoch", "time"], kind="stable", ignore_index=True)
    crowded = moved.duplicated(["epoch", "time"])
    report_crowded(findings, int(crowded.sum()))
    return moved[~crowded].reset_index(drop=True)


def report_crowded(findings: list[Finding], count: int) -> None:
    """Add a finding with the number of frames discarded because another one falls into their
    cycle.
    """
    detail = "several frames fall into one cycle; only the first is kept"
    add_finding(findings, "robot", Found.CROWDED_FRAMES, "warning", count, detail)


def _drop_stale_data(frames: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Return the frames without those that repeat the data of the previous one, if efforts are
    noisy.
    """
    efforts = frames.filter(regex=r"actual_current_|actual_torque_\d").columns
    if efforts.empty:
        return frames  # without a noisy channel, an arm at rest repeats itself legitimately
    channels = frames.columns.difference(["time", "epoch", "received"])
    same = np.ones(len(frames), dtype=bool)
    for channel in channels:  # one after the other, for the memory of long recordings
        same &= np.diff(frames[channel].to_numpy(float), prepend=np.nan) == 0
    noisy = (frames[efforts].diff().abs() > 0).any(axis="columns").mean() > 0.9
    if not (same.any() and noisy):
        return frames
    detail = "data of the previous frame with a new timestamp; treated as lost frames"
    add_finding(findings, "robot", Found.STALE_DATA, "warning", same.sum(), detail)
    return frames[~same].reset_index(drop=True)


def _return_lost_data(frames: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Return frames with the data of a lost frame, which came with the next timestamp, moved one
    cycle back.
    """
    q, qd = (frames.filter(regex=rf"^{name}_\d$") for name in ("actual_q", "actual_qd"))
    if q.shape[1] != qd.shape[1] or len(frames) < 3:
        return frames
    time = frames["time"].to_numpy()
    steps = np.diff(time)
    cycle = float(np.median(steps))
    after_gap = np.flatnonzero(steps[:-1] > 1.5 * cycle) + 1
    late = after_gap[_one_cycle_late(after_gap, time, q, qd, cycle)]
    if not len(late):
        return frames
    detail = "data of a lost frame with the next timestamp; moved back to their own time"
    add_finding(findings, "robot", Found.LATE_DATA, "warning", len(late), detail)
    time = time.copy()
    time[late] -= cycle
    return frames.assign(time=time)


def _one_cycle_late(
    rows: Labels, time: Array, q: pd.DataFrame, qd: pd.DataFrame, cycle: float
) -> Mask:
    """Return in which of some frames (rows) the arm is where it was one cycle earlier.

    The way to such a frame is shorter, and that to the next one longer, than by the velocities.
    """
    before, here, after = (
        (time[at, None], q.iloc[at].to_numpy(), qd.iloc[at].to_numpy())
        for at in (rows - 1, rows, rows + 1)
    )
    # lateness [cycles]: the surplus of the way, along what the arm travels in one cycle
    lateness = []
    for (time_0, q_0, qd_0), (time_1, q_1, qd_1) in ((before, here), (here, after)):
        velocity = (qd_0 + qd_1) / 2
        surplus, travel = q_1 - q_0 - velocity * (time_1 - time_0), velocity * cycle
        square = np.maximum(np.sum(travel**2, axis=1), MIN_TRAVEL**2)
        lateness.append(np.sum(surplus * travel, axis=1) / square)
    to_here, to_next = lateness
    return (to_here < -MIN_LATENESS) & (to_next > MIN_LATENESS)
