"""Clocks found from the turning that both the joints and a gyroscope tell; resampling; how late the
clocks of one host start and how they drift, all of its devices alike.
"""

import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import signal

from ur5lib.errors import Remark
from ur5lib.records.clocks import (
    UNKNOWN_DRIFT_STD,
    ClockRelation,
    HostDrift,
    OwnClock,
    SettledClock,
)
from ur5lib.signals.clock import (
    CLOCK_WANDER,
    MOTION_METHOD,
    STAMPS_METHOD,
    clock_from_stamps,
    pool,
    pool_drifts,
    settle_clocks,
)
from ur5lib.signals.device_clock import (
    LATENCY_STD,
    _compare,
    _search,
    clock_from_rotation,
    even_samples,
    interpolate,
)
from ur5lib.signals.resampling import PASSBAND_SHARE, resample

OFFSET, DRIFT = -0.08, -3300e-6
STAMPS = clock_from_stamps(-0.03, 0.1)
PERIOD, DURATION = 0.008, 25.0
TIME = np.arange(0, DURATION, PERIOD)

Motion = Callable[[np.ndarray], np.ndarray]


def trajectory(time: np.ndarray) -> np.ndarray:
    """Angular velocity (N, 3) [rad/s] of a few moves that repeat every 6.4 s."""
    phase = 2 * np.pi * time[:, None] / 6.4
    return 0.4 * np.sin(phase * [1, 2, 1] + [0, 1, 2]) + 0.2 * np.sin(phase * [3, 1, 2])


def swinging(period: float) -> Motion:
    """The same swing over and over."""
    return lambda time: np.sin(2 * np.pi * time[:, None] / period + [0, 1, 2]) * [0.5, 0.3, 0.4]


@dataclass
class Record:
    """What robot and device recorded of one motion."""

    time: np.ndarray
    rate: np.ndarray
    segment: np.ndarray
    device_time: np.ndarray
    gyroscope: np.ndarray

    def clock(self, stamps: ClockRelation = STAMPS) -> tuple[ClockRelation, Remark | None]:
        return clock_from_rotation(**vars(self), stamps=stamps)


def record(motion: Motion, seed: int = 0, offset: float = OFFSET) -> Record:
    """A gyroscope at 266 Hz, turned by half a degree, biased, its noise lasting; its stamps
    come late by up to some ms."""
    random = np.random.default_rng(seed)
    own = np.arange(0, DURATION, 1 / 266.3)
    felt = motion(offset + (1 + DRIFT) * own)
    lasting = signal.lfilter([1], [1, -0.99], random.normal(size=felt.shape), axis=0)
    noise = 0.005 * random.normal(size=felt.shape) + 5e-4 * lasting
    felt = felt + np.cross(felt, [-0.009, 0.002, 0.003]) + [-0.031, 0.024, 0.027] + noise
    stamped = np.sort(np.round(own + random.exponential(5e-4, len(own)), 3))
    rate = motion(TIME) + 0.003 * random.normal(size=(len(TIME), 3))
    return Record(TIME, rate, np.zeros(len(TIME), np.int64), stamped - stamped[0], felt)


def test_the_standard_errors_hold() -> None:
    """Two of them cover the truth about as often as they should, without being generous.

    The simulated sensors have no latencies, so what is stated for those is taken off again.
    """
    found = [record(trajectory, seed).clock() for seed in range(60)]
    clocks = [clock for clock, _ in found]
    assert {(clock.method, reason) for clock, reason in found} == {(MOTION_METHOD, None)}
    assert max(clock.offset_std for clock in clocks) < 1.2 * LATENCY_STD
    floors = LATENCY_STD, CLOCK_WANDER / (TIME[-1] - TIME[0])
    for name, truth, floor in zip(("offset", "drift"), (OFFSET, DRIFT), floors, strict=True):
        error = np.array([getattr(clock, name) - truth for clock in clocks])
        stated = np.array([getattr(clock, f"{name}_std") for clock in clocks])
        std = np.sqrt(stated**2 - floor**2)  # what the recording itself told
        assert 0.85 <= np.mean(np.abs(error) < 2 * std) <= 1
        assert 0.6 < std.mean() / error.std() < 1.7


def test_a_bias_of_the_gyroscope_moves_no_clock() -> None:
    """Not those either from which the fit starts: each axis has a bias of its own."""
    own = record(trajectory)
    bias = np.array([3.0, -2.0, 1.0])
    found, biased = (
        _search(_compare(own.time, own.rate, own.segment, own.device_time, felt), STAMPS)
        for felt in (own.gyroscope, own.gyroscope + bias)
    )
    np.testing.assert_allclose(biased, found, atol=1e-12)


@pytest.mark.parametrize("start", [0.0, 40.0])
def test_the_device_s_angular_acceleration_is_the_motion_s_whenever_its_clock_starts(
    start: float,
) -> None:
    """Of the swing below the band's limit, away from its ends."""
    own, moved = np.arange(0, DURATION, 1 / 266.3), swinging(2.0)
    pair = _compare(TIME, moved(TIME), np.zeros(len(TIME), np.int64), start + own, moved(own))
    inside = np.abs(pair.device_time - pair.device_time.mean()) < 0.4 * DURATION
    ahead = (moved(pair.device_time - start + 1e-3) - moved(pair.device_time - start - 1e-3)) / 2e-3
    np.testing.assert_allclose(pair.slope[inside], ahead[inside], atol=0.02 * np.abs(ahead).max())
    assert np.diff(pair.device_time) == pytest.approx(1 / 266.3)


def test_a_swing_starts_a_fit_in_each_of_its_periods() -> None:
    """There the misfit has its valleys, and nowhere else."""
    period = 0.8
    own = record(swinging(period))
    pair = _compare(own.time, own.rate, own.segment, own.device_time, own.gyroscope)
    starts = np.array([offset for offset, _ in _search(pair, STAMPS)])
    away = (starts - OFFSET) / period
    assert 2 <= len(starts) <= 1 + np.ptp(starts) / period * 1.2
    assert np.abs(away - np.round(away)).max() < 0.15


def test_no_sample_of_a_slow_robot_is_wasted() -> None:
    """At 25 Hz each counts: 10 s are enough, though of a fast one a fraction would do."""
    clock, reason = robot_rows(slice(0, 1250, 5)).clock()
    assert reason is None
    assert clock.offset == pytest.approx(OFFSET, abs=0.02)


@pytest.mark.parametrize("offset", [-0.55, -0.45, 0.3, 0.45])
def test_a_wrong_stamp_is_mended_or_reported(offset: float) -> None:
    """Up to half a second, five standard errors, from the stamps; beyond, they stand."""
    clock, reason = record(trajectory, offset=offset).clock()
    if abs(offset - STAMPS.offset) < 0.5:
        assert reason is None
        assert clock.offset == pytest.approx(offset, abs=0.01)
    else:
        assert clock == STAMPS
        assert reason is not None
        assert reason.code == "implausible clock"
        assert "implies a start −0.52 s" in reason.text


@pytest.mark.parametrize(
    ("period", "offset"),
    [
        *((period, OFFSET) for period in (0.5, 0.6, 0.7, 1.0, 2.0)),
        # as fast as the band lets pass, wherever the clock lies between the search's steps
        *((0.27, offset) for offset in (-0.1, -0.08, -0.06, -0.04)),
    ],
)
def test_a_periodic_motion_does_not_jump_a_period(period: float, offset: float) -> None:
    clock, reason = record(swinging(period), offset=offset).clock()
    assert reason is None
    assert clock.offset == pytest.approx(offset, abs=0.01)


def test_nothing_is_used_across_a_gap() -> None:
    """Half a second is missing, and the robot's turning beside it is not joined up."""
    holed = robot_rows((TIME < 9) | (TIME > 9.5))
    holed.segment = np.where(holed.time < 9, 0, 1)
    clock, reason = holed.clock()
    assert reason is None
    assert clock.offset == pytest.approx(OFFSET, abs=3 * clock.offset_std)


def device_rows(rows: slice) -> Record:
    whole = record(trajectory)
    return replace(whole, device_time=whole.device_time[rows], gyroscope=whole.gyroscope[rows])


def robot_rows(rows: slice | np.ndarray) -> Record:
    whole = record(trajectory)
    parts = {name: getattr(whole, name)[rows] for name in ("time", "rate", "segment")}
    return replace(whole, **parts)


SHORT = {"short record", "little overlap"}
UNDETERMINED = {  # what was recorded, and why the motion does not determine the clock
    "standstill": (lambda: record(lambda time: np.zeros((len(time), 3))), {"unexplained rotation"}),
    "dead gyroscope": (
        lambda: replace(record(trajectory), gyroscope=0 * record(trajectory).gyroscope),
        {"unexplained rotation"},
    ),
    "dead gyroscope on a resting arm": (
        lambda: replace(
            record(trajectory),
            rate=np.zeros((len(TIME), 3)),
            gyroscope=0 * record(trajectory).gyroscope,
        ),
        {"unexplained rotation"},
    ),
    "another run's copy": (
        lambda: replace(record(trajectory), rate=swinging(1.7)(TIME)),
        {"unexplained rotation", "implausible clock"},
    ),
    # fewer than 20 samples in one of eight blocks, or than four in a period of 4 Hz
    **{f"{n} samples": (partial(device_rows, slice(n)), SHORT) for n in (0, 1, 2, 159)},
    "short robot": (lambda: robot_rows(slice(159)), {"short record"}),
    "slow device": (lambda: device_rows(slice(None, None, 17)), {"slow record"}),
    "slow robot": (lambda: robot_rows(slice(None, None, 8)), {"slow record"}),
}


@pytest.mark.parametrize("case", UNDETERMINED)
def test_where_motion_does_not_determine_a_clock_the_stamps_stand(case: str) -> None:
    recorded, codes = UNDETERMINED[case]
    with np.errstate(divide="raise", invalid="raise"):
        clock, reason = recorded().clock()
    assert clock == STAMPS
    assert reason is not None
    assert reason.code in codes


def test_just_enough_samples_are_no_reason() -> None:
    """Twenty in each of eight blocks, and four in a period of 4 Hz: of the robot, of the device."""
    for one in (robot_rows(slice(0, 160 * 8, 8)), device_rows(slice(0, 160 * 16, 16))):
        assert code_of(one.clock()[1]) != "short record"
    whole, own = record(trajectory), np.arange(0, DURATION, 1 / 16.5)
    slow = {"time": own, "rate": trajectory(own), "segment": np.zeros(len(own), np.int64)}
    for one in (slow, {"device_time": own, "gyroscope": trajectory(own)}):
        assert code_of(replace(whole, **one).clock()[1]) != "slow record"


def code_of(reason: Remark | None) -> str:
    return reason.code if reason else ""


def test_a_better_stamp_is_not_given_up() -> None:
    """What the gyroscope determines to some 0.3 ms is worth less than a stamp good to 0.1 ms."""
    stamps = clock_from_stamps(OFFSET, 1e-4)
    clock, reason = record(trajectory).clock(stamps)
    assert clock == stamps
    assert reason is not None


def test_a_clock_drifts_by_no_more_than_a_hundredth() -> None:
    own = record(trajectory)
    for drift, told in ((0.009, True), (0.0115, False), (-0.009, True), (-0.0115, False)):
        drifting = replace(own, device_time=own.device_time * (1 + DRIFT) / (1 + drift))
        assert (drifting.clock()[1] is None) == told


def test_joints_explain_four_fifths_of_what_a_gyroscope_feels() -> None:
    """The rest is a shaking of its own, of which the joints know nothing."""
    own = record(trajectory)
    other = swinging(1 / 1.37)(own.device_time) / np.sqrt(0.5) / [0.5, 0.3, 0.4]
    for share, told in ((0.18, True), (0.22, False)):
        power = np.var(own.gyroscope, axis=0).mean() * share / (1 - share)
        shaken = replace(own, gyroscope=own.gyroscope + np.sqrt(power) * other)
        _, reason = shaken.clock()
        assert (reason is None) == told
        if reason is not None:
            told = int(re.findall(r"explain only (\d+)%", reason.text)[0])
            assert told / 100 == pytest.approx(1 - share, abs=0.02)


def test_time_is_counted_from_either_clock() -> None:
    """t_robot = offset + (1 + drift) t_device."""
    clock = ClockRelation(-0.5, 0.03, 0.01, 0.002, "")
    device = np.array([0.0, 10.0])
    np.testing.assert_allclose(clock.device_time(-0.5 + 1.01 * device), device, atol=1e-12)
    assert clock.std_after(20.0) == pytest.approx(0.05)
    unknown = clock_from_stamps(2.0, 0.03)
    np.testing.assert_allclose(unknown.device_time(2.0 + device), device)


@pytest.mark.parametrize(("steps", "bridged"), [(4.8, True), (5.2, False)])
def test_a_gap_is_longer_than_five_mean_steps(steps: float, bridged: bool) -> None:
    time = 0.01 * np.arange(2000.0)
    time[1000:] += 0.01 * (steps * np.diff(time).mean() / 0.01 - 1)
    at = np.array([(time[999] + time[1000]) / 2, time[999], time[1000], time[500] + 0.002])
    told = interpolate(at, time, time[:, None])[:, 0]
    np.testing.assert_allclose(told[1:], at[1:])
    assert (told[0] == pytest.approx(at[0])) == bridged
    assert np.isnan(told[0]) != bridged
    outside = interpolate(np.array([-0.001, time[-1] + 0.001]), time, time[:, None])
    assert np.isnan(outside).all()
    time[-1] += 10.0  # a gap before the last sample
    last = interpolate(np.array([time[-1] - 5.0, time[-1]]), time, time[:, None])[:, 0]
    np.testing.assert_array_equal(last, [np.nan, time[-1]])


def test_even_samples_keep_the_usual_step_and_both_ends() -> None:
    """Gaps do not lengthen it, and hold nothing."""
    own = np.delete(0.01 * np.arange(1001), slice(300, 400))
    grid, even = even_samples(own, np.column_stack([own, 2 * own]))
    np.testing.assert_allclose(grid, 0.01 * np.arange(1001), atol=1e-12)
    known = np.isfinite(even).all(axis=1)
    np.testing.assert_array_equal(np.flatnonzero(~known), np.arange(300, 400))
    np.testing.assert_allclose(even[known], np.column_stack([grid, 2 * grid])[known], atol=1e-12)


# Resampling

CLOCK = clock_from_stamps(0.0, 0.01)


def tone(frequency: float, rate: float, jitter: float = 0.0) -> pd.DataFrame:
    own = np.arange(0, 8, 1 / rate)
    own = np.sort(own + jitter * np.random.default_rng(1).uniform(-0.5, 0.5, len(own)) / rate)
    return pd.DataFrame({"time": own, "ft_fx": np.sin(2 * np.pi * frequency * own)})


def middle(table: pd.DataFrame) -> np.ndarray:
    return table["ft_fx"].to_numpy()[200:800]


@pytest.mark.parametrize("rate", [207.0, 266.0, 1000.0])
@pytest.mark.parametrize("frequency", [63.0, 80.0, 100.0])
def test_what_the_robot_cannot_sample_disappears(rate: float, frequency: float) -> None:
    """Without a low-pass, 100 Hz would come out as 25 Hz."""
    aligned = middle(resample(tone(frequency, rate), CLOCK, TIME[:1000]))
    assert np.abs(aligned).max() < 2e-3


@pytest.mark.parametrize("rate", [500.0, 1000.0])
@pytest.mark.parametrize("share", [0.5, 1.0])  # of the passband
def test_what_the_robot_can_sample_stays(rate: float, share: float) -> None:
    frequency = share * PASSBAND_SHARE * 125 / 2
    aligned = middle(resample(tone(frequency, rate), CLOCK, TIME[:1000]))
    np.testing.assert_allclose(aligned, middle(tone(frequency, 125)), atol=5e-3)


@pytest.mark.parametrize(("rate", "jitter"), [(207.0, 0.0), (266.0, 1.0), (100.0, 0.0)])
def test_a_movement_keeps_amplitude_and_phase(rate: float, jitter: float) -> None:
    """Also of a device slower than the robot, as far as lines between its samples go."""
    aligned = middle(resample(tone(10, rate, jitter), CLOCK, TIME[:1000]))
    allowed = 0.03 if rate > 125 else (np.pi * 10 / rate) ** 2 / 2 + 1e-3
    np.testing.assert_allclose(aligned, middle(tone(10, 125)), atol=allowed)


def test_a_sharp_push_keeps_its_height() -> None:
    own = np.arange(0, 8, 1 / 207)
    push = pd.DataFrame({"time": own, "ft_fx": 50 * np.exp(-(((own - 4) / 0.03) ** 2))})
    assert resample(push, CLOCK, TIME[:1000])["ft_fx"].max() == pytest.approx(50, rel=0.002)


@pytest.mark.parametrize("rate", [50.0, 266.0])
def test_a_gap_of_the_device_is_not_bridged(rate: float) -> None:
    """And what stands beside it is not bent."""
    own = np.arange(0, 8, 1 / rate)
    own = own[(own < 3) | (own > 3.5)]
    device = pd.DataFrame({"time": own, "ft_fx": np.where(own < 3.2, 1.0, 20.0)})
    aligned = resample(device, CLOCK, TIME[:1000])["ft_fx"].to_numpy()
    inside = (TIME[:1000] > own[own < 3.2][-1]) & (TIME[:1000] < own[own > 3.2][0])
    assert np.isnan(aligned[inside]).all()
    expected = np.where(TIME[:1000] < 3.2, 1.0, 20.0)
    seen = ~inside & (TIME[:1000] <= own[-1])
    np.testing.assert_allclose(aligned[seen], expected[seen], atol=1e-4)


@given(offset=st.floats(-1, 1))
def test_a_shifted_clock_is_put_right(offset: float) -> None:
    """t_robot = offset + t_device: a line seen by the device is a line on the robot's clock."""
    own, time = np.arange(0, 4, 0.005), TIME[:2000]
    device = pd.DataFrame({"time": own, "ft_fx": 3 * (own + offset)})
    aligned = resample(device, clock_from_stamps(offset, 0.01), time)["ft_fx"].to_numpy()
    seen = (offset <= time) & (own[-1] + offset >= time)
    np.testing.assert_allclose(aligned[seen], 3 * time[seen], atol=1e-9)
    assert np.isnan(aligned[(offset - 1e-9 > time) | (own[-1] + offset + 1e-9 < time)]).all()


@pytest.mark.parametrize("count", [0, 1, 2, 3])
def test_few_samples_do_not_fail(count: int) -> None:
    device = tone(1, 266).iloc[:count]
    aligned = resample(device, CLOCK, TIME)["ft_fx"].to_numpy()
    assert np.isfinite(aligned).sum() == (count > 1)  # three samples end before 8 ms


# Devices of one host

HOSTS = {"pc": ["force", "imu"]}
OF_STAMPS = OwnClock(
    offset=-0.006,
    offset_std=0.006,
    drift=None,
    drift_std=None,
    method=STAMPS_METHOD,
    warning=None,
    stamps=-0.006,
)
SECONDS = 34.0


def by_motion(
    drift: float, std: float = 1e-4, late: float = 0.0, stamps: float = -0.006
) -> OwnClock:
    """late: how much later than its stamps say the device's clock began [s]."""
    found = {
        "offset": stamps + late,
        "offset_std": 0.005,
        "stamps": stamps,
        "method": MOTION_METHOD,
    }
    return replace(OF_STAMPS, **found, drift=drift, drift_std=std)


def test_what_motion_told_is_pooled_by_its_error() -> None:
    clocks = {
        "a": {"imu": by_motion(-0.0033, 1e-4)},
        "b": {"imu": by_motion(-0.0034, 2e-4), "force": OF_STAMPS},
        "another run's": {"imu": replace(OF_STAMPS, warning="of another run")},
        "without": {},
    }
    found = pool_drifts(clocks, HOSTS)["pc"]
    assert found.recordings == ["a", "b"]
    assert found.drift == pytest.approx(-0.00332)
    assert found.std_error == pytest.approx(1e-4 / np.sqrt(1.25))
    assert found.spread == 0


def test_starts_are_pooled_by_their_distance_from_the_stamps() -> None:
    """The robot's own stamp is off alike for all devices, whatever theirs say."""
    clocks = {
        name: {"imu": by_motion(-0.0033, late=late, stamps=stamps)}
        for name, stamps, late in (("a", 0.1, -0.07), ("b", -2.0, -0.06), ("c", 0.0, -0.065))
    }
    found = pool_drifts(clocks, HOSTS)["pc"]
    assert found.start == pytest.approx(-0.065)
    assert found.start_std_error == pytest.approx(0.005 / np.sqrt(3))
    assert found.start_spread == 0


def test_a_device_on_another_host_tells_nothing() -> None:
    clocks = {"a": {"imu": by_motion(-0.0033), "force": OF_STAMPS}}
    assert pool_drifts(clocks, {"laptop": ["force"]}) == {}


def test_the_spread_between_recordings_is_found() -> None:
    """Over many pools of eight recordings, the stated error of the mean and the spread hold."""
    random = np.random.default_rng(0)
    pooled = []
    for _ in range(400):
        std = random.uniform(5e-5, 3e-4, 8)
        value = -0.0033 + 3e-4 * random.normal(size=8) + std * random.normal(size=8)
        pooled.append(pool(value, std))
    mean, error, spread = np.array(pooled).T
    assert 0.88 < np.mean(np.abs(mean + 0.0033) < 1.96 * error) < 0.97
    assert np.median(spread) == pytest.approx(3e-4, rel=0.15)


def test_one_recording_shows_no_spread() -> None:
    assert pool(np.array([-0.0033]), np.array([1e-4])) == (-0.0033, 1e-4, 1e-4)


def settled(own: OwnClock, hosts: dict[str, HostDrift]) -> SettledClock:
    return settle_clocks({"force": own}, hosts, SECONDS)["force"]


HOST = HostDrift(["force", "imu"], -0.0033, 3e-5, 4e-5, -0.065, 0.002, 0.003, ["a", "b"])


def test_start_stamps_take_start_and_drift_of_their_host() -> None:
    clock = settled(OF_STAMPS, {"pc": HOST})
    assert clock.method == "start stamps, start and drift of its host"
    assert clock.offset == pytest.approx(-0.006 - 0.065)
    assert clock.offset_std == pytest.approx(np.linalg.norm([0.006, 0.002, 0.003]))
    assert clock.drift == -0.0033
    assert clock.drift_std == pytest.approx(np.sqrt(25e-10 + (0.004 / SECONDS) ** 2))
    end = np.hypot(clock.offset_std, SECONDS * clock.drift_std)
    assert clock.end_std == pytest.approx(end)
    other = replace(HOST, devices=["imu"], drift=0.1)
    assert settled(OF_STAMPS, {"laptop": other}).drift is None
    assert settled(OF_STAMPS, {"laptop": other}).offset == OF_STAMPS.offset


@pytest.mark.parametrize("drift_std", [0.0, 1e-5])
def test_a_shared_clock_and_stamped_samples_keep_the_robot_s_rate(drift_std: float) -> None:
    time = np.array([0.0, 1.0, 60.0])
    clock = clock_from_stamps(0.3, 0.01, drift_std)
    np.testing.assert_allclose(clock.device_time(time), time - 0.3, rtol=0, atol=1e-12)


def test_a_clock_that_motion_told_stays() -> None:
    clock = settled(by_motion(-0.0031), {"pc": HOST})
    assert (clock.method, clock.drift, clock.drift_std) == ("angular rate", -0.0031, 1e-4)


def test_an_unknown_drift_is_in_the_error_at_the_end() -> None:
    clock = settled(OF_STAMPS, {})
    assert clock.drift is None
    assert clock.end_std == pytest.approx(np.hypot(0.006, UNKNOWN_DRIFT_STD * SECONDS))
    assert ClockRelation(0.0, 0.006, 0.0, 0.0, "").std_after(SECONDS) == 0.006
