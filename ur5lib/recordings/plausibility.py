"""Detection of impossible values: shifted bytes, wrong units, absurd times, lost cells."""

import math
import re
from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from numpy.lib.stride_tricks import sliding_window_view

from ur5lib.channels import CHANNELS, MOST_JOINTS, columns
from ur5lib.errors import InputError, some
from ur5lib.recordings.ordering import epochs
from ur5lib.records.codes import Found
from ur5lib.records.quality import Device, Finding, add_finding
from ur5lib.tables import unit
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import runs

# Share of frames that may be discarded. More indicates a wrong unit, not damage.
MAX_SHARE_IMPOSSIBLE = 0.05
STRAY_PAUSE = 60.0  # s; a few frames beyond such a pause are strays
MIN_STEP, MAX_STEP = 2e-4, 1.0  # s; other steps mean that time is not in seconds
NEIGHBOURS = 2  # frames on each side that a timestamp is compared with
MIN_LEAP = 5.0  # times the largest usual step; a value that falls to zero by more was not received
USUAL_QUANTILE = 0.99  # quantile of a column's steps that is still usual
# Channels that are never zero for long while other joints' are not.
NOISY_COLUMNS = "actual_current_"
TORQUES = [name for name, spec in CHANNELS.items() if spec.of_joints and spec.unit == "Nm"]
LIKELY_UNITS = {"rad": "deg", "rad/s": "deg/s", "A": "mA"}  # by the unit that is exceeded
NAMES_OF_UNITS = {"deg": "degrees", "deg/s": "degrees"}
ROUNDED_ANGLE = 1e-3  # rad; a lost value so near to zero would change nothing
ROUNDED_SPEED = 0.1  # rad/s; drivers round smaller velocities to zero
MIN_DEAD_ROWS = 5  # of zeros of some joints' currents, which were not received
MIN_TIMES_ZERO = 3  # at which a torque is zero that was commanded so; a file loses a block or two
MIN_POWERLESS_ROWS = 50  # of zeros of all currents, of an arm without power
# In any unit. Single precision ends at 1e-45; what is nearer to zero is stray bytes.
SMALLEST_VALUE = 1e-50


def drop_implausible(
    frames: pd.DataFrame,
    source: str,
    device: Device,
    findings: list[Finding],
    bounds: Mapping[str, float] | None = None,
) -> pd.DataFrame:
    """Return the frames without those with impossible values or times, which are reported.

    frames: in the file's order; bounds: by column, the magnitude from which on a value is
    impossible for this arm, where that differs from a Universal Robots arm; infinite for a joint
    that turns without limit. Raises InputError when so many are impossible that a unit or a column
    must be wrong.
    """
    wrong = np.zeros(len(frames), dtype=bool)
    for name, spec in CHANNELS.items():
        own = {n: (bounds or {}).get(n, spec.bound) for n in columns(name, MOST_JOINTS)}
        bounded = {n: bound for n, bound in own.items() if n in frames and math.isfinite(bound)}
        if bounded:
            wrong |= _beyond(frames, bounded, source)
    time = frames["time"].to_numpy(float)
    wrong[~wrong] = stray_times(time[~wrong])
    code = Found.IMPOSSIBLE_FRAMES if device == "robot" else Found.IMPOSSIBLE_SAMPLES
    row = int(np.argmax(wrong)) + 1 if len(wrong) else 0
    detail = f"first in row {row}: physically impossible values or times, discarded"
    add_finding(findings, device, code, "warning", wrong.sum(), detail)
    check_pace(time[_with_positions(frames) & ~wrong], source)
    return frames[~wrong].reset_index(drop=True) if wrong.any() else frames


def _with_positions(frames: pd.DataFrame) -> Mask:
    """Return which rows (N,) have a position; rows of other topics in the same table have none. All
    if positions were not recorded.
    """
    q = frames.get("actual_q_0")
    return np.isfinite(q.to_numpy(float)) if q is not None else np.ones(len(frames), bool)


def _beyond(frames: pd.DataFrame, bounds: Mapping[str, float], source: str) -> Mask:
    """Return which rows (N,) exceed a column's bound. Raises InputError when more than a few do."""
    size = {name: np.abs(frames[name].to_numpy(float)) for name in bounds}
    too_large = {name: size[name] > bound for name, bound in bounds.items()}
    beyond = np.logical_or.reduce([*too_large.values()])
    if beyond.mean() > MAX_SHARE_IMPOSSIBLE:
        channel = max(too_large, key=lambda name: too_large[name].sum())
        middle = np.median(size[channel][too_large[channel]])
        exceeding = [name for name, rows in too_large.items() if rows.mean() > MAX_SHARE_IMPOSSIBLE]
        raise InputError(
            f"{source}: {channel} exceeds {bounds[channel]:.4g} {unit(channel)} in "
            f"{beyond.mean():.0%} of the rows (median there {middle:.4g}); "
            f"{_likely_units([channel, *exceeding])}"
            "correct the file, the column or unit that the study gives it (docs/recordings.md), or "
            "the arm's limits (docs/robots.md)"
        )
    return beyond


def _likely_units(exceeding: Sequence[str]) -> str:
    """Return in words in which units columns may be, the first one above all, and what says so."""
    units = {name.rpartition("_")[0]: LIKELY_UNITS.get(unit(name)) for name in exceeding}
    likely = {channel: one for channel, one in units.items() if one}
    first = next(iter(units.values()))
    if first is None:
        return ""
    given = ", ".join(f"{channel}: {one}" for channel, one in likely.items())
    return f"is it in {NAMES_OF_UNITS.get(first, first)}? Then give it `units: {{{given}}}`; else, "


def check_pace(time: Array, source: str, shortest: float = MIN_STEP) -> None:
    """Raise InputError when the steps between timestamps [s] cannot be those of a recording."""
    steps = np.diff(np.sort(time))
    step = float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0
    if not shortest <= step <= MAX_STEP:
        raise InputError(
            f"{source}: the median step between timestamps is {step:.4g} s; check that the time "
            "column is in seconds and has all its digits, or name its unit in the study "
            "(docs/recordings.md)"
        )


def stray_times(time: Array) -> Mask:
    """Return which timestamps [s] (N,) are far from all others or from their neighbours in the
    file.
    """
    steps = np.diff(time)
    if len(time) < 2 * NEIGHBOURS + 1 or (steps.min() >= 0 and steps.max() <= STRAY_PAUSE):
        return np.zeros(len(time), dtype=bool)
    strays = _islands(time)
    strays[~strays] = _contradicted(time[~strays])
    return strays


def first_time(time: Array) -> float:
    """Return the earliest timestamp [s] before any clock reset, strays left out."""
    return float(time[before_reset(time)].min())


def before_reset(time: Array) -> Mask:
    """Return which timestamps [s] (N,) are no strays and come before any reset of the clock."""
    kept = ~stray_times(time)
    kept[kept] = epochs(time[kept]) == 0
    return kept


def _contradicted(time: Array) -> Mask:
    """Return which timestamps (N,) are far from the median of their neighbours in the file."""
    # where the rows are shuffled, neighbours mean nothing
    if np.mean(np.diff(time) < 0) > MAX_SHARE_IMPOSSIBLE:
        return np.zeros(len(time), dtype=bool)
    around = sliding_window_view(np.pad(time, NEIGHBOURS, mode="reflect"), 2 * NEIGHBOURS + 1)
    return np.abs(time - np.median(around, axis=1)) > MAX_STEP


def _islands(time: Array) -> Mask:
    """Return which timestamps (N,) are separated from the others by a long pause and are few."""
    order = np.argsort(time, kind="stable")
    island = np.concatenate([[0], np.cumsum(np.diff(time[order]) > STRAY_PAUSE)])
    strays = np.empty(len(time), dtype=bool)
    strays[order] = np.bincount(island)[island] < max(2, MAX_SHARE_IMPOSSIBLE * len(time))
    # more indicate a wrong unit, not damage
    return strays & (strays.mean() <= MAX_SHARE_IMPOSSIBLE)


def is_silent(values: Array) -> bool:
    """Return whether all values (N, k) are zero, or so near to it that nobody wrote them."""
    return not (np.abs(values) >= SMALLEST_VALUE).any()


def drop_unwritten(table: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Return a table without channels that contain only stray bytes, as of efforts that a driver
    never sets.
    """
    channels = defaultdict[str, list[str]](list)
    for name in table:
        channels[re.sub(r"_\d+$", "", name)].append(name)
    silent = [
        name
        for name, columns in channels.items()
        if all(is_silent(table[column].to_numpy(float)) for column in columns)
    ]
    names = [name for name in silent if np.nan_to_num(table[channels[name]].to_numpy(float)).any()]
    detail = f"{some(names)}: numbers that were never written, all but zero; not recorded"
    add_finding(findings, "robot", Found.UNWRITTEN_CHANNELS, "warning", len(names), detail)
    unwritten = [column for name in names for column in channels[name]]
    return table.drop(columns=unwritten) if unwritten else table


def drop_zeroed(table: pd.DataFrame, findings: list[Finding]) -> pd.DataFrame:
    """Return a table with NaN where a value falls to exactly zero at once, or one joint's current
    is zero for several rows while others are not.

    Torques that are often zero were commanded so.
    """
    values = table.to_numpy(float)
    near_zero = np.abs(values) < SMALLEST_VALUE
    stray = (values != 0.0) & near_zero & ~near_zero.all(axis=0)
    fallen = [_fallen(values[:, k], leap) for k, leap in enumerate(_least_leaps(table))]
    wrong = stray | np.stack(fallen, axis=1)
    if "time" in table:  # a clock may start anew at zero
        wrong[:, table.columns.get_loc("time")] &= ~_restarts(table["time"].to_numpy(float))
    noisy = [k for k, name in enumerate(table) if name.startswith(NOISY_COLUMNS)]
    if noisy:
        wrong[:, noisy] |= _dead(values[:, noisy])
    if not wrong.any():
        return table
    detail = "values drop to exactly zero, as where a file lost a block; not used"
    add_finding(findings, "robot", Found.ZEROED_CELLS, "warning", wrong.any(axis=1).sum(), detail)
    return table.mask(wrong)


def _least_leaps(table: pd.DataFrame) -> list[float]:
    """Return by column the leap from which on a fall to zero was not received."""
    # a joint that rests at zero is logged one digit beside it, a slow velocity is rounded to zero
    rounded = {"_q_": ROUNDED_ANGLE, "_qd_": ROUNDED_SPEED}
    least = {
        name: sum(leap for kind, leap in rounded.items() if kind in name)
        for name in map(str, table)
    }
    for channel in TORQUES:
        names = [name for name in columns(channel, MOST_JOINTS) if name in table]
        if names and _is_often_zero(table[names].to_numpy(float)):
            least |= dict.fromkeys(names, math.inf)
    return [*least.values()]


def _is_often_zero(torques: Array) -> bool:
    """Return whether torques (N, k) are zero at several times, in more cells than files lose."""
    zero = torques == 0.0
    times = len(runs(zero.any(axis=1)))
    return bool(zero.mean() > MAX_SHARE_IMPOSSIBLE) and times >= MIN_TIMES_ZERO


def _restarts(time: Array) -> Mask:
    """Return at which stamps (N,) a clock starts anew: they are followed by increasing ones below
    the stamp before.
    """
    before, after = np.append(-np.inf, time[:-1]), np.append(time[1:], np.inf)
    return (after > time) & (after < before)


def _fallen(column: Array, least: float) -> Mask:
    """Return which cells (N,) of a column are in runs of zeros that begin or end with a leap;
    least: smallest leap.
    """
    zero = column == 0.0
    received = column[~zero & (np.abs(column) < np.sqrt(np.finfo(float).max))]
    steps = np.abs(np.diff(received))
    wrong = np.zeros(len(column), dtype=bool)
    if not zero.any() or not len(steps):
        return wrong
    leap = max(least, MIN_LEAP * np.quantile(steps, USUAL_QUANTILE))
    for start, end in runs(zero):
        beside = [column[k] for k in (start - 1, end) if 0 <= k < len(column)]
        wrong[start:end] = np.nanmax(np.abs(beside)) > leap
    return wrong


def _dead(currents: Array) -> Mask:
    """Return which cells (N, k) of currents were not received: in long runs of zeros of some
    joints, or short ones of all.

    An arm without power has zeros of all joints for long.
    """
    off = (currents == 0.0).all(axis=1)
    zero = (currents == 0.0) & ~off[:, None]
    wrong = np.zeros_like(zero)
    for start, end in runs(off):
        wrong[start:end] = end - start < MIN_POWERLESS_ROWS
    for joint, column in enumerate(zero.T):
        for start, end in runs(column):
            wrong[start:end, joint] = end - start >= MIN_DEAD_ROWS and not column.all()
    return wrong
