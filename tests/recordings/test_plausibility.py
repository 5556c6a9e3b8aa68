"""Which frames no arm can have sent, which timestamps no clock; and in which order they came."""

import math

import numpy as np
import pandas as pd
import pytest

from tests.conftest import said
from ur5lib.errors import InputError
from ur5lib.recordings.intake import bounds_of
from ur5lib.recordings.ordering import epochs, in_order
from ur5lib.recordings.plausibility import (
    check_pace,
    drop_implausible,
    drop_zeroed,
    first_time,
    stray_times,
)
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Robot

POSSIBLE = {  # what a channel may hold, and what it may not [SI]
    "actual_q_0": (12.5, 13.0),
    "target_q_3": (12.5, 13.0),
    "actual_qd_1": (19, 21),
    "target_qd_1": (19, 21),
    "target_qdd_5": (190, 210),
    "actual_current_2": (59, 61),
    "target_current_2": (59, 61),
    "target_moment_4": (990, 1010),
    "actual_TCP_force_0": (4900, 5100),
    "actual_TCP_speed_0": (49, 51),
    "actual_TCP_pose_0": (19, 21),
    "ft_fx": (4900, 5100),
    "ft_tz": (990, 1010),
    "imu_ay": (490, 510),
    "imu_gz": (49, 51),
}


def frames(count: int, channel: str = "actual_q_0") -> pd.DataFrame:
    return pd.DataFrame({"time": 0.008 * np.arange(count), channel: 0.0})


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("channel", POSSIBLE)
def test_what_no_arm_can_do_is_discarded(channel: str, sign: int) -> None:
    table, findings = frames(100, channel), list[Finding]()
    table.loc[30, channel], table.loc[[60, 61], channel] = sign * np.array(POSSIBLE[channel])
    kept = drop_implausible(table, "run.csv", "robot", findings)
    assert len(kept) == 98
    assert kept[channel].abs().max() == POSSIBLE[channel][0]
    ((finding, count, detail),) = ((one.code, one.count, said(one)) for one in findings)
    assert (finding, count) == (Found.IMPOSSIBLE_FRAMES, 2)
    assert detail.startswith("first in row 61:")


def test_a_joint_without_limits_may_be_anywhere() -> None:
    table, findings = frames(100), list[Finding]()
    table["actual_q_0"] += 50.0
    assert (
        len(drop_implausible(table, "run.csv", "robot", findings, {"actual_q_0": math.inf})) == 100
    )
    assert not findings


@pytest.mark.parametrize("factor", [1.0, 30.0])
def test_a_strong_arm_may_have_large_efforts(ur5: Robot, factor: float) -> None:
    """Beyond a UR's 1000 Nm, twice what its motors can is the limit."""
    motors = {
        name: own.model_copy(update={"torque_max": factor * own.torque_max})
        for name, own in ur5.motors.items()
    }
    most = bounds_of(ur5.model_copy(update={"motors": motors}))
    strongest = max(own.torque_max for own in motors.values())
    assert most["target_moment_0"] == max(2 * strongest, 1000.0)
    assert most["target_qdd_0"] >= 200.0
    current = 2 * ur5.torque_limits()[1] / ur5.maker_torque_constants()[1]
    assert most["target_current_1"] == pytest.approx(max(factor * current, 60.0))
    assert most["actual_current_1"] == most["target_current_1"]


def test_without_a_torque_constant_measured_currents_alone_have_a_bound(ur5: Robot) -> None:
    motors = {
        name: own.model_copy(update={"torque_constant": None}) for name, own in ur5.motors.items()
    }
    most = bounds_of(ur5.model_copy(update={"motors": motors}))
    assert (most["target_current_0"], most["actual_current_0"]) == (math.inf, 60.0)


@pytest.mark.parametrize(("count", "refused"), [(5, False), (6, True)])
def test_more_than_a_twentieth_is_no_damage(count: int, refused: bool) -> None:
    """Of a hundred frames: then the unit is wrong, which the median beyond the bound tells."""
    table = frames(100)
    table.loc[: count - 1, "actual_q_0"] = np.arange(20.0, 20 + count)
    if refused:
        with pytest.raises(InputError, match=r"in 6% of the rows \(median there 22.5\); is it in"):
            drop_implausible(table, "run.csv", "robot", [])
    else:
        assert len(drop_implausible(table, "run.csv", "robot", [])) == 95


@pytest.mark.parametrize(
    ("step", "refused"), [(1.9e-4, True), (2.1e-4, False), (0.99, False), (1.01, True)]
)
def test_a_pace_is_that_of_a_recording(step: float, refused: bool) -> None:
    """In whatever order the frames come, and though many share a timestamp."""
    time = np.repeat(step * np.arange(20.0)[::-1], 3)
    if refused:
        with pytest.raises(InputError, match="the median step between timestamps is"):
            check_pace(time, "run.csv")
    else:
        check_pace(time, "run.csv")


# Timestamps


def strays(time: np.ndarray) -> list[int]:
    return np.flatnonzero(stray_times(time)).tolist()


@pytest.mark.parametrize(("pause", "reported"), [(59.0, False), (61.0, True)])
@pytest.mark.parametrize("late", [True, False])
def test_few_frames_a_minute_away_are_strays(pause: float, reported: bool, late: bool) -> None:
    time = 0.01 * np.arange(1000)
    away, rest = (slice(-3, None), slice(-3)) if late else (slice(3), slice(3, None))
    time[away] += pause if late else -pause
    assert strays(time) == (np.arange(1000)[away].tolist() if reported else [])
    kept = rest if reported else slice(None)
    assert first_time(time) == time[kept].min()


@pytest.mark.parametrize(("count", "reported"), [(49, True), (50, False)])
def test_a_twentieth_of_all_frames_is_a_part_of_the_recording(count: int, reported: bool) -> None:
    time = 0.01 * np.arange(1000)
    time[-count:] += 100.0
    assert strays(time) == [*range(1000 - count, 1000)] * reported


@pytest.mark.parametrize(
    ("off", "reported"), [(0.9, False), (1.1, True), (-0.9, False), (-1.1, True)]
)
@pytest.mark.parametrize("count", [1, 2])
def test_frames_that_contradict_their_neighbours_are_strays(
    off: float, reported: bool, count: int
) -> None:
    """By more than a second, one or two of them beside each other; three are a run of their own."""
    time = 0.01 * np.arange(1000)
    time[500 : 500 + count] += off
    assert strays(time) == [*range(500, 500 + count)] * reported
    time[500:503] = 5 + off
    assert strays(time) == []


@pytest.mark.parametrize(("count", "reported"), [(5, True), (6, False)])
def test_frames_are_shuffled_if_more_than_a_twentieth_come_after_later_ones(
    count: int, reported: bool
) -> None:
    """Of a hundred steps; then nothing is reported of neighbours."""
    time = 0.01 * np.arange(101)
    late = 10 + 15 * np.arange(count)
    time[late] += 1.5
    assert strays(time) == late.tolist() * reported


def test_of_shuffled_frames_neighbours_say_nothing() -> None:
    time = np.random.default_rng(0).permutation(0.1 * np.arange(1000))
    assert strays(time) == []
    assert strays(np.array([0.0, 100, 200, 300])) == []  # four frames are too few to judge
    assert strays(np.array([0.0, 0.01, 0.02, 0.03, 100])) == [4]


# Order


@pytest.mark.parametrize(("run", "reset"), [(49, False), (50, True)])
def test_a_clock_that_restarts_runs_for_fifty_frames(run: int, reset: bool) -> None:
    first, second = 100 + np.arange(100.0), np.arange(float(run))
    expected = np.repeat([0, int(reset)], [100, run])
    np.testing.assert_array_equal(epochs(np.concatenate([first, second])), expected)
    if reset:
        np.testing.assert_array_equal(
            epochs(np.concatenate([second + 200, first])), [0] * 50 + [1] * 100
        )


@pytest.mark.parametrize(
    ("frames", "start", "reset"),
    [
        (50, 0.0, True),  # from the very beginning
        (50, 1.0, False),  # overlapping, and running beyond
        (60, 9.5, True),  # the fiftieth is still before where the first run ended
        (60, 10.0, False),  # as late as that
    ],
)
def test_a_restart_goes_back_by_a_run_or_to_the_beginning(
    frames: int, start: float, reset: bool
) -> None:
    time = np.concatenate([np.arange(float(frames)), start + np.arange(50.0)])
    np.testing.assert_array_equal(epochs(time), np.repeat([0, int(reset)], [frames, 50]))


def test_each_restart_is_counted_and_nothing_else() -> None:
    time = 0.008 * np.tile(np.arange(80), 3)
    findings: list[Finding] = []
    ordered = in_order(pd.DataFrame({"time": time, "actual_q_0": np.arange(240.0)}), findings)
    assert [(one.code, one.count) for one in findings] == [(Found.CLOCK_RESET, 2)]
    np.testing.assert_array_equal(ordered["epoch"], np.repeat([0, 1, 2], 80))


def test_a_recording_begins_before_its_clock_restarts() -> None:
    time = np.concatenate([500 + np.arange(60.0), np.arange(60.0)])
    assert first_time(time) == 500.0


# Cells that a file lost


COUNT = 300
NOISE = np.random.default_rng(0).uniform(0.1, 1.0, (COUNT, 6))  # A
CURRENTS = [f"actual_current_{joint}" for joint in range(6)]


def lost(columns: dict[str, np.ndarray]) -> tuple[np.ndarray, int]:
    """Return which cells are not used (N, k), and how many rows are reported; the others stay."""
    findings: list[Finding] = []
    table = pd.DataFrame(columns)
    kept = drop_zeroed(table, findings)
    wrong = kept.isna().to_numpy()
    np.testing.assert_array_equal(kept.to_numpy()[~wrong], table.to_numpy()[~wrong])
    return wrong, sum(finding.count for finding in findings)


@pytest.mark.parametrize("rows", [slice(0, 4), slice(1, 4), slice(120, 121), slice(290, COUNT)])
def test_positions_that_fall_to_zero_were_lost(rows: slice) -> None:
    """Also at the beginning and at the end, and those of one joint only."""
    q = np.linspace(1.0, 2.0, COUNT)
    fallen = q.copy()
    fallen[rows] = 0.0
    wrong, reported = lost({"actual_q_0": q, "actual_q_1": fallen, "actual_q_2": 0 * q})
    np.testing.assert_array_equal(wrong[:, 1], fallen == 0.0)
    assert not wrong[:, [0, 2]].any()
    assert reported == (fallen == 0.0).sum()


@pytest.mark.parametrize(("times", "kept"), [(6, True), (1, False)])
def test_a_torque_that_is_often_zero_was_commanded_so(times: int, kept: bool) -> None:
    """A controller takes it off where a joint stands; a file loses one block."""
    torque = 3.0 + np.linspace(0.0, 1.0, COUNT)
    for start in np.linspace(0, COUNT, times, endpoint=False).astype(int):
        torque[start : start + 60 // times] = 0.0
    wrong, _ = lost({"actual_torque_0": torque, "actual_torque_1": np.linspace(1, 2, COUNT)})
    assert wrong.any() != kept


def test_rows_that_lost_a_cell_are_counted_once() -> None:
    columns = {f"actual_q_{joint}": np.linspace(1.0, 2.0, COUNT) for joint in range(2)}
    columns["actual_q_0"][10:20] = columns["actual_q_1"][15:30] = 0.0
    assert lost(columns)[1] == 20


def test_a_joint_that_rests_at_zero_is_logged_one_digit_beside_it() -> None:
    angle = np.where(np.arange(935) % 200 == 7, 1e-4, 0.0)
    assert not lost({"actual_q_2": angle})[0].any()


def test_a_motion_through_zero_is_received() -> None:
    """And one that rests there for a while."""
    q = 0.01 * np.concatenate([np.arange(-100, 0), np.zeros(100), np.arange(100)])
    assert not lost({"actual_q_0": q})[0].any()


@pytest.mark.parametrize("beside", [5.0, 5.1])
def test_a_leap_is_more_than_five_usual_steps(beside: float) -> None:
    """Of values that change by one each time; some that are no numbers of a robot do not count."""
    column = beside + np.arange(COUNT) % 2.0
    column[100:110] = 0.0
    column[[99, 110]] = beside
    column[200:210] = 1e300
    wrong, _ = lost({"tool_acceleration": column})
    np.testing.assert_array_equal(wrong[:, 0], (column == 0.0) & (beside > 5.0))


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("first", [1, 100])
def test_a_leap_on_one_side_is_enough(first: int, turned: bool) -> None:
    """The values slowly leave zero on the other side."""
    q = np.concatenate([np.ones(first), np.zeros(10), 1e-3 * np.arange(1, COUNT - first - 9)])
    q = q[::-1] if turned else q
    np.testing.assert_array_equal(lost({"actual_q_0": q})[0][:, 0], q == 0.0)


@pytest.mark.parametrize(("speed", "gone"), [(0.09, False), (0.11, True)])
def test_slow_velocities_are_rounded_to_zero(speed: float, gone: bool) -> None:
    values = np.full(COUNT, speed)
    values[100:110] = 0.0
    wrong, _ = lost({"actual_qd_0": values, "actual_q_0": values})
    assert wrong[:, 0].sum() == 10 * gone
    assert wrong[:, 1].sum() == 10


def test_stray_bytes_are_no_values() -> None:
    values = np.tile([-1e-60, 1e-50, 1.5e-50, 1e-45, 1.0], COUNT // 5)
    np.testing.assert_array_equal(lost({"actual_q_0": values})[0][:, 0], np.abs(values) < 1e-50)


@pytest.mark.parametrize("rows", [4, 5])
def test_a_current_of_zero_for_five_rows_was_lost(rows: int) -> None:
    """But not those of a joint that has none at all."""
    currents = NOISE.copy()
    currents[100 : 100 + rows, 2] = currents[:, 5] = 0.0
    wrong, _ = lost(dict(zip(CURRENTS, currents.T, strict=True)))
    expected = np.zeros_like(wrong)
    expected[100 : 100 + rows, 2] = rows == 5
    np.testing.assert_array_equal(wrong, expected)


@pytest.mark.parametrize("rows", [49, 50])
def test_an_arm_without_power_has_no_current_for_long(rows: int) -> None:
    """For fifty rows and more; for fewer, all six were lost."""
    currents = NOISE.copy()
    currents[100 : 100 + rows] = 0.0
    wrong, reported = lost(dict(zip(CURRENTS, currents.T, strict=True)))
    np.testing.assert_array_equal(wrong, (currents == 0.0) & (rows < 50))
    assert reported == (rows if rows < 50 else 0)
