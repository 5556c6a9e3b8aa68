"""Frame repair: frames on a uniform time grid, with gaps flagged and filled, or split."""

from dataclasses import dataclass

import numpy as np
import pandas as pd
from scipy.interpolate import PchipInterpolator

from ur5lib.errors import InputError
from ur5lib.recordings.columns import SUFFIXES
from ur5lib.recordings.ordering import in_order
from ur5lib.recordings.plausibility import SHORTEST_STEP, drop_implausible
from ur5lib.recordings.quality import Finding
from ur5lib.timeseries.arrays import Array, Labels, Mask

SMOOTH = ("actual_q_", "actual_qd_", "target_q_", "target_qd_")  # interpolated by PCHIP
OFF_GRID = 0.1  # cycles; how far a step may lie from a whole number of cycles
REGULAR = 0.95  # share of steps within OFF_GRID in a recording with a fixed cycle
JITTER = 5e-5  # s; larger jitter is reported
OWN = ("time", "epoch", "received")  # columns that are not channels


@dataclass(frozen=True)
class Timing:
    """The timing of the frames: the grid's period and the steps between timestamps, all in [s]."""

    period: float
    regular: bool
    longest_step: float
    jitter_median: float
    jitter_99: float


@dataclass(frozen=True)
class Stretch:
    """A run of frames without a split.

    lost: frames discarded in long gaps of a channel; crowded: frames discarded because another one
    occupies their slot.
    """

    table: pd.DataFrame
    lost: int
    crowded: int


def repair_frames(
    frames: pd.DataFrame, cycle: float | None, max_gap: float, source: str
) -> tuple[pd.DataFrame, Timing, list[Finding]]:
    """Return the frames in order on a uniform grid, each slot at most once, with gaps flagged.

    frames: `time` [s] and channels as read; cycle: the controller's [s], None to determine it;
    max_gap: [s]; source: the file, for messages. Returns `time`, `segment`, `interpolated`, the
    channels, and `filled_<channel>` for each channel with interpolated cells. Gaps up to `max_gap`
    are interpolated; longer ones split the recording: `segment` counts its parts from 0.
    Raises InputError when fewer than two frames are usable or the units must be wrong.
    """
    findings: list[Finding] = []
    _expect_frames(frames, source)
    frames = _whole_channels(frames, findings, source)
    frames = in_order(drop_implausible(frames, source, "robot", findings), findings)
    _expect_frames(frames, source)
    timing = _timing(frames, cycle, source)
    _report_steps(timing, findings)
    stretches = [
        _repair_stretch(stretch, timing, max_gap) for stretch in _stretches(frames, timing, max_gap)
    ]
    table = _number_segments(pd.concat([stretch.table for stretch in stretches], ignore_index=True))
    _expect_frames(table, source)
    _report_lost(frames, table, timing, findings)
    _report_discarded(stretches, findings)
    return table, timing, findings


def _expect_frames(frames: pd.DataFrame, source: str) -> None:
    if len(frames) < 2:
        raise InputError(
            f"{source}: contains only {len(frames)} complete frames; record at least a second"
        )


def _whole_channels(frames: pd.DataFrame, findings: list[Finding], source: str) -> pd.DataFrame:
    """Return the frames without channels that lack a column or are nowhere complete."""
    absent = [
        name
        for name, columns in _vectors(frames).items()
        if len(columns) < len(SUFFIXES.get(name, columns))
        or not np.isfinite(frames[columns].to_numpy(float)).all(axis=1).any()
    ]
    if "actual_q" in absent or "actual_q_0" not in frames:
        raise InputError(
            f"{source}: has no actual_q_0 to actual_q_5; record the joint positions, or name their "
            "columns in the study"
        )
    if absent:
        detail = f"{', '.join(absent)}: columns are missing or empty; the channel is ignored"
        findings.append(Finding("robot", "incomplete channels", "warning", len(absent), detail))
    columns = _vectors(frames)
    dropped = [column for name in absent for column in columns[name]]
    return frames.drop(columns=dropped).copy()  # in one block of memory, to which columns are added


def _timing(frames: pd.DataFrame, cycle: float | None, source: str) -> Timing:
    steps = frames["time"].diff()[frames["epoch"].diff() == 0].to_numpy()
    period = cycle or round(max(float(np.quantile(steps, 0.1)), SHORTEST_STEP), 4)
    off = np.abs(steps - period * np.rint(steps / period))
    regular = bool(cycle or np.mean(off <= OFF_GRID * period) >= REGULAR)
    if not regular:
        period = round(max(float(np.median(steps)), SHORTEST_STEP), 4)
        off = np.abs(steps - period)
    median, high = np.quantile(off, [0.5, 0.99])
    if median > period / 2 or np.median(steps) < period / 2:
        raise InputError(
            f"{source}: the steps between timestamps (median {np.median(steps):.3g} s) do not fit "
            f"a cycle of {period:g} s; check which column is the time, its unit, and whether it "
            "has lost digits"
        )
    return Timing(period, regular, float(steps.max()), float(median), float(high))


def _stretches(frames: pd.DataFrame, timing: Timing, max_gap: float) -> list[pd.DataFrame]:
    """Split the frames at clock resets and at gaps that are too long."""
    longest = max_gap + 1.5 * timing.period
    breaks = (frames["time"].diff() > longest) | (frames["epoch"].diff() > 0)
    return [stretch for _, stretch in frames.groupby(breaks.cumsum())]


def _repair_stretch(stretch: pd.DataFrame, timing: Timing, max_gap: float) -> Stretch:
    """Put one stretch on the grid and fill each channel over its own gaps."""
    time = stretch["time"].to_numpy()
    place = _places(time, timing)
    first = np.unique(np.rint(place) if timing.regular else place, return_index=True)[1]
    crowded = len(place) - len(first)
    place, stretch = place[first], stretch.iloc[first]
    slots = np.arange(int(np.floor(place[-1] + 1e-6)) + 1)
    channels, flags, lost = _fill_channels(stretch, place, slots, timing, max_gap)
    table = pd.DataFrame({"time": time[0] + slots * timing.period, **channels})
    table.insert(1, "interpolated", np.logical_or.reduce([*flags.values()]) if flags else lost)
    for name, flag in flags.items():
        if flag.any():
            table[f"filled_{name}"] = flag
    return Stretch(table[~lost].assign(slot=slots[~lost]), int(lost.sum()), crowded)


def _fill_channels(
    stretch: pd.DataFrame, place: Array, slots: Labels, timing: Timing, max_gap: float
) -> tuple[dict[str, Array], dict[str, Mask], Mask]:
    """Return the columns at the slots, which slots each channel had filled, and the lost slots.

    A slot is lost if any channel has a long gap there, or is missing altogether.
    """
    columns_at: dict[str, Array] = {}
    flags: dict[str, Mask] = {}
    lost = np.zeros(len(slots), dtype=bool)
    for name, columns in _vectors(stretch).items():
        values = stretch[columns].to_numpy(float)
        known = np.isfinite(values).all(axis=1)
        if not known.any():
            lost[:] = True
            continue
        filled, flags[name], beyond = _fill(
            place[known], values[known], slots, timing, max_gap, name
        )
        lost |= beyond
        columns_at |= dict(zip(columns, filled.T, strict=True))
    return columns_at, flags, lost


def _places(time: Array, timing: Timing) -> Array:
    """Return the positions of the timestamps on the grid, in periods from the first."""
    if not timing.regular:
        return (time - time[0]) / timing.period
    # Rounding each step by itself keeps the jitter of the timestamps from adding up.
    return np.concatenate([[0.0], np.cumsum(np.rint(np.diff(time) / timing.period))])


def _fill(
    place: Array, values: Array, slots: Labels, timing: Timing, max_gap: float, name: str
) -> tuple[Array, Mask, Mask]:
    """Return values at the slots, which were not received, and which lie in too long a gap."""
    after = np.clip(np.searchsorted(place, slots), 0, len(place) - 1)
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
        filled[inexact] = _interpolate(place, values, slots[inexact], name)
    return filled, missing, beyond


def _interpolate(place: Array, values: Array, slots: Labels, name: str) -> Array:
    if f"{name}_" in SMOOTH:
        return PchipInterpolator(place, values, axis=0)(slots)
    return np.stack([np.interp(slots, place, column) for column in values.T], axis=1)


def _vectors(frames: pd.DataFrame) -> dict[str, list[str]]:
    """Return the columns of each channel: six for actual_q."""
    vectors: dict[str, list[str]] = {}
    for column in frames.columns.difference(OWN, sort=False):
        name, _, suffix = column.rpartition("_")
        vectors.setdefault(name if suffix.isdigit() else column, []).append(column)
    return vectors


def _number_segments(table: pd.DataFrame) -> pd.DataFrame:
    """Add `segment`, which counts the gapless parts from 0, and set empty flags to False."""
    flags = table.filter(like="filled_").columns
    table[flags] = table[flags].fillna(False).astype(bool)
    table.insert(1, "segment", (table["slot"].diff().fillna(1) != 1).cumsum())
    return table.drop(columns="slot")


def _report_steps(timing: Timing, findings: list[Finding]) -> None:
    spread = f"{1000 * timing.jitter_99:.2g} ms (99 %)"
    grid = f"{1000 * timing.period:g} ms"
    if not timing.regular:
        detail = (
            f"time steps vary by {spread} around {grid}; signals are interpolated onto a uniform "
            "grid"
        )
        findings.append(Finding("robot", "irregular steps", "note", 1, detail))
    elif timing.jitter_99 > JITTER:
        median = f"{1000 * timing.jitter_median:.2g} ms (median)"
        detail = (
            f"timestamps deviate from the {grid} grid by {median}, {spread}; snapped to the grid"
        )
        findings.append(Finding("robot", "jitter", "note", 1, detail))


def _report_lost(
    frames: pd.DataFrame, table: pd.DataFrame, timing: Timing, findings: list[Finding]
) -> None:
    filled = int(table["interpolated"].sum())
    steps = frames["time"].diff()[frames["epoch"].diff() == 0]
    lost = int((np.rint(steps / timing.period) - 1).clip(lower=0).sum())
    if not timing.regular:
        flags = table.filter(like="filled_")
        lost = int(flags.all(axis=1).sum()) if flags.shape[1] == len(_vectors(frames)) else 0
    if lost:
        common = (1000 * timing.period * np.rint(steps / timing.period)).value_counts().head(3)
        pattern = ", ".join(f"{count} of {step:g} ms" for step, count in common.items())
        longest = f"longest {1000 * timing.longest_step:.0f} ms"
        detail = f"most frequent steps: {pattern}; {longest}; {filled} frames interpolated"
        findings.append(Finding("robot", "lost frames", "warning", lost, detail))
    holes = int((~np.isfinite(frames.drop(columns="time").to_numpy())).any(axis=1).sum())
    if holes:
        detail = "some channels have missing cells; they are interpolated"
        findings.append(Finding("robot", "missing cells", "warning", holes, detail))
    splits = int(table["segment"].max())
    if splits:
        detail = (
            "gaps are too long to fill; the recording is split, nothing is computed across them"
        )
        findings.append(Finding("robot", "split", "warning", splits, detail))


def _report_discarded(stretches: list[Stretch], findings: list[Finding]) -> None:
    lost = sum(stretch.lost for stretch in stretches)
    if lost:
        detail = "a channel is missing for too long, or at the start or end; frames discarded"
        findings.append(Finding("robot", "incomplete frames", "warning", lost, detail))
    crowded = sum(stretch.crowded for stretch in stretches)
    if crowded:
        detail = "several frames fall into one cycle; only the first is kept"
        findings.append(Finding("robot", "crowded frames", "warning", crowded, detail))
