"""The force of an emulated arm as it is stated while the arm runs."""

import resource
import threading
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.topics.live.made_arm import arm_file
from ur5lab.doubles.controller_double import ControllerDouble
from ur5lab.live import Stream, in_words, record
from ur5lib.errors import InputError
from ur5lib.stand.plan import SimulatedRecording, Standstill
from ur5lib.tables import read_table, read_units
from ur5lib.topics.live.live import FREE, UNKNOWN, Answer, Live

HERE = "127.0.0.1"
PERIOD = 0.002  # s
LATEST = 0.01  # s, after its arrival, that a sample may be answered
MEMORY_GROWTH = 20_000  # kB
STILL = SimulatedRecording(trajectory=Standstill(kind="standstill"))
pytestmark = [
    pytest.mark.slow,
    pytest.mark.real_time,
    pytest.mark.usefixtures("controller_ports"),
]


def follow(path: Path, seconds: float | None) -> tuple[int, list[str]]:
    """Follow an emulated arm at 500 Hz; returns the number of samples, and what was shown."""
    shown: list[str] = []
    with ControllerDouble("ur5e", STILL) as arm:
        if seconds is None:  # until the controller is off
            threading.Timer(2.0, arm._process.kill).start()
        stream, estimator = Stream(HERE, seconds), Live(arm_file())
        ended = record(estimator, stream, path, lambda *now: shown.append(in_words(*now)))
    assert ended.lost == (seconds is None)
    return ended.samples, shown


def stated(path: Path, seconds: float | None) -> tuple[pd.DataFrame, list[str]]:
    """Follow an emulated arm; returns the file, and what was shown."""
    count, shown = follow(path, seconds)
    table = read_table(path)
    assert count == len(table)
    return table, shown


def check(table: pd.DataFrame, seconds: float) -> None:
    """No sample is missing, answers keep pace, and each is known in time."""
    assert len(table) > 480 * seconds
    np.testing.assert_allclose(np.diff(table["time"]), PERIOD, rtol=0, atol=1e-9)
    assert table["late"].median() < PERIOD
    assert table["late"].quantile(0.95) < LATEST  # the machine itself may stop for longer
    touched = ["link", "off_flange"]  # of contacts alone
    assert np.isfinite(table.drop(columns=touched).to_numpy(float)).all()
    elapsed = table["time"] - table["time"][0]  # unknown while friction may settle, for 1 s
    assert not table["known"][elapsed < 0.99].any()
    assert table["known"][elapsed > 1.01].all()


def test_what_is_stated_at_500_hz_is_written(tmp_path: Path) -> None:
    path = tmp_path / "live.parquet"
    table, shown = stated(path, 6.0)
    check(table, 6.0)
    assert read_units(path)["live_Fx"] == "N"
    assert len(shown) > 10
    assert UNKNOWN in shown[0]


def test_the_file_is_whole_where_the_arm_s_stream_ends(tmp_path: Path) -> None:
    table, _ = stated(tmp_path / "live.parquet", None)
    assert len(table) > 400


@pytest.mark.thorough
def test_ten_minutes_take_no_more_memory_and_no_sample_is_late(tmp_path: Path) -> None:
    stated(tmp_path / "warm.parquet", 10.0)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    follow(tmp_path / "live.parquet", 600.0)
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < MEMORY_GROWTH
    table = read_table(tmp_path / "live.parquet")
    check(table, 600.0)
    assert table["late"].max() < LATEST


def test_no_controller_is_told(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="RTDE"):
        record(Live(arm_file()), Stream(HERE, 1.0, port=9), tmp_path / "x.parquet", print)


def test_an_answer_is_a_line() -> None:
    limits = 2.0 * np.ones(3), np.array([3.0, 14.0, 5.0]), np.array([3.0, 14.0, 37.0])
    answer = Answer(np.array([1.0, -20.0, 3.0, 0, 0, 0]), np.ones(6), UNKNOWN, *limits, 0, 0.0)
    line = in_words(12.34, answer, "it rests")
    assert line.split()[:3] == ["12.3", "s", UNKNOWN]
    assert "y  -20.0 ±  2.0" in line
    assert line.endswith("it rests")
    free = in_words(12.34, answer._replace(contact=FREE), "")
    assert "a contact of up to 14 N could be hidden, 37 N if it began before" in free
