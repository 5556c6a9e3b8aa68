"""Reading and repairing recordings: nothing invented, nothing silently dropped."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.synthetic import PERIOD, START, write_channel, write_recording
from ur5lib.errors import InputError
from ur5lib.recordings.frames import to_grid
from ur5lib.recordings.quality import Finding
from ur5lib.recordings.thesis_csv import ROBOT_CHANNELS, read


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    write_recording(tmp_path / "run", seconds=1, seed=0, force_sensor=True, imu=True)
    return tmp_path / "run"


def found(findings: list[Finding], name: str) -> Finding:
    (finding,) = [finding for finding in findings if finding.finding == name]
    return finding


def cut(path: Path, size: int) -> None:
    path.write_bytes(path.read_bytes()[:-size])


def test_a_clean_recording_is_read_whole(recording: Path) -> None:
    raw = read(recording)
    assert raw.findings == []
    assert len(raw.robot) == 125
    assert list(raw.robot) == ["time"] + [
        f"{c}_{j}" for c in ROBOT_CHANNELS.values() for j in range(6)
    ]
    assert set(raw.sensors) == {"force", "imu"}
    assert raw.starts["force"].seconds == pytest.approx(0.005, abs=1e-6)
    assert raw.starts["imu"].seconds == pytest.approx(0, abs=0.05)  # six digits of 5.5e7 ms
    saved = np.loadtxt(recording / "csv_files" / "log_q_actual.csv", delimiter=",")
    np.testing.assert_array_equal(raw.robot[[f"actual_q_{j}" for j in range(6)]], saved[:, 1:])


def test_imu_columns_are_acceleration_magnetometer_gyroscope(recording: Path) -> None:
    saved = np.loadtxt(recording / "csv_files" / "acc_data.csv", delimiter=",")
    imu = read(recording).sensors["imu"]
    np.testing.assert_array_equal(imu[["imu_gx", "imu_gy", "imu_gz"]], saved[:, 7:])
    np.testing.assert_allclose(imu["time"], (saved[:, 0] - saved[0, 0]) / 1000)


@pytest.mark.parametrize("size", [1, 2, 9, 30])
def test_a_torn_last_line_is_left_out_and_located(recording: Path, size: int) -> None:
    """Even when what is left of it still looks like a whole row."""
    cut(recording / "csv_files" / "log_i_actual.csv", size)
    raw = read(recording)
    assert found(raw.findings, "torn last line").detail.startswith("log_i_actual.csv, line 125")
    assert len(raw.robot) == 124


def test_channels_of_unequal_length_share_their_frames(recording: Path) -> None:
    path = recording / "csv_files" / "log_m_target.csv"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:100]))
    raw = read(recording)
    assert found(raw.findings, "channels of unequal length").count == 25
    assert raw.robot["time"].iloc[-1] == pytest.approx(99 * PERIOD)


@pytest.mark.parametrize("line", ["1, 2, 3\n", "some words\n", "0.5, nan, 1, 1, 1, 1, 1\n"])
def test_a_damaged_line_is_left_out_and_counted(recording: Path, line: str) -> None:
    path = recording / "csv_files" / "log_q_actual.csv"
    lines = path.read_text().splitlines(keepends=True)
    lines[50] = line
    path.write_text("".join(lines))
    raw = read(recording)
    assert found(raw.findings, "damaged lines").count == 1
    assert len(raw.robot) == 124


@pytest.mark.parametrize(
    "text", ["", "no number here\nnor here\n", "0.0, 1.0, 2.0", "\x00\xff\x01"]
)
def test_a_channel_without_a_row_is_refused_by_name(recording: Path, text: str) -> None:
    (recording / "csv_files" / "log_q_actual.csv").write_text(text, encoding="latin-1")
    with pytest.raises(
        InputError, match=r"log_q_actual.csv holds no complete row of 7 numbers; \w"
    ):
        read(recording)


def test_a_missing_channel_is_refused_by_name(recording: Path) -> None:
    (recording / "csv_files" / "log_m_target.csv").unlink()
    with pytest.raises(InputError, match=r"log_m_target.csv is missing; \w"):
        read(recording)


def test_channels_of_two_runs_are_refused(recording: Path) -> None:
    write_channel(
        recording / "csv_files" / "log_m_target.csv", np.arange(9) + 99.0, np.ones((9, 6))
    )
    with pytest.raises(InputError, match="no frame is present in every channel"):
        read(recording)


@pytest.mark.parametrize(
    "content", ["no values recorded\n", "", "-0, -0, -0, -0, -0, -0, -0\n" * 3]
)
def test_an_absent_force_sensor_is_noted(recording: Path, content: str) -> None:
    (recording / "csv_files" / "log_force_sensor.csv").write_text(content)
    raw = read(recording)
    assert "force" not in raw.sensors
    assert found(raw.findings, "no sensor").device == "force"


def test_a_copy_from_another_run_is_not_used(recording: Path) -> None:
    (recording / "csv_files" / "acc_start_time.csv").write_text(f"{START % 86400 * 1000 - 6e6:.6g}")
    raw = read(recording)
    assert set(raw.sensors) == {"force"}
    assert "-6000 s" in found(raw.findings, "stale copy").detail


def test_midnight_between_two_starts_is_no_stale_copy(recording: Path) -> None:
    midnight = 1386633600
    (recording / "csv_files" / "start_time.csv").write_text(f"{midnight - 0.05:.2f}\n")
    (recording / "csv_files" / "acc_start_time.csv").write_text("30")
    raw = read(recording)
    assert raw.starts["imu"].seconds == pytest.approx(0.08, abs=1e-6)


def test_a_sensor_without_a_start_stamp_is_not_used(recording: Path) -> None:
    (recording / "csv_files" / "start_time.csv").unlink()
    raw = read(recording)
    assert raw.sensors == {}
    assert [f.finding for f in raw.findings] == ["no start stamp"] * 2


# Frame repair


def frames(slots: list[int]) -> pd.DataFrame:
    time = 0.05 + PERIOD * np.array(slots)
    return pd.DataFrame({"time": time, "actual_q_0": 2 * time})


def test_complete_frames_pass_unchanged() -> None:
    grid, findings = to_grid(frames([*range(50)]), PERIOD, 0.1)
    assert findings == []
    np.testing.assert_allclose(grid["time"], 0.05 + PERIOD * np.arange(50))
    np.testing.assert_array_equal(grid["actual_q_0"], frames([*range(50)])["actual_q_0"])


@given(st.sets(st.integers(1, 98), max_size=60))
def test_short_gaps_are_filled_and_flagged(lost: set[int]) -> None:
    kept = [slot for slot in range(100) if slot not in lost]
    grid, findings = to_grid(frames(kept), PERIOD, max_gap=1.0)
    assert len(grid) == 100
    assert set(grid.index[grid["interpolated"]]) == lost
    assert sum(finding.count for finding in findings) == len(lost)
    np.testing.assert_allclose(grid["actual_q_0"], 2 * grid["time"])  # a line is kept
    assert grid["segment"].eq(0).all()


@given(st.sets(st.integers(1, 98), max_size=60))
def test_long_gaps_split_and_hold_no_data(lost: set[int]) -> None:
    kept = [slot for slot in range(100) if slot not in lost]
    grid, _ = to_grid(frames(kept), PERIOD, max_gap=0.0)
    np.testing.assert_allclose(grid["time"], 0.05 + PERIOD * np.array(kept))
    assert not grid["interpolated"].any()
    for _, segment in grid.groupby("segment"):
        np.testing.assert_allclose(np.diff(segment["time"]), PERIOD)
    assert grid["segment"].nunique() == 1 + sum(b - a > 1 for a, b in pairwise(kept))


@given(st.permutations(range(30)), st.lists(st.integers(0, 29), max_size=10))
def test_order_and_repeats_do_not_matter(order: list[int], repeated: list[int]) -> None:
    clean, _ = to_grid(frames([*range(30)]), PERIOD, 0.1)
    mixed, findings = to_grid(frames([*order, *repeated]), PERIOD, 0.1)
    pd.testing.assert_frame_equal(mixed, clean)
    assert sum(finding.count for finding in findings) == len(repeated)


def test_jitter_does_not_lose_frames() -> None:
    jitter = np.random.default_rng(0).uniform(-5e-4, 5e-4, 1000)
    shaken = frames([*range(1000)])
    shaken["time"] += jitter
    grid, findings = to_grid(shaken, PERIOD, 0.1)
    assert len(grid) == 1000
    assert findings == []
