"""Frames that no arm can have: shifted bytes, wrong units, absurd times."""

import numpy as np
import pandas as pd
from numpy.lib.stride_tricks import sliding_window_view

from ur5lib.errors import InputError
from ur5lib.recordings.ordering import epochs
from ur5lib.recordings.quality import Device, Finding
from ur5lib.tables import unit
from ur5lib.timeseries.arrays import Array, Mask

BOUNDS = {  # far beyond what any of the maker's arms does, SI units
    "actual_q_": 4 * np.pi,
    "target_q_": 4 * np.pi,
    "actual_qd_": 20.0,
    "target_qd_": 20.0,
    "target_qdd_": 200.0,
    "actual_current_": 60.0,
    "target_current_": 60.0,
    "target_moment_": 1000.0,
    "actual_TCP_force_": 5000.0,
    "actual_TCP_speed_": 50.0,
    "actual_TCP_pose_": 20.0,
    "ft_f": 5000.0,
    "ft_t": 1000.0,
    "imu_a": 500.0,
    "imu_g": 50.0,
}
FEW = 0.05  # share of frames that may be left out; more is a wrong unit, not damage
PAUSE = 60.0  # s; a handful of frames beyond such a pause are strays
SHORTEST_STEP, LONGEST_STEP = 2e-4, 1.0  # s, of a recording whose time is in seconds
AROUND = 2  # frames on each side that may contradict a stamp


def drop_implausible(
    frames: pd.DataFrame, source: str, device: Device, findings: list[Finding]
) -> pd.DataFrame:
    """Frames without those whose values or times are impossible. frames: in the file's order.

    Raises InputError when so many are that a unit or a column must be wrong.
    """
    wrong = np.zeros(len(frames), dtype=bool)
    for prefix, bound in BOUNDS.items():
        wrong |= _beyond(frames.filter(regex=f"^{prefix}"), bound, source)
    time = frames["time"].to_numpy(float)
    wrong[~wrong] = stray_times(time[~wrong])
    if wrong.any():
        where = int(np.flatnonzero(wrong)[0])
        detail = f"row {where + 1} first: impossible values or times, left out"
        name = "impossible frames" if device == "robot" else "impossible samples"
        findings.append(Finding(device, name, "warning", int(wrong.sum()), detail))
    check_pace(time[~wrong], source)
    return frames[~wrong].reset_index(drop=True) if wrong.any() else frames


def _beyond(channels: pd.DataFrame, bound: float, source: str) -> Mask:
    """Which rows (N,) lie beyond a bound. Raises InputError when more than a few do."""
    size = channels.abs()
    beyond = (size > bound).any(axis="columns").to_numpy()
    if beyond.mean() > FEW:
        channel = (size > bound).sum().idxmax()
        middle = size[channel].where(size[channel] > bound).median()
        raise InputError(
            f"{source}: {channel} is {middle:.4g} in the middle of {beyond.mean():.0%} of the "
            f"rows, beyond {bound:.4g} {_si_unit(str(channel))} (SI units); correct the file, or "
            "name its `columns` and `units` in the study (raw/README.md)"
        )
    return beyond


def _si_unit(channel: str) -> str:
    """The unit that a channel must have, and the one that it often has instead."""
    return unit(channel) + (", as degrees are" if unit(channel).startswith("rad") else "")


def check_pace(time: Array, source: str, shortest: float = SHORTEST_STEP) -> None:
    """Raises InputError when the steps between stamps [s] cannot be those of a recording."""
    steps = np.diff(np.sort(time))
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    if not shortest <= step <= LONGEST_STEP:
        raise InputError(
            f"{source}: frames are {step:.4g} s apart in the middle; "
            "give the time in seconds, with all its digits, in the column of the time, or name "
            "its unit in the study (raw/README.md)"
        )


def stray_times(time: Array) -> Mask:
    """Which stamps [s] (N,) are far from all others, or far from those around them in the file."""
    steps = np.diff(time)
    if len(time) < 2 * AROUND + 1 or (steps.min() >= 0 and steps.max() <= PAUSE):
        return np.zeros(len(time), dtype=bool)
    strays = _islands(time)
    strays[~strays] = _contradicted(time[~strays])
    return strays


def first_time(time: Array) -> float:
    """When a recording began: its earliest stamp [s] before any reset of the clock."""
    time = time[~stray_times(time)]
    return float(time[epochs(time) == 0].min())


def _contradicted(time: Array) -> Mask:
    """Stamps far from the middle of those around them; in rising stamps, there are none."""
    if np.mean(np.diff(time) < 0) > FEW:  # rows are shuffled: neighbours tell nothing
        return np.zeros(len(time), dtype=bool)
    around = sliding_window_view(np.pad(time, AROUND, mode="reflect"), 2 * AROUND + 1)
    return np.abs(time - np.median(around, axis=1)) > LONGEST_STEP


def _islands(time: Array) -> Mask:
    """Stamps beyond a long pause with few others."""
    order = np.argsort(time, kind="stable")
    island = np.concatenate([[0], np.cumsum(np.diff(time[order]) > PAUSE)])
    strays = np.empty(len(time), dtype=bool)
    strays[order] = np.bincount(island)[island] < max(2, FEW * len(time))
    return strays & (strays.mean() <= FEW)  # more are a wrong unit, not damage
