"""Sensors on the robot's clock by the stamps of the computer that recorded all devices."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from tests.conftest import said
from tests.entries import read_recording
from ur5lib.recordings.host_clock import least_delayed, without_delays
from ur5lib.recordings.starts import place_sensors
from ur5lib.records.clocks import OwnClock
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding
from ur5lib.signals.clock import HOST_METHOD, clock_from_stamps, settle_clocks
from ur5lib.signals.device_clock import device_clock

BOOT, UPTIME = 1.7e9, 5000.0  # s, of the host and of the controller when the recording begins
ROBOT_DRIFT, SENSOR_DRIFT = 80e-6, -3e-3  # of their clocks relative to the host's
SECONDS, RATE = 30.0, 1000.0
LATE = 0.7  # s, after which the sensor starts


def delayed(time: np.ndarray, seed: int) -> np.ndarray:
    """Arrival by the host's clock: 0.2 ms after, often a ms more, and in bursts of 5 ms."""
    random = np.random.default_rng(seed)
    arrival = time + 0.0002 + random.exponential(0.001, len(time))
    return np.maximum.accumulate(np.where(random.random(len(time)) < 0.05, 0.005, 0) + arrival)


@pytest.fixture
def entry(tmp_path: Path) -> dict[str, Any]:
    """A recording whose force sensor reads the host's true time, counted from the start."""
    host = np.arange(0, SECONDS, 0.002)
    robot: dict[str, np.ndarray] = {"timestamp": UPTIME + (1 + ROBOT_DRIFT) * host}
    robot |= {f"actual_q_{k}": 0.1 * host for k in range(6)}
    robot["host_time"] = BOOT + delayed(host, 1)
    pd.DataFrame(robot).to_csv(tmp_path / "robot.csv", index=False)
    count = np.arange((SECONDS - LATE) * RATE)
    sampled = LATE + count / RATE / (1 + SENSOR_DRIFT)
    rows = [BOOT + delayed(sampled, 2), 77 + count, *(sampled[None] + np.arange(6)[:, None])]
    pd.DataFrame(np.array(rows).T).to_csv(tmp_path / "force.csv", index=False, header=False)
    sensor = {"file": "force.csv", "columns": ["time", "counter", "ft"], "time": "host_s"}
    folder = {"folder": str(tmp_path), "file": "robot.csv"}
    return {"format": "rtde-csv", "force_sensor": sensor} | folder


def test_after_the_robots_clock_restarts_no_sample_is_placed(entry: dict[str, Any]) -> None:
    """Those before it are placed as well as ever."""
    path, reset = Path(entry["folder"], "robot.csv"), 20.0
    robot = pd.read_csv(path)
    robot.loc[robot["timestamp"] > UPTIME + reset, "timestamp"] -= UPTIME + reset - 40.0
    robot.to_csv(path, index=False)
    raw, findings = read_recording(entry), list[Finding]()
    record, start = place_sensors(raw, findings)["force"]
    on_robot = start.seconds + record.table["time"].to_numpy()
    assert on_robot.max() == pytest.approx(reset, abs=0.01)
    true = record.table["ft_fx"].to_numpy() * (1 + ROBOT_DRIFT)
    assert np.abs(on_robot - true).max() < 0.001
    assert [(one.device, one.code) for one in findings] == [("force", Found.CLOCK_RESET)]
    assert findings[0].count + len(record.table) == len(raw.sensors["force"].table)


def test_each_sample_is_placed_within_a_millisecond(entry: dict[str, Any]) -> None:
    raw = read_recording(entry)
    record, start = place_sensors(raw, [])["force"]
    on_robot = start.seconds + record.table["time"].to_numpy()
    true = record.table["ft_fx"].to_numpy() * (1 + ROBOT_DRIFT)
    assert np.abs(on_robot - true).max() < 0.001
    assert start.drift_std is not None
    assert start.drift_std < 20e-6
    assert start.std < 0.001
    assert list(record.table) == ["time", *(f"ft_{part}{axis}" for part in "ft" for axis in "xyz")]


def test_stamps_alone_serve_a_sensor_that_does_not_count(entry: dict[str, Any]) -> None:
    entry["force_sensor"]["columns"] = ["time", "-", "ft"]
    record, start = place_sensors(read_recording(entry), [])["force"]
    error = start.seconds + record.table["time"] - record.table["ft_fx"] * (1 + ROBOT_DRIFT)
    assert 0 < np.median(error) < 0.002


def test_the_clock_needs_no_motion(entry: dict[str, Any]) -> None:
    _, start = place_sensors(read_recording(entry), [])["force"]
    nothing = np.zeros((0, 3))
    stamps = clock_from_stamps(start.seconds, start.std, start.drift_std or 0.0)
    clock, warning = device_clock(np.zeros(0), nothing, stamps, (nothing,) * 3, (nothing,) * 2)
    assert (clock.method, clock.drift, warning) == (HOST_METHOD, 0.0, None)
    settled = settle_clocks(
        {"force": OwnClock(**vars(clock), warning=None, stamps=0.0)}, {}, SECONDS
    )
    assert settled["force"].end_std < 0.002


def test_without_stamps_of_the_robot_a_sensor_cannot_be_placed(entry: dict[str, Any]) -> None:
    path = Path(entry["folder"], "robot.csv")
    pd.read_csv(path).drop(columns="host_time").to_csv(path, index=False)
    findings: list[Any] = []
    assert place_sensors(read_recording(entry), findings) == {}
    assert findings[0].code == Found.NO_START_STAMP


def keep_rows(path: Path, first: int, last: int) -> None:
    """Leave some rows of a CSV, and its header if it has one."""
    lines = path.read_text().splitlines(keepends=True)
    header = lines[:1] if lines[0][0].isalpha() else []
    path.write_text("".join(header + lines[len(header) :][first:last]))


def missing(entry: dict[str, Any]) -> list[tuple[str, str]]:
    """Devices that lack a part, and what is said of them."""
    findings: list[Finding] = []
    raw = read_recording(entry)
    place_sensors(raw, findings)
    found = [one for one in raw.findings + findings if one.code == Found.PART_MISSING]
    assert {one.severity for one in found} <= {"warning"}
    return [(one.device, said(one)) for one in found]


def test_a_sensor_that_recorded_all_lacks_nothing(entry: dict[str, Any]) -> None:
    assert missing(entry) == []


@pytest.mark.parametrize(
    ("rows", "sentence"),
    [
        (
            (0, 10_000),
            "covers only 10.0 of 30.0 s: it starts 0.7 s after the robot and ends 19.3 s before it",
        ),
        ((12_000, 30_000), "covers only 17.3 of 30.0 s: it starts 12.7 s after the robot;"),
        (
            (12_000, 20_000),
            "covers only 8.0 of 30.0 s: it starts 12.7 s after the robot and ends 9.2 s before it;",
        ),
    ],
)
def test_a_sensor_that_lacks_a_part_is_found(
    entry: dict[str, Any], rows: tuple[int, int], sentence: str
) -> None:
    keep_rows(Path(entry["folder"], "force.csv"), *rows)
    ((device, detail),) = missing(entry)
    assert (device, detail[: len(sentence)]) == ("force", sentence)


def test_a_robot_that_dies_before_its_sensors_is_found(entry: dict[str, Any]) -> None:
    """But not one of which only a part is wanted."""
    assert missing(entry | {"to_s": 12.0}) == []
    keep_rows(Path(entry["folder"], "robot.csv"), 0, 6_000)
    ((device, detail),) = missing(entry)
    assert device == "robot"
    assert detail.startswith("covers only 12.0 of the 30.1 s that the sensors recorded;")


def test_a_short_record_that_came_at_once_has_the_nominal_rate(entry: dict[str, Any]) -> None:
    """As from a computer that was busy when it began."""
    path = Path(entry["folder"], "robot.csv")
    part = pd.read_csv(path).iloc[500:700]  # of the second second
    part.assign(host_time=part["host_time"].iloc[-1]).to_csv(path, index=False)
    record, start = place_sensors(read_recording(entry), [])["force"]
    error = start.seconds + 1.0 + record.table["time"] - record.table["ft_fx"]
    assert np.abs(error).max() < 0.5  # by what the computer was busy, and no more


def tails(time: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Delays of 0.3 ms and more, without an end until 0.3 s [s]."""
    return np.asarray(np.minimum(0.0003 * random.pareto(1.2, len(time)), 0.3))


def stalls(time: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """The same of a computer that is busy for half of the time, and some 10 ms late then [s]."""
    edges = np.cumsum(random.exponential(0.4, 4 + 4 * int(time[-1])))
    period = np.searchsorted(edges, time)
    late = 0.002 + random.exponential(0.01, len(edges) + 1)
    return tails(time, random) + np.where(period % 2, late[period], 0.0)


def block_minima(own: np.ndarray, host: np.ndarray) -> np.ndarray:
    """What least squares through the least delayed stamp of each block tell of `host`."""
    trend = np.polyval(np.polyfit(own, host - host[0], 1), own)
    block = np.floor(own / min(1.0, own[-1] / 8))
    best = pd.Series(host - host[0] - trend).groupby(block).idxmin().to_numpy()
    return np.asarray(np.polyval(np.polyfit(own[best], (host - host[0])[best], 1), own) + host[0])


@pytest.mark.parametrize("delay", [tails, stalls])
@pytest.mark.parametrize(("seconds", "rate"), [(6, 125), (6, 1000), (15, 500), (60, 500)])
def test_late_stamps_move_no_clock(
    delay: Callable[[np.ndarray, np.random.Generator], np.ndarray], seconds: int, rate: int
) -> None:
    """Within 2 ms always, nearer than by block minima always, and by an order mostly."""
    ours, others = [], []
    for seed in range(20):
        random = np.random.default_rng(seed)
        own = np.arange(0, seconds, 1 / rate)
        true = BOOT + (1 + random.normal(0, 1e-4)) * own
        host = np.maximum.accumulate(true + delay(own, random))
        line = least_delayed(own, host)
        assert (line.host(own) < host + 2e-6).all()
        assert abs(line.slope - np.polyfit(own, true, 1)[0]) < 5 * line.slope_std
        ours.append(np.abs(line.host(own) - true).max())
        others.append(np.abs(block_minima(own, host) - true).max())
    assert max(ours) < 0.002
    assert (np.array(ours) < np.array(others) + 2e-6).all()
    assert 10 * np.median(ours) < np.median(others)


def test_a_record_of_four_seconds_has_the_nominal_rate() -> None:
    """Below its stamps, and at one of them; a longer one has the rate of its stamps."""
    own = np.array([7.0, 8.0, 9.0])
    for delay in ([1.5, 0.5, 0.0], [0.0, 1.0, 2.0]):
        short = least_delayed(own, BOOT + own + delay, nominal=1.0)
        assert short.slope == 1.0
        assert (BOOT + own + delay - short.host(own)).tolist() == delay
    longer = np.append(own, 9.1)
    assert least_delayed(longer, BOOT + 2 * longer, nominal=1.0).slope == pytest.approx(2)


def test_the_error_of_a_rate_is_that_of_the_sixth_best_stamps() -> None:
    """Of each half of 20, with delays of 0 to 19 ms in any order; or the resolution of stamps."""
    random, own = np.random.default_rng(0), np.arange(40.0)
    delay = np.concatenate([random.permutation(20), random.permutation(20)])
    half = own[-1] / 2
    line = least_delayed(own, BOOT + own + 1e-3 * delay)
    assert line.slope_std == pytest.approx(np.hypot(5e-3, 5e-3) / half, rel=1e-3)
    assert least_delayed(own, 2 * own).slope_std == pytest.approx(1e-6 / half)
    later = np.insert(1e-3 * delay, 20, 0.0)  # a stamp at the mean time is one of the later half
    later[20:] *= 2
    line = least_delayed(np.arange(41.0), BOOT + np.arange(41.0) + later)
    assert line.slope_std == pytest.approx(np.hypot(5e-3, 8e-3) / 20, rel=1e-3)
    few = np.arange(12.0)  # six in each half, the sixth best of which is the worst
    assert least_delayed(few, 2 * few).slope_std == pytest.approx(1e-6 / (few[-1] / 2))
    assert least_delayed(few[:11], 2 * few[:11]).slope_std == 1e-3


@pytest.mark.parametrize(("stamps", "placed"), [(3, False), (4, True)])
def test_four_stamps_of_the_robot_are_needed(
    entry: dict[str, Any], stamps: int, placed: bool
) -> None:
    path = Path(entry["folder"], "robot.csv")
    table = pd.read_csv(path)
    kept = np.linspace(0, len(table) - 1, stamps).astype(int)
    table.loc[~table.index.isin(kept), "host_time"] = np.nan
    table.to_csv(path, index=False)
    raw = read_recording(entry)
    start = raw.sensors["force"].start
    assert start is not None
    assert (start.since != "host_s") == placed


@pytest.mark.parametrize("count", [[0, 1, 1, 3], [3, 2, 1, 0], [0, np.nan, np.nan, np.nan]])
def test_a_count_that_does_not_increase_tells_nothing(count: list[float]) -> None:
    time = [0.0, 0.2, 0.3, 0.3]
    table = without_delays(pd.DataFrame({"time": time, "counter": count}))
    assert table.to_dict("list") == {"time": time}


def test_a_stamp_that_was_lost_is_told_by_the_count() -> None:
    """Of which two stamps are enough."""
    stamps = pd.DataFrame({"time": [0.0, np.nan, 0.4], "counter": [7, 8, 9]})
    np.testing.assert_allclose(without_delays(stamps)["time"], [0.0, 0.2, 0.4], atol=1e-9)


@settings(max_examples=50)
@example([1, 1, 1], [1, 0, 1], 0.0)  # an edge of the hull ends at the mean
@example([1] * 10, [8, 8, 8, 8, 0, 2, 4, 6, 8, 10], 0.0)  # the last edge lies under it
@example([1, 1, 1, 18, 1, 1, 45], [4, 5, 4, 9, 8, 5, 8], 0.0)  # one above the stamps does, too
@given(
    st.lists(st.floats(0.1, 100), min_size=40, max_size=40),
    st.lists(st.floats(0, 10), min_size=2, max_size=40),
    st.floats(-1e-3, 1e-3),
)
def test_the_line_solves_the_linear_program(
    steps: list[float], delays: list[float], drift: float
) -> None:
    """No stamp lies below it, and no other such line has a lesser mean delay."""
    own = np.cumsum(steps[: len(delays)])
    host = (1 + drift) * own + delays
    line = least_delayed(own, host)
    left = host - line.host(own)
    above = np.column_stack([np.ones_like(own), own])
    best = linprog(-above.mean(axis=0), A_ub=above, b_ub=host, bounds=(None, None))
    assert left.min() > -1e-6
    assert left.mean() == pytest.approx(host.mean() + best.fun, abs=1e-6)


@pytest.mark.parametrize("least", [0.0, 0.0005, 0.001])
def test_the_stated_uncertainty_includes_the_least_delay(
    entry: dict[str, Any], least: float
) -> None:
    """A sensor whose every sample takes longer than the robot's, by up to half a round trip."""
    path = Path(entry["folder"], "force.csv")
    table = pd.read_csv(path, header=None)
    table[0] += least
    table.to_csv(path, index=False, header=False)
    record, start = place_sensors(read_recording(entry), [])["force"]
    error = start.seconds + record.table["time"] - record.table["ft_fx"] * (1 + ROBOT_DRIFT)
    assert np.median(error) == pytest.approx(least, abs=1e-4)
    assert np.abs(error).max() < 1.96 * start.std
