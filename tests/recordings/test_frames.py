"""Frame repair: back onto a uniform grid, in order, each slot once, gaps marked."""

from collections.abc import Sequence
from functools import cache

import numpy as np
import pandas as pd
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import PchipInterpolator

from tests.conftest import said
from ur5lib.channels import columns
from ur5lib.errors import InputError
from ur5lib.recordings.frames import repair_frames
from ur5lib.recordings.ordering import in_order
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding
from ur5lib.timeseries.sampling import interpolated

CYCLE = 0.008
COUNT = 120
RANDOM = np.random.default_rng(0)
NOISE = RANDOM.normal(size=(10_000, 6))


def frames(slots: Sequence[int] | np.ndarray = range(COUNT), cycle: float = CYCLE) -> pd.DataFrame:
    """A parabola in the positions, a line in the velocities, noise in the currents."""
    time = 0.05 + cycle * np.array(slots)
    columns = {"time": time}
    for joint in range(6):
        columns[f"actual_q_{joint}"] = 0.1 * time**2
        columns[f"actual_qd_{joint}"] = 0.2 * time
        columns[f"actual_current_{joint}"] = NOISE[np.array(slots), joint]
    return pd.DataFrame(columns)


def repair(
    table: pd.DataFrame, max_gap: float = 0.1, cycle: float | None = CYCLE
) -> tuple[pd.DataFrame, dict[str, Finding]]:
    repaired, _, findings = repair_frames(table.copy(), cycle, max_gap, "run.csv")
    return repaired, {finding.code: finding for finding in findings}


def without_flags(table: pd.DataFrame) -> pd.DataFrame:
    return table.drop(columns=["segment", "interpolated"])


def test_complete_frames_pass_unchanged() -> None:
    repaired, findings = repair(frames())
    assert findings == {}
    assert list(repaired)[:3] == ["time", "segment", "interpolated"]
    assert repaired["segment"].eq(0).all()
    assert not repaired["interpolated"].any()
    pd.testing.assert_frame_equal(without_flags(repaired), frames(), check_like=True)


@pytest.mark.parametrize("cycle", [0.002, 0.008])
def test_the_cycle_is_found_where_it_is_not_reported(cycle: float) -> None:
    slots = sorted({*range(0, 100), *range(103, 400)} - {17, 203, 204})
    repaired, findings = repair(frames(slots, cycle), cycle=None)
    np.testing.assert_allclose(np.diff(repaired["time"]), cycle)
    assert set(findings) == {Found.LOST_FRAMES}


lost_slots = st.sets(st.integers(1, COUNT - 2), max_size=70)


@settings(max_examples=50)
@given(lost_slots)
def test_short_gaps_are_filled_and_flagged(lost: set[int]) -> None:
    kept = [slot for slot in range(COUNT) if slot not in lost]
    repaired, findings = repair(frames(kept), max_gap=10.0)
    assert set(repaired.index[repaired["interpolated"]]) == lost
    assert sum(finding.count for finding in findings.values()) == len(lost)
    assert repaired["segment"].eq(0).all()
    received = ~repaired["interpolated"]
    pd.testing.assert_frame_equal(without_flags(repaired)[received][frames().columns],
                                  frames()[received])  # fmt: skip
    np.testing.assert_allclose(repaired["actual_qd_0"], 0.2 * repaired["time"])  # a line is kept
    assert (repaired["actual_q_0"].diff()[1:] > 0).all()  # and a rise is


@settings(max_examples=50)
@given(lost_slots)
def test_long_gaps_split_and_hold_no_data(lost: set[int]) -> None:
    kept = [slot for slot in range(COUNT) if slot not in lost]
    repaired, _ = repair(frames(kept), max_gap=0.0)
    pd.testing.assert_frame_equal(without_flags(repaired), frames(kept), check_like=True)
    assert not repaired["interpolated"].any()
    breaks = np.flatnonzero(np.diff(kept) > 1) + 1
    np.testing.assert_array_equal(np.flatnonzero(repaired["segment"].diff().fillna(0)), breaks)


@cache
def ordered() -> pd.DataFrame:
    return repair(frames(range(40)))[0]


@settings(max_examples=50)
@given(st.permutations(range(40)), st.lists(st.integers(0, 39), max_size=10))
def test_order_and_repeats_do_not_matter(order: list[int], repeated: list[int]) -> None:
    clean = ordered()
    mixed, findings = repair(frames([*order, *repeated]))
    pd.testing.assert_frame_equal(mixed, clean)
    assert (Found.REPEATED_FRAMES in findings) == bool(repeated)
    if repeated:
        assert findings[Found.REPEATED_FRAMES].count == len(repeated)


def test_two_frames_are_a_recording() -> None:
    repaired, findings = repair(frames(range(2)))
    assert findings == {}
    pd.testing.assert_frame_equal(without_flags(repaired), frames(range(2)), check_like=True)


def test_new_data_under_an_old_stamp_go_to_the_next_slot() -> None:
    """As seen in real 500 Hz recordings."""
    stale = frames()
    stale.loc[30, "time"] = stale.loc[29, "time"]
    repaired, findings = repair(stale)
    assert findings[Found.STALE_STAMPS].count == 1
    assert list(in_order(stale, []).index) == [*range(COUNT)]
    np.testing.assert_allclose(repaired["actual_current_0"], frames()["actual_current_0"])


def test_old_data_under_a_new_stamp_are_a_lost_frame() -> None:
    stale = frames()
    channels = stale.columns.drop("time")
    stale.loc[30, channels] = stale.loc[29, channels]
    repaired, findings = repair(stale)
    assert findings[Found.STALE_DATA].count == 1
    assert list(in_order(stale, [])) == [*stale, "epoch"]
    assert list(repaired.index[repaired["interpolated"]]) == [30]
    assert repaired["actual_q_0"][30] == pytest.approx(frames()["actual_q_0"][30], rel=1e-3)


def test_data_of_a_lost_frame_return_to_their_own_time() -> None:
    """Frame 99 was lost, and frame 100 has its data."""
    late = frames()
    channels = late.columns.drop("time")
    late.loc[100, channels] = late.loc[99, channels]
    repaired, findings = repair(late.drop(index=99))
    assert findings[Found.LATE_DATA].count == 1
    assert list(repaired.index[repaired["interpolated"]]) == [100]
    np.testing.assert_allclose(repaired["actual_current_0"][99], frames()["actual_current_0"][99])
    assert repaired["actual_q_0"][100] == pytest.approx(frames()["actual_q_0"][100], rel=1e-4)


def test_an_arm_at_rest_is_no_stale_data() -> None:
    rest = frames()
    rest[rest.columns.drop("time")] = 0.25
    repaired, findings = repair(rest)
    assert findings == {}
    assert len(repaired) == COUNT


def test_a_reset_clock_splits_the_recording() -> None:
    """And its time goes on, as all that follows needs it."""
    twice = pd.concat([frames(range(60, 120)), frames(range(70))], ignore_index=True)
    repaired, findings = repair(twice)
    assert findings[Found.CLOCK_RESET].count == 1
    np.testing.assert_allclose(repaired["time"], 0.05 + CYCLE * np.arange(60, 190))
    assert repaired["segment"].tolist() == [0] * 60 + [1] * 70
    np.testing.assert_array_equal(repaired["actual_current_0"], twice["actual_current_0"])


def test_missing_cells_are_filled_and_flagged_by_channel() -> None:
    holes = frames()
    holes.loc[50:52, "actual_q_3"] = np.nan
    repaired, findings = repair(holes)
    assert findings[Found.MISSING_CELLS].count == 3
    assert repaired.index[repaired["filled_actual_q"]].tolist() == [50, 51, 52]
    assert "filled_actual_current" not in repaired
    np.testing.assert_array_equal(repaired["actual_current_3"], frames()["actual_current_3"])
    assert repaired["actual_q_3"][51] == pytest.approx(frames()["actual_q_3"][51], rel=1e-3)


def test_steps_that_fit_no_cycle_are_interpolated_in_time() -> None:
    """As in the UR10e's logs: 10 and 12 ms, on average 10.6."""
    steps = np.random.default_rng(0).choice([0.010, 0.012], 500, p=[0.7, 0.3])
    time = np.cumsum(steps)
    table = pd.DataFrame({"time": time, **{f"actual_q_{j}": 0.1 * time**2 for j in range(6)}})
    repaired, findings = repair(table, cycle=None)
    assert list(findings) == [Found.IRREGULAR_STEPS]
    np.testing.assert_allclose(np.diff(repaired["time"]), 0.010)
    np.testing.assert_allclose(repaired["actual_q_0"], 0.1 * repaired["time"] ** 2, atol=1e-5)
    assert not repaired["interpolated"].any()


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda t: t.drop(columns="actual_q_3"), "run.csv: has no actual_q_3; record the"),
        (lambda t: t.assign(actual_q_3=np.nan), "run.csv: has no actual_q_3; record the"),
        (lambda t: t.drop(columns=columns("actual_q")), "has no actual_q_0 to actual_q_5; record"),
        (lambda t: t[:1], "run.csv: contains only 1 complete frames; record at least a second"),
    ],
)  # fmt: skip
def test_what_cannot_be_repaired_is_reported(change: object, sentence: str) -> None:
    with pytest.raises(InputError, match=sentence):
        repair(change(frames()))


@pytest.mark.parametrize("swaps", [0, 1, 2])
def test_each_frame_out_of_order_is_counted(swaps: int) -> None:
    place = np.arange(200)
    for first in (50, 120)[:swaps]:
        place[[first, first + 1]] = place[[first + 1, first]]
    findings: list[Finding] = []
    frames = pd.DataFrame({"time": 0.008 * place, "actual_q_0": np.sin(place)})
    ordered = in_order(frames, findings)
    assert [(one.code, one.count) for one in findings] == [
        (Found.FRAMES_OUT_OF_ORDER, swaps) for _ in range(min(swaps, 1))
    ]
    np.testing.assert_array_equal(ordered["actual_q_0"], np.sin(np.arange(200)))
    assert list(ordered.index) == [*range(200)]
    assert (ordered["epoch"] == 0).all()


@pytest.mark.parametrize("whole", [True, False])
@pytest.mark.parametrize(("lost", "filled"), [(10, True), (11, False)])
def test_a_gap_is_as_long_as_what_is_missing(lost: int, filled: bool, whole: bool) -> None:
    """Ten cycles of 8 ms are 80 ms, of whole frames or of a channel; one more is too long."""
    table = frames()
    if whole:
        table = table.drop(index=range(30, 30 + lost))
    else:
        table.loc[30 : 29 + lost, "actual_current_0"] = np.nan
    repaired, findings = repair(table, max_gap=0.08)
    assert repaired["interpolated"].sum() == (lost if filled else 0)
    assert len(repaired) == COUNT - (0 if filled else lost)
    if whole:
        assert findings[Found.LOST_FRAMES].count == lost
        assert list(findings) == [Found.LOST_FRAMES] + ["split"] * (not filled)
    else:
        assert list(findings) == [
            Found.MISSING_CELLS,
            *["split", Found.INCOMPLETE_FRAMES] * (not filled),
        ]


def test_the_pattern_of_lost_frames_is_reported() -> None:
    """The three most frequent steps, the longest, and what was interpolated."""
    kept = sorted({*range(COUNT)} - {10, 20, 30, 31, 40, 41, 42, 50, 51, 52, 53})
    _, findings = repair(frames(kept), max_gap=0.025)
    assert said(findings[Found.LOST_FRAMES]) == (
        "most frequent steps: 103 of 8 ms, 2 of 16 ms, 1 of 24 ms; longest 40 ms; 7 interpolated"
    )


@pytest.mark.parametrize(("shake", "reported"), [(4.5e-5, False), (5.5e-5, True)])
def test_jitter_is_told_above_fifty_microseconds(shake: float, reported: bool) -> None:
    """Of the steps: every other frame is late, so that each step deviates by as much."""
    shaken = frames()
    shaken.loc[::2, "time"] += shake
    repaired, findings = repair(shaken)
    assert list(findings) == ["jitter"] * reported
    if reported:
        detail = "deviate from the 8 ms grid by 0.055 ms (median), 0.055 ms (99 %); snapped"
        assert detail in said(findings["jitter"])
    np.testing.assert_allclose(np.diff(repaired["time"]), CYCLE)


@pytest.mark.parametrize(("share", "regular"), [(0.04, True), (0.06, False)])
@pytest.mark.parametrize(("off", "counts"), [(0.09, False), (0.11, True)])
def test_a_cycle_is_fixed_if_nearly_all_steps_are_whole_ones(
    share: float, regular: bool, off: float, counts: bool
) -> None:
    """A twentieth may be off, by more than a tenth of a cycle."""
    steps = np.full(1000, CYCLE)
    steps[np.arange(round(1000 * share)) * 16 + 5] += off * CYCLE
    shaken = frames(range(1001))
    shaken["time"] = np.concatenate([[0.0], np.cumsum(steps)])
    _, timing, findings = repair_frames(shaken, None, 0.1, "run.csv")
    assert timing.regular == (regular or not counts)
    assert timing.period == CYCLE
    assert timing.longest_step == pytest.approx((1 + off) * CYCLE)
    assert (Found.IRREGULAR_STEPS in {one.code for one in findings}) != timing.regular


def test_a_channel_that_ends_early_takes_its_frames_along() -> None:
    short = frames()
    short.loc[110:, "actual_current_2"] = np.nan
    repaired, findings = repair(short)
    assert len(repaired) == 110
    assert findings[Found.INCOMPLETE_FRAMES].count == 10
    late = frames()
    late.loc[:4, "actual_current_2"] = np.nan
    repaired, findings = repair(late)
    assert repaired["time"].iloc[0] == pytest.approx(0.05 + 5 * CYCLE)
    assert findings[Found.INCOMPLETE_FRAMES].count == 5


def test_of_frames_in_one_slot_the_first_is_kept() -> None:
    crowded = frames()
    crowded.loc[31:, "time"] -= 0.6 * CYCLE  # a step of 0.4 cycles, then on by whole ones
    repaired, findings = repair(crowded)
    assert findings[Found.CROWDED_FRAMES].count == 1
    assert len(repaired) == COUNT - 1
    currents = frames()["actual_current_0"].drop(31)
    np.testing.assert_array_equal(repaired["actual_current_0"], currents)


def test_channels_that_are_not_whole_are_ignored_by_name() -> None:
    lacking = frames().drop(columns="actual_qd_5").assign(actual_current_1=np.nan)
    repaired, findings = repair(lacking)
    assert not [name for name in repaired if name.startswith(("actual_qd", "actual_current"))]
    assert findings[Found.INCOMPLETE_CHANNELS].count == 2
    assert said(findings[Found.INCOMPLETE_CHANNELS]).startswith(
        "actual_qd, actual_current: columns"
    )


def test_positions_are_interpolated_in_shape_and_other_channels_by_lines() -> None:
    """As PCHIP and np.interp do between what was received."""
    kept = np.delete(np.arange(COUNT), [50, 51, 70])
    repaired, _ = repair(frames([*kept]))
    given, slots = frames([*kept]), np.arange(COUNT)
    smooth = PchipInterpolator(kept, given["actual_q_4"])(slots)
    np.testing.assert_allclose(repaired["actual_q_4"], smooth, rtol=1e-12)
    line = np.interp(slots, kept, given["actual_current_4"])
    np.testing.assert_allclose(repaired["actual_current_4"], line, rtol=1e-12)


def test_noise_that_repeats_once_in_a_while_is_stale_only_if_currents_are_noisy() -> None:
    """Of an arm whose currents change in nine of ten frames; one at rest may repeat itself."""
    for changes, stale in ((0.85, False), (0.95, True)):
        table = frames(range(1000))
        rest = np.random.default_rng(0).random(1000) > changes
        currents = [f"actual_current_{joint}" for joint in range(6)]
        table.loc[rest, currents] = np.nan
        table[currents] = table[currents].ffill().fillna(0.0)
        columns = table.columns.drop("time")
        table.loc[500, columns] = table.loc[499, columns]
        findings = repair(table)[1]
        assert (Found.STALE_DATA in findings) == stale


def irregular(lost: range) -> pd.DataFrame:
    """Every fourth step takes 12 ms, the others 10 ms; lines in positions and currents."""
    time = np.delete(np.cumsum(np.tile([0.010, 0.010, 0.010, 0.012], 50)), lost)
    names = [f"{channel}_{j}" for channel in ("actual_q", "actual_current") for j in range(6)]
    return pd.DataFrame({"time": time} | dict.fromkeys(names, 0.1 * time))


@pytest.mark.parametrize("lost", [1, 2, 5])
def test_among_irregular_steps_what_is_further_than_one_from_any_frame_is_filled(lost: int) -> None:
    """Those frames are lost, but not the ones that lack a channel only."""
    given = irregular(range(90, 90 + lost))
    given.loc[30:34, "actual_current_2"] = np.nan
    repaired, findings = repair(given, cycle=None)
    away = np.abs(repaired["time"].to_numpy()[:, None] - given["time"].to_numpy()).min(axis=1)
    far = away > 0.010
    filled = repaired.get("filled_actual_q", pd.Series(False, repaired.index))
    np.testing.assert_array_equal(filled, far)
    assert repaired["interpolated"].sum() > far.sum() == lost - 1
    assert findings[Found.MISSING_CELLS].count == 5
    assert (Found.LOST_FRAMES in findings) == far.any()
    if far.any():
        assert findings[Found.LOST_FRAMES].count == far.sum()
    np.testing.assert_allclose(repaired["actual_current_2"], 0.1 * repaired["time"], atol=1e-9)


@pytest.mark.parametrize("known", [[], [3], [3, 5]])
def test_of_a_part_that_lacks_a_channel_only_what_lies_between_its_cells_is_kept(
    known: list[int],
) -> None:
    """After a clock reset, from which on the channel is missing but for some cells."""
    twice = pd.concat([frames(range(60, 120)), frames(range(70))], ignore_index=True)
    twice.loc[60 + np.delete(np.arange(70), known), "actual_q_2"] = np.nan
    repaired, findings = repair(twice)
    kept = range(known[0], known[-1] + 1) if known else range(0)
    on = CYCLE * 120  # by which the time goes on after the reset
    expected = [*frames(range(60, 120))["time"], *(on + frames()["time"].iloc[[*kept]])]
    np.testing.assert_allclose(repaired["time"], expected)
    assert findings[Found.INCOMPLETE_FRAMES].count == 70 - len(kept)
    assert repaired["interpolated"].sum() == max(len(known) - 1, 0)
    own = np.array(expected) - on * (np.arange(len(expected)) >= 60)
    np.testing.assert_allclose(repaired["actual_q_2"], 0.1 * own**2, atol=1e-5)


@pytest.mark.parametrize("of", ["actual_q", "actual_current"])
def test_channels_may_have_rates_of_their_own(of: str) -> None:
    """A log of several topics: each of its rows has one of them, or all have the faster one."""
    table = frames(range(600), 0.002)
    slow = [name for name in table if name.startswith(of)]
    table.loc[table.index % 3 != 0, slow] = np.nan
    repaired, timing, findings = repair_frames(table.copy(), None, 0.1, "run.csv")
    assert timing.period == (0.006 if of == "actual_q" else 0.002)
    assert len(repaired) == (200 if of == "actual_q" else 598)  # to the last sample of all
    assert not repaired["interpolated"].any()
    assert (Found.SLOW_CHANNELS in {one.code for one in findings}) == (of != "actual_q")
    rows = table.dropna()
    at_samples = repaired.set_index(repaired["time"].round(6)).loc[rows["time"].round(6)]
    np.testing.assert_allclose(at_samples[slow], rows[slow], atol=1e-12)


def test_rows_of_one_topic_each_are_one_log() -> None:
    """As an outer join of both by time writes them."""
    table = frames(range(600), 0.002)
    positions = [name for name in table if name.startswith("actual_q")]
    table.loc[::2, [name for name in table if "current" in name]] = np.nan
    table.loc[1::2, positions] = np.nan
    repaired, timing, _ = repair_frames(table.copy(), None, 0.1, "run.csv")
    assert timing.period == 0.004
    assert repaired["interpolated"].mean() < 0.02
    np.testing.assert_allclose(repaired["actual_q_3"], 0.1 * repaired["time"] ** 2, atol=1e-9)
    between = interpolated(repaired["time"], table["time"][1::2], NOISE[1:600:2])
    inner = slice(1, -1)
    currents = repaired[[f"actual_current_{k}" for k in range(6)]]
    np.testing.assert_allclose(currents[inner], between[inner], atol=1e-9)


def test_jitter_is_that_of_the_median_step_and_of_one_in_a_hundred() -> None:
    """A frame in twenty is late by 0.2 ms, so that a step in ten deviates."""
    shaken = frames()
    shaken.loc[10::20, "time"] += 2e-4
    _, timing, findings = repair_frames(shaken, None, 0.1, "run.csv")
    assert timing.period == CYCLE
    assert timing.jitter_median == pytest.approx(0.0, abs=1e-9)
    assert timing.jitter_99 == pytest.approx(2e-4)
    assert [one.code for one in findings] == ["jitter"]


def test_the_cycle_is_a_tenth_of_a_millisecond_exact() -> None:
    """Though stamps jitter by 30 µs."""
    shaken = frames(range(1000))
    shaken["time"] += np.random.default_rng(0).uniform(-3e-5, 3e-5, 1000)
    assert repair_frames(shaken, None, 0.1, "run.csv")[1].period == CYCLE


def test_the_cycle_is_a_step_that_one_in_nine_takes() -> None:
    """Of a recording that lost nearly every other frame."""
    kept = np.cumsum(np.tile([2, 2, 2, 2, 2, 2, 2, 2, 1], 12)) - 2
    timing = repair_frames(frames([*kept]), None, 0.1, "run.csv")[1]
    assert (timing.period, timing.regular) == (CYCLE, True)


def test_a_stale_stamp_does_not_hide_that_the_clock_was_reset() -> None:
    slots = [*range(20), 19, *range(21, 60), *range(60)]
    stale = frames(slots).assign(actual_current_0=0.1 * np.arange(120))
    repaired, findings = repair(stale)
    assert (findings[Found.CLOCK_RESET].count, findings[Found.STALE_STAMPS].count) == (1, 1)
    np.testing.assert_array_equal(repaired["actual_current_0"], 0.1 * np.arange(120))


@pytest.mark.parametrize("beside", [{}, {"received": 0.0}, {"ft_fx": 3.0}])
@pytest.mark.parametrize("rate", [110, 150, 250])
def test_what_a_faster_recorder_polls_again_is_dropped(rate: int, beside: dict[str, float]) -> None:
    """At irregular times, which it may write beside: so may another device."""
    random = np.random.default_rng(rate)
    polled = np.cumsum(np.clip(random.exponential(1 / rate, 10 * rate), 2e-5, 0.1))
    slots = np.floor(polled / CYCLE).astype(int)
    written = frames(slots).assign(**{name: size * polled for name, size in beside.items()})
    repaired, findings = repair(written, cycle=None)
    expected, _ = repair(frames(np.unique(slots)))
    pd.testing.assert_frame_equal(repaired[[*expected]], expected)
    assert findings[Found.REPEATED_FRAMES].count == len(slots) - len(np.unique(slots))
    assert findings.keys() == {Found.REPEATED_FRAMES, Found.LOST_FRAMES}


def test_time_goes_on_after_every_reset() -> None:
    runs = [frames(range(60)).assign(actual_q_0=float(k)) for k in range(3)]
    time = in_order(pd.concat(runs, ignore_index=True), [])["time"]
    np.testing.assert_allclose(time, 0.05 + CYCLE * np.arange(180))


def test_what_a_reset_clock_shows_again_is_no_repeat() -> None:
    """Some frames after the reset are by chance as before it."""
    first, second = frames(range(60)), frames(range(60))
    second.loc[5:, "actual_current_0"] += 1.0
    both = pd.concat([first, second], ignore_index=True)
    repaired, findings = repair(both)
    assert list(findings) == [Found.CLOCK_RESET, "split"]
    np.testing.assert_array_equal(repaired["actual_current_0"], both["actual_current_0"])


def uniform(travel: float, shown: np.ndarray, lost: int) -> pd.DataFrame:
    """A motion at one speed [rad a cycle, of all joints], without one frame; shown: cycles."""
    table = pd.DataFrame({"time": CYCLE * np.arange(len(shown))})
    for joint in range(6):
        table[f"actual_q_{joint}"] = travel / np.sqrt(6) * shown
        table[f"actual_qd_{joint}"] = travel / np.sqrt(6) / CYCLE
    return table.drop(index=lost)


@pytest.mark.parametrize(
    ("travel", "rows", "late", "returned"),
    [
        (3e-3, [60], 0.6, True),  # by more than half a cycle
        (3e-3, [60], 0.4, False),
        (8e-4, [60], 1.0, True),  # at rest, the way from one frame to the next is noise
        (6e-4, [60], 1.0, False),
        (3e-3, [57, 60, 62], 1.0, True),  # told by the frames beside it, not the next but one
        (3e-3, slice(60, None), 1.0, False),  # an arm that stays behind or ahead is not late
        (3e-3, slice(61, None), 1.0, False),
        (3e-3, slice(60, None), -1.0, False),
        (3e-3, slice(61, None), -1.0, False),
    ],
)
def test_late_data_are_those_of_one_frame_of_an_arm_that_moves(
    travel: float, rows: list[int] | slice, late: float, returned: bool
) -> None:
    shown = np.arange(COUNT, dtype=float)
    shown[rows] -= late
    findings = repair(uniform(travel, shown, lost=59))[1]
    assert [findings[one].count for one in findings if one == Found.LATE_DATA] == [1] * returned


@pytest.mark.parametrize(("count", "returned"), [(62, True), (61, False)])
def test_the_last_frame_has_none_after_it_to_tell_whether_it_is_late(
    count: int, returned: bool
) -> None:
    shown = np.arange(count, dtype=float)
    shown[60] -= 1.0
    assert (Found.LATE_DATA in repair(uniform(3e-3, shown, lost=59))[1]) == returned


def test_stale_data_are_told_by_any_current_that_is_noisy() -> None:
    """By a hundredth of an ampere, though one joint has no current at all."""
    table = frames()
    for joint in range(6):
        table[f"actual_current_{joint}"] *= 0.01 if joint < 5 else 0.0
    columns = table.columns.drop("time")
    table.loc[50, columns] = table.loc[49, columns]
    assert repair(table)[1][Found.STALE_DATA].count == 1
