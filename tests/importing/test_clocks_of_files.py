"""The clock of a file: counters that roll over, times of day, packets, and none at all."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import shared_folder
from tests.entries import in_words, read_recording
from tests.stored_files import Made, frame, made_up_channels
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import ImportedRecording, import_files
from ur5lib.timeseries.arrays import Array

MOVED = "actual_q", "actual_qd", "actual_current"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return made_up_channels(tmp_path_factory.mktemp("made"))


def logged(made: Made, path: Path, clock: object, header: bool = True) -> ImportedRecording:
    """The import of a log with stamps of its own, or without any."""
    table = frame(made[0], {name: made[1][name] for name in MOVED})
    table = table.drop(columns="time") if clock is None else table.assign(time=clock)
    table.to_csv(path, index=False, header=header)
    return import_files([path], UserStatement("ur5"))[0]


def steps(recording: ImportedRecording) -> Array:
    return np.diff(read_recording(recording.entry).robot.table["time"].to_numpy())


@pytest.mark.parametrize("period_in_s", [4294.967296, 4294967.296])
def test_a_counter_that_rolls_over_goes_on(tmp_path: Path, made: Made, period_in_s: float) -> None:
    time, unit = made[0], 2**32 / period_in_s
    counted = np.floor((period_in_s - 2.0 + time) * unit) % 2**32
    found = logged(made, tmp_path / "log.csv", counted)
    assert np.ptp(steps(found)) < 2.5 / unit
    assert "begins again" in in_words(found.account)


def test_a_restart_is_no_roll_over(tmp_path: Path, made: Made) -> None:
    time = np.where(made[0] < 5, 5000 + made[0], made[0] - 5)
    assert (steps(logged(made, tmp_path / "log.csv", time)) < -4000).sum() == 1


@pytest.mark.parametrize("mark", [":", "."])
def test_times_of_a_day_are_seconds(tmp_path: Path, made: Made, mark: str) -> None:
    stamps = pd.Timestamp("2026-01-01 23:59:58") + pd.to_timedelta(made[0], unit="s")
    text = stamps.strftime(f"%H:%M:%S{mark}%f")
    found = logged(made, tmp_path / "log.csv", text)
    np.testing.assert_allclose(steps(found), np.diff(made[0]), atol=2e-6)


@pytest.mark.parametrize("header", [True, False])
def test_positions_that_rise_are_no_clock(tmp_path: Path, made: Made, header: bool) -> None:
    channels = {name: made[1][name].copy() for name in MOVED}
    rise = 0.1 * made[0] + 0.01 * (1 - np.cos(made[0]))
    channels["actual_q"][:, 0] = rise
    channels["actual_qd"][:, 0] = 0.1 + 0.01 * np.sin(made[0])
    found = logged((made[0], channels), tmp_path / "log.csv", None, header)
    rate = 1 / float(np.median(np.diff(made[0])))
    assert found.entry["rate"] == pytest.approx(rate, rel=2e-3)
    table = read_recording(found.entry).robot.table
    np.testing.assert_allclose(table["actual_q_0"], rise, atol=1e-9)


@pytest.mark.parametrize("step", [0.0, 1e-5])
@pytest.mark.parametrize("size", [2, 5])
def test_packets_are_put_at_equal_steps(tmp_path: Path, made: Made, step: float, size: int) -> None:
    time, place = made[0], np.arange(len(made[0])) % size
    last = np.minimum(np.arange(len(time)) - place + size - 1, len(time) - 1)
    found = logged(made, tmp_path / "log.csv", time[last] + step * place)
    assert "packets" in in_words(found.account)
    assert "the derivative of" in in_words(found.account)


@pytest.mark.parametrize("case", ["12_micros_roll_over", "19_first_position_rises"])
def test_cases_of_public_threads(case: str) -> None:
    folder = shared_folder("cases-6", "they are made after public threads")
    (found,) = import_files([folder / f"{case}.csv.gz"], UserStatement("ur5e"))
    raw = read_recording(found.entry).robot.table
    assert "the derivative of" in in_words(found.account)
    assert {"actual_q_5", "actual_qd_5", "actual_current_5"} <= {*raw}
    np.testing.assert_allclose(np.diff(raw["time"]), 0.008, atol=1e-4)
