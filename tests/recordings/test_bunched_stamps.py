"""Rows that share a stamp or arrive in bursts are put at equal steps; others keep their time."""

from collections.abc import Callable

import numpy as np
import pandas as pd
import pytest

from ur5lib.errors import InputError
from ur5lib.recordings.bunched_stamps import evenly_stamped
from ur5lib.recordings.frames import repair_frames
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding
from ur5lib.tables import channel, named
from ur5lib.timeseries.arrays import Array

COUNT, STEP = 2500, 0.008
TIME = STEP * np.arange(COUNT)
DRAW = np.random.default_rng(4)
ENDS = np.cumsum(DRAW.integers(5, 15, COUNT // 5))  # of bursts, of different sizes
BURST = ENDS[np.searchsorted(ENDS, np.arange(COUNT), side="right")].clip(max=COUNT - 1)
PLACE = np.arange(COUNT) - np.searchsorted(BURST, BURST)


def rows(time: Array, kept: Array | None = None) -> pd.DataFrame:
    q = np.sin(np.outer(TIME, [1.0, 1.3, 0.7, 0.9, 1.1, 0.8]))
    rates = np.gradient(q, TIME, axis=0)
    those = np.arange(COUNT) if kept is None else kept
    return pd.DataFrame(
        {"time": time, **named(q[those], "actual_q"), **named(rates[those], "actual_qd")}
    )


def repaired(frames: pd.DataFrame) -> tuple[pd.DataFrame, float, dict[str, int]]:
    table, timing, findings = repair_frames(frames, None, 0.1, "run.csv")
    return table, timing.period, {one.code: one.count for one in findings}


BUNCHED: dict[str, Callable[[Array], Array]] = {
    "whole seconds": np.floor,
    "tenths of a second": lambda time: np.floor(10 * time) / 10,
    "seconds that are rounded": np.round,
    "bursts of ten": lambda time: time[np.minimum(np.arange(COUNT) // 10 * 10 + 9, COUNT - 1)],
    "bursts, 10 µs apart": lambda time: time[BURST] + 1e-5 * PLACE,
    "bursts, 0.2 ms apart": lambda time: time[BURST] + 2e-4 * PLACE,
}


@pytest.mark.parametrize("kind", BUNCHED)
def test_every_row_is_kept_at_an_equal_step(kind: str) -> None:
    frames = rows(BUNCHED[kind](TIME))
    q = channel(frames, "actual_q")
    table, period, findings = repaired(frames)
    assert period == STEP
    np.testing.assert_array_equal(channel(table, "actual_q"), q)
    assert findings.keys() == {Found.BUNCHED_STAMPS}
    assert findings[Found.BUNCHED_STAMPS] > COUNT / 2


@pytest.mark.parametrize("lost", [slice(700, 900), slice(1190, 2400)])
def test_a_pause_between_bunches_stays(lost: slice) -> None:
    kept = np.delete(np.arange(COUNT), lost)
    frames = rows(np.floor(TIME[kept]), kept)
    table, period, findings = repaired(frames)
    assert (period, len(table)) == (STEP, len(kept))
    assert table["segment"].max() == 1
    missing = lost.stop - lost.start
    assert findings[Found.LOST_FRAMES] == pytest.approx(missing, abs=1 / STEP)


def unchanged(frames: pd.DataFrame) -> bool:
    findings: list[Finding] = []
    return evenly_stamped(frames, findings) is frames and not findings


def test_rows_with_times_of_their_own_stay() -> None:
    late = TIME + np.where(np.arange(COUNT) > 1200, 1000.0, 0.0)
    stale = np.where(np.arange(COUNT) % 9 == 4, np.roll(TIME, 1), TIME)
    shuffled = TIME[DRAW.permutation(COUNT)]
    restarted = np.where(np.arange(COUNT) > 1200, TIME - 9.0, TIME)
    for time in (TIME, late, stale, shuffled, restarted, TIME + DRAW.exponential(0.002, COUNT)):
        assert unchanged(rows(time))
    assert unchanged(rows(TIME[:2], np.arange(2)))


def test_rows_that_a_recorder_polls_are_dropped_as_before() -> None:
    polled = np.repeat(np.arange(COUNT), 4)
    assert unchanged(rows(TIME[polled], polled))
    assert repaired(rows(TIME[polled], polled))[2] == {Found.REPEATED_FRAMES: 3 * COUNT}


def test_rows_of_other_topics_have_no_positions() -> None:
    """Three topics, each in rows of its own, 10 µs after the positions."""
    times = (TIME[:, None] + 1e-5 * np.arange(4)).ravel()
    frames = rows(TIME).loc[np.repeat(np.arange(COUNT), 4)].reset_index(drop=True)
    frames["time"] = times
    frames.loc[np.arange(4 * COUNT) % 4 > 0, [n for n in frames if n != "time"]] = np.nan
    assert unchanged(frames)


def test_a_time_in_another_unit_is_said() -> None:
    with pytest.raises(InputError, match="check that the time column is in seconds"):
        repaired(rows(TIME / 3600))


def test_packets_that_overtake_each_other_are_of_one_rate() -> None:
    """Some wait for 0.1 s, and arrive with those behind them."""
    waits = 0.1 * (np.random.default_rng(2).random(COUNT) < 0.1)
    received = np.maximum.accumulate(TIME[BURST] + waits[BURST]) + 1e-5 * PLACE
    assert (np.diff(received) < 0).any()
    table, period, findings = repaired(rows(received))
    assert period == STEP
    assert abs(len(table) - COUNT) < 0.01 * COUNT
    assert Found.BUNCHED_STAMPS in findings
