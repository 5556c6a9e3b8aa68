"""Frame repair: back onto the controller's own uniform grid, with gaps marked."""

import numpy as np
import pandas as pd

from ur5lib.recordings.quality import Finding


def to_grid(
    frames: pd.DataFrame, period: float, max_gap: float
) -> tuple[pd.DataFrame, list[Finding]]:
    """Frames on the grid time = first stamp + k period, ordered, each slot at most once.

    frames: `time` [s] and channels, one row per frame; period, max_gap: [s].
    Gaps up to `max_gap` are interpolated linearly and flagged in `interpolated`; longer ones
    split the recording: `segment` counts the stretches between them from 0.
    """
    frames = frames.sort_values("time", kind="stable")
    start = frames["time"].iloc[0]
    # Steps are counted one by one, so that a jitter of the stamps does not add up.
    steps = (frames["time"].diff().fillna(0.0) / period).round().astype(int)
    frames = frames.assign(slot=steps.cumsum())
    repeated = int(frames["slot"].duplicated().sum())
    frames = frames.drop_duplicates("slot").set_index("slot")

    grid = frames.reindex(range(frames.index[-1] + 1))
    missing = grid["time"].isna()
    gap_length = missing.groupby((~missing).cumsum()).transform("sum") * period
    split = missing & (gap_length > max_gap + period / 2)
    grid = grid.interpolate(limit_area="inside")
    grid["time"] = start + grid.index * period
    grid["segment"] = (split & ~split.shift(fill_value=False)).cumsum()
    grid["interpolated"] = missing
    findings = _findings(missing, split, gap_length, period, repeated)
    channels = [name for name in frames.columns if name != "time"]
    order = ["time", "segment", "interpolated", *channels]
    return grid.loc[~split, order].reset_index(drop=True), findings


def _findings(
    missing: pd.Series, split: pd.Series, gap_length: pd.Series, period: float, repeated: int
) -> list[Finding]:
    findings = []
    if repeated:
        detail = f"frames that share a {1000 * period:g} ms slot with an earlier one are left out"
        findings.append(Finding("robot", "repeated frames", "warning", repeated, detail))
    filled = int((missing & ~split).sum())
    if missing.any():
        longest = 1000 * float(np.max(gap_length[missing]))
        detail = f"of {len(missing)} frames; longest gap {longest:g} ms; {filled} interpolated"
        findings.append(Finding("robot", "lost frames", "warning", int(missing.sum()), detail))
    return findings
