"""Repair of missing samples: frames on a uniform time grid, gaps flagged and filled, or split."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
import pandas as pd

from ur5lib.channels import SIX_SUFFIXES, joint_count, suffixes
from ur5lib.errors import InputError
from ur5lib.recordings.bunched_stamps import evenly_stamped
from ur5lib.recordings.frozen import without_frozen
from ur5lib.recordings.ordering import in_order, report_crowded
from ur5lib.recordings.plausibility import MIN_STEP, drop_implausible
from ur5lib.records.codes import Found
from ur5lib.records.phrases import number
from ur5lib.records.quality import Finding, add_finding
from ur5lib.timeseries.arrays import Array, Labels, Mask
from ur5lib.timeseries.sampling import interpolated, monotone

SMOOTH_CHANNELS = ("actual_q", "actual_qd", "target_q", "target_qd")  # interpolated by PCHIP
MAX_DISTANCE_FROM_GRID = 0.1  # cycles; how far a step may lie from a whole number of cycles
# Share of steps within MAX_DISTANCE_FROM_GRID in a recording with a fixed cycle.
MIN_SHARE_ON_GRID = 0.95
MIN_SLOW_STEP = 2  # rows from a sample to the next, of a channel that others outpace
MIN_REPORTED_JITTER = 5e-5  # s; larger jitter is reported
FRAME_COLUMNS = ("time", "epoch", "received")  # columns that are not channels


@dataclass(frozen=True)
class Timing:
    """The timing of the frames, in s: period of the grid, longest step between timestamps, and
    their jitter around the grid (median and 99 %). regular: whether steps are whole numbers of
    periods.
    """

    period: float
    regular: bool
    longest_step: float
    jitter_median: float
    jitter_99: float


@dataclass(frozen=True)
class GridStretch:
    """Consecutive frames without a split, placed on the time grid.

    rows: the frames (n,) that are used, one per slot; place: of these on the grid (n,), in periods
    from the first; slots: numbers of all slots (m,); start: time of the first frame [s]; crowded:
    number of frames discarded because another one has their slot.
    """

    rows: Labels
    place: Array
    slots: Labels
    start: float
    crowded: int


def repair_frames(
    frames: pd.DataFrame,
    cycle: float | None,
    max_gap: float,
    source: str,
    bounds: Mapping[str, float] | None = None,
) -> tuple[pd.DataFrame, Timing, list[Finding]]:
    """Return the frames in order on a uniform grid, the timing, and the findings.

    frames: `time` [s] and channels as read; it loses its columns on the way, so that a long
    recording is in memory only once. cycle: the controller's [s], None to determine it; max_gap:
    [s]; source: the file, for messages; bounds: as in `drop_implausible`.

    The table has `time`, `segment`, `interpolated`, the channels, and `filled_<channel>` for each
    channel with interpolated cells. Gaps up to `max_gap` are interpolated; longer ones split the
    recording: `segment` counts its parts from 0. Raises InputError when fewer than two frames are
    usable or the units must be wrong.
    """
    findings: list[Finding] = []
    _expect_frames(frames, source)
    given, frames = frames, _whole_channels(frames, findings, source)
    possible = drop_implausible(evenly_stamped(frames, findings), source, "robot", findings, bounds)
    frames = in_order(possible, findings)
    del possible
    given.columns = ["given"] * len(given.columns)  # to be deleted at once
    del given["given"]  # so that each channel can be freed when it is on the grid
    _expect_frames(frames, source)
    timing = _timing_of_positions(frames, cycle, source)
    _report_steps(timing, findings)
    holes, frames = _holes(frames), without_frozen(frames, findings)
    steps, vectors = _steps(frames), _vectors(frames)
    stretches = _stretches(frames, timing, max_gap)
    arrays = {name: frames[name].to_numpy() for names in vectors.values() for name in names}
    del frames
    table, lost, slow = _on_grid(arrays, vectors, stretches, timing, max_gap)
    _expect_frames(table, source)
    detail = (
        f"{' and '.join(slow)} were logged less often than the positions; they are interpolated "
        "between their samples"
    )
    add_finding(findings, "robot", Found.SLOW_CHANNELS, "note", len(slow), detail)
    _report_lost(steps, table, timing, len(vectors), findings)
    detail = "some channels have missing cells; they are interpolated"
    add_finding(findings, "robot", Found.MISSING_CELLS, "warning", holes, detail)
    detail = "gaps are too long to fill; the recording is split, nothing is computed across them"
    add_finding(findings, "robot", Found.SPLIT, "warning", int(table["segment"].max()), detail)
    detail = "a channel is missing for too long, or at the start or end; frames discarded"
    add_finding(findings, "robot", Found.INCOMPLETE_FRAMES, "warning", lost, detail)
    report_crowded(findings, sum(stretch.crowded for stretch in stretches))
    return table, timing, findings


def _expect_frames(frames: pd.DataFrame, source: str) -> None:
    if len(frames) < 2:
        raise InputError(
            f"{source}: contains only {len(frames)} complete frames; record at least a second"
        )


def _whole_channels(frames: pd.DataFrame, findings: list[Finding], source: str) -> pd.DataFrame:
    """Return the frames without channels that lack a column or have no row with all columns."""
    joints, columns_of = joint_count(frames), _vectors(frames)
    absent = [
        name
        for name, columns in columns_of.items()
        if len(columns) < (len(suffixes(name, joints)) or len(columns))
        or not np.all([np.isfinite(frames[c].to_numpy(float)) for c in columns], axis=0).any()
    ]
    if "actual_q" in absent or "actual_q_0" not in frames:
        raise no_positions(frames, joints or len(SIX_SUFFIXES), source)
    detail = f"{', '.join(absent)}: columns are missing or empty; the channel is ignored"
    add_finding(findings, "robot", Found.INCOMPLETE_CHANNELS, "warning", len(absent), detail)
    return frames.drop(columns=[column for name in absent for column in columns_of[name]])


def no_positions(frames: pd.DataFrame, joints: int, source: str) -> InputError:
    """Return the error for frames without positions, with the names of the missing columns."""
    names = [f"actual_q_{joint}" for joint in range(joints)]
    missing = [name for name in names if name not in frames or not frames[name].notna().any()]
    lacking = ", ".join(missing) or "row with all of actual_q"
    if missing == names:
        lacking = f"{names[0]} to {names[-1]}"
    remedy = "record the joint positions, or name their columns in the study"
    return InputError(f"{source}: has no {lacking}; {remedy}")


def _timing_of_positions(frames: pd.DataFrame, cycle: float | None, source: str) -> Timing:
    """Return the timing of all rows; if positions come less often, that of the rows with
    positions.
    """
    positioned = np.isfinite(frames[_vectors(frames)["actual_q"]].to_numpy(float)).all(axis=1)
    if not _is_slow(positioned):
        return _timing(frames, cycle, source)
    return replace(_timing(frames[positioned], cycle, source), regular=False)


def _is_slow(received: Mask) -> bool:
    """Return whether a channel was logged less often than others; received: the rows (N,) that have
    it.
    """
    steps = np.diff(np.flatnonzero(received))
    return len(steps) > 0 and bool(np.median(steps) >= MIN_SLOW_STEP)


def _timing(frames: pd.DataFrame, cycle: float | None, source: str) -> Timing:
    steps = _steps(frames)
    period = cycle or round(max(float(np.quantile(steps, 0.1)), MIN_STEP), 4)
    off = np.abs(steps - period * np.rint(steps / period))
    regular = bool(cycle or np.mean(off <= MAX_DISTANCE_FROM_GRID * period) >= MIN_SHARE_ON_GRID)
    if not regular:
        period = round(max(float(np.median(steps)), MIN_STEP), 4)
        off = np.abs(steps - period)
    median, high = np.quantile(off, [0.5, 0.99])
    if median > period / 2 or np.median(steps) < period / 2:
        raise InputError(
            f"{source}: the steps between timestamps (median {np.median(steps):.3g} s) do not fit "
            f"a cycle of {period:g} s; check which column is the time, its unit, and whether it "
            "has lost digits"
        )
    return Timing(period, regular, float(steps.max()), float(median), float(high))


def _steps(frames: pd.DataFrame) -> Array:
    """Return the steps between timestamps [s], without those at clock resets."""
    return frames["time"].diff()[frames["epoch"].diff() == 0].to_numpy()


def _holes(frames: pd.DataFrame) -> int:
    """Return how many frames lack at least one cell."""
    missing = np.zeros(len(frames), dtype=bool)
    for name in frames.columns.drop("time"):
        missing |= ~np.isfinite(frames[name].to_numpy(float))
    return int(missing.sum())


def _stretches(frames: pd.DataFrame, timing: Timing, max_gap: float) -> list[GridStretch]:
    """Return the frames split at clock resets and at gaps longer than `max_gap` [s], each part
    placed on the grid.
    """
    longest = max_gap + 1.5 * timing.period
    breaks = (frames["time"].diff() > longest) | (frames["epoch"].diff() > 0)
    bounds = [0, *np.flatnonzero(breaks), len(frames)]
    time = frames["time"].to_numpy()
    return [_stretch(np.arange(*ends), time, timing) for ends in pairwise(bounds)]


def grid_times(time: Array, epoch: Labels, period: float, max_gap: float) -> Array:
    """Return the times [s] at which the grid of `repair_frames` has stamps (N,), between two of its
    own where steps are no whole periods.

    time: in order [s]; epoch: of each, how often the clock was reset before; period, max_gap: [s].
    """
    steps = np.diff(time)[np.diff(epoch) == 0]
    off = np.abs(steps - period * np.rint(steps / period))
    share = float(np.mean(off <= MAX_DISTANCE_FROM_GRID * period)) if len(steps) else 1.0
    whole = share >= MIN_SHARE_ON_GRID and (not len(steps) or np.median(steps) >= period / 2)
    timing = Timing(period, bool(whole), 0.0, 0.0, 0.0)
    apart = (np.diff(time) > max_gap + 1.5 * period) | (np.diff(epoch) > 0)
    parts = np.split(time, np.flatnonzero(apart) + 1)
    return np.concatenate([part[0] + period * _places(part, timing) for part in parts])


def _stretch(rows: Labels, time: Array, timing: Timing) -> GridStretch:
    """Return frames without a split as placed on the grid. rows: their indices; time: of all frames
    [s].
    """
    place = _places(time[rows], timing)
    first = np.unique(place, return_index=True)[1]
    slots = np.arange(int(np.floor(place[first[-1]] + 1e-6)) + 1)
    crowded = len(place) - len(first)
    return GridStretch(rows[first], place[first], slots, float(time[rows[0]]), crowded)


def _on_grid(
    arrays: dict[str, Array],
    vectors: Mapping[str, list[str]],
    stretches: list[GridStretch],
    timing: Timing,
    max_gap: float,
) -> tuple[pd.DataFrame, int, list[str]]:
    """Return the table on the grid, how many of its slots were lost, and the names of slow
    channels.

    A slot is lost if any channel has a long gap there, or no sample at all. Values between the
    samples of a slow channel do not make a frame an interpolated one. arrays: (N,) by column, each
    of which is freed when it is on the grid; vectors: the columns of each channel.
    """
    columns_at, flags = dict[str, Array](), dict[str, Mask]()
    lost = np.zeros(sum(len(stretch.slots) for stretch in stretches), dtype=bool)
    for name, columns in vectors.items():
        values = np.stack([arrays.pop(column) for column in columns], axis=1).astype(float)
        filled, flag, beyond = _fill_stretches(values, stretches, timing, max_gap, name)
        columns_at |= {column: filled[:, k].copy() for k, column in enumerate(columns)}
        lost |= beyond
        flags[name] = flag
    time = [stretch.start + stretch.slots * timing.period for stretch in stretches]
    slow = [name for name, flag in flags.items() if name != "actual_q" and _is_slow(~flag)]
    on_grid = {
        "time": np.concatenate(time),
        "interpolated": np.logical_or.reduce([flags[name] for name in flags if name not in slow]),
        **columns_at,
        **{f"filled_{name}": flag for name, flag in flags.items() if flag.any()},
    }
    if lost.any():
        on_grid = {name: values[~lost] for name, values in on_grid.items()}
    table = pd.DataFrame(on_grid, copy=False)
    table.insert(1, "segment", _segments(stretches, lost))
    return table, int(lost.sum()), slow


def _fill_stretches(
    values: Array, stretches: list[GridStretch], timing: Timing, max_gap: float, name: str
) -> tuple[Array, Mask, Mask]:
    """Return a channel at all slots (m, k), which of these were filled, and which are lost.

    values: (n, k), of all frames.
    """
    parts = []
    for stretch in stretches:
        received = values[stretch.rows]
        complete = np.isfinite(received).all(axis=1)
        if complete.any():
            at = stretch.place[complete], received[complete]
            parts.append(_fill(*at, stretch.slots, timing, max_gap, name))
        else:
            nothing = np.full((len(stretch.slots), values.shape[1]), np.nan)
            no_slot = np.zeros(len(nothing), dtype=bool)
            parts.append((nothing, no_slot, ~no_slot))
    filled, flag, lost = map(np.concatenate, zip(*parts, strict=True))
    return filled, flag, lost


def _segments(stretches: list[GridStretch], lost: Mask) -> Labels:
    """Return, for each slot that is not lost, the number of its part without gaps, from 0."""
    begins = np.concatenate([stretch.slots == 0 for stretch in stretches])
    parts = np.cumsum(begins | np.append(False, lost[:-1]))
    return np.unique(parts[~lost], return_inverse=True)[1]


def _places(time: Array, timing: Timing) -> Array:
    """Return the positions of the timestamps on the grid, in periods from the first."""
    if not timing.regular:
        return (time - time[0]) / timing.period
    # Rounding each step by itself keeps the jitter of the timestamps from adding up.
    return np.concatenate([[0.0], np.cumsum(np.rint(np.diff(time) / timing.period))])


def _fill(
    place: Array, values: Array, slots: Labels, timing: Timing, max_gap: float, name: str
) -> tuple[Array, Mask, Mask]:
    """Return values at the slots, which of these were not received, and which are in too long a
    gap.

    place: of the received values (n, k) on the grid, in periods.
    """
    after = np.minimum(np.searchsorted(place, slots), len(place) - 1)
    before = np.maximum(np.searchsorted(place, slots, side="right") - 1, 0)
    nearest = np.where(place[after] - slots < slots - place[before], after, before)
    away = np.abs(place[nearest] - slots)
    missing = away > (1e-6 if timing.regular else 1.0)
    gap = (place[after] - place[before]) * timing.period
    beyond = missing & (gap > max_gap + 1.5 * timing.period)
    beyond |= (slots > place[-1] + 1e-6) | (slots < place[0] - 1e-6)
    filled = values[nearest]
    inexact = away > 1e-6
    if inexact.any() and len(place) > 1:
        at = slots[inexact]
        between = monotone if name in SMOOTH_CHANNELS else interpolated
        filled[inexact] = between(at, place, values)
    return filled, missing, beyond


def _vectors(frames: pd.DataFrame) -> dict[str, list[str]]:
    """Return the column names of each channel, as six for actual_q."""
    vectors: dict[str, list[str]] = {}
    for column in frames.columns.difference(FRAME_COLUMNS, sort=False):
        name, _, suffix = column.rpartition("_")
        vectors.setdefault(name if suffix.isdigit() else column, []).append(column)
    return vectors


def _report_steps(timing: Timing, findings: list[Finding]) -> None:
    grid = number(1000 * timing.period, "g")
    median = number(1000 * timing.jitter_median, ".2g")
    most = f"{number(1000 * timing.jitter_99, '.2g')} ms (99 %)"
    if not timing.regular:
        detail = (
            f"time steps vary by {most} around {grid} ms; signals are interpolated onto a uniform "
            "grid"
        )
        findings.append(Finding("robot", Found.IRREGULAR_STEPS, "note", 1, detail))
    elif timing.jitter_99 > MIN_REPORTED_JITTER:
        detail = (
            f"timestamps deviate from the {grid} ms grid by {median} ms (median), {most}; snapped "
            "to the grid"
        )
        findings.append(Finding("robot", Found.JITTER, "note", 1, detail))


def _report_lost(
    steps: Array, table: pd.DataFrame, timing: Timing, channels: int, findings: list[Finding]
) -> None:
    filled = int(table["interpolated"].sum())
    lost = int((np.rint(steps / timing.period) - 1).clip(min=0).sum())
    if not timing.regular:
        flags = table.filter(like="filled_")
        lost = int(flags.all(axis=1).sum()) if flags.shape[1] == channels else 0
    if lost:
        common = pd.Series(1000 * timing.period * np.rint(steps / timing.period)).value_counts()
        each = (f"{count} of {number(step, 'g')} ms" for step, count in common.head(3).items())
        detail = (
            f"most frequent steps: {', '.join(each)}; longest "
            f"{number(1000 * timing.longest_step, '.0f')} ms; {filled} interpolated"
        )
        findings.append(Finding("robot", Found.LOST_FRAMES, "warning", lost, detail))
