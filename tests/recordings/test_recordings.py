"""Reading recordings: nothing invented, nothing silently dropped."""

import tracemalloc
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from pydantic import TypeAdapter

from tests.conftest import said
from tests.entries import read_and_check, read_recording
from tests.real_arms import RealStudy
from tests.synthetic import PERIOD, START, write_channel, write_recording
from ur5lib.channels import SIX_SUFFIXES, SUFFIXES
from ur5lib.errors import InputError
from ur5lib.recordings import text_blocks
from ur5lib.recordings.counting import counted_as
from ur5lib.recordings.entries import ENTRY
from ur5lib.recordings.formats import READERS, excerpt
from ur5lib.recordings.intake import Intake, known_frames
from ur5lib.recordings.recording import DeviceRecord, RawRecording
from ur5lib.recordings.sensors import FORCE_CHANNELS, FORCES
from ur5lib.recordings.starts import place_sensors
from ur5lib.recordings.thesis_csv import ROBOT_CHANNELS
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.realtime_message import fields
from ur5lib.stand.device_files import MESSAGE_BYTES, messages
from ur5lib.stand.faults import FIRST_PART_BYTES
from ur5lib.study.model import Recording
from ur5lib.tables import channel, named

LONG_CHANNELS = [name for name, suffixes in SUFFIXES.items() if suffixes == SIX_SUFFIXES]


@pytest.fixture
def recording(tmp_path: Path) -> Path:
    write_recording(tmp_path / "run", seconds=1, seed=0, force_sensor=True, imu=True)
    return tmp_path / "run"


def read(folder: Path) -> RawRecording:
    return read_recording({"format": "thesis-csv", "folder": str(folder)})


def found(findings: list[Finding], name: str) -> Finding:
    (finding,) = [finding for finding in findings if finding.code == name]
    return finding


def test_every_format_of_a_study_has_a_reader() -> None:
    formats = TypeAdapter(Recording).json_schema()["discriminator"]["mapping"]
    assert set(READERS) == set(formats)


# A part of a recording


def test_parts_of_a_recording_are_the_whole(recording: Path) -> None:
    entry = {"format": "thesis-csv", "folder": str(recording)}
    whole = read_recording(entry)
    parts = [read_recording(entry | part) for part in ({"to_s": 0.5}, {"from_s": 0.5})]
    joined = pd.concat([part.robot.table for part in parts], ignore_index=True)
    pd.testing.assert_frame_equal(joined, whole.robot.table)
    assert [part.robot.start for part in parts] == [whole.robot.start] * 2


def test_a_part_after_the_end_is_refused(recording: Path) -> None:
    with pytest.raises(InputError, match=r"no frame between `from_s` and `to_s`; it lasts 0\.99"):
        read_recording({"format": "thesis-csv", "folder": str(recording), "from_s": 9.0})


BOOT = 5000.0  # s, of the controller's clock at the first frame
WHOLE = RawRecording(
    DeviceRecord(pd.DataFrame({"time": BOOT + np.arange(11.0)}), None, "robot.csv"), None, {}
)


@pytest.mark.parametrize(
    ("start", "end", "seconds"),
    [(2.0, 4.0, [2, 3]), (None, 2.0, [0, 1]), (9.0, None, [9, 10]), (0.0, 1.0, [0])],
)
def test_a_part_begins_at_its_start_and_ends_before_its_end(
    start: float | None, end: float | None, seconds: list[int]
) -> None:
    part = excerpt(WHOLE, start, end).robot.table
    assert (part["time"] - BOOT).tolist() == seconds
    assert part.index.tolist() == [*range(len(seconds))]


# Long recordings


def test_a_long_recording_is_in_memory_about_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ur5: Robot
) -> None:
    """Not as text, and not once more for each step of the repair; pyarrow's memory is not seen."""
    monkeypatch.setattr(text_blocks, "BLOCK_BYTES", 1 << 17)
    monkeypatch.setattr(text_blocks, "MIN_BLOCK_BYTES", 1 << 12)
    time = 0.008 * np.arange(10_000)
    columns = {f"{name}_{k}": 0.1 * np.sin(time + k) for name in LONG_CHANNELS for k in range(6)}
    pd.DataFrame({"timestamp": time, **columns}).to_csv(tmp_path / "long.csv", index=False)
    entry = {"format": "rtde-csv", "folder": str(tmp_path), "file": "long.csv"}
    tracemalloc.start()
    try:
        robot = read_and_check(entry, ur5, 0.1).robot
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    np.testing.assert_allclose(robot["target_moment_5"], columns["target_moment_5"], atol=1e-15)
    assert peak < 1.5 * robot.memory_usage().sum()


# The thesis's format


def test_a_clean_recording_is_read_whole(recording: Path) -> None:
    raw = read(recording)
    robot = raw.robot.table
    assert raw.findings == []
    assert len(robot) == 125
    assert list(robot) == ["time", *(f"{c}_{j}" for c in ROBOT_CHANNELS.values() for j in range(6))]
    placed = place_sensors(raw, [])
    assert placed["force"][1].seconds == pytest.approx(0.005, abs=1e-6)
    assert placed["imu"][1].seconds == pytest.approx(0, abs=0.05)  # six digits of 5.5e7 ms
    assert placed["force"][1].std == pytest.approx(np.hypot(0.005, 0.003))
    assert placed["imu"][1].std == pytest.approx(np.hypot(0.005, 0.1))
    saved = np.loadtxt(recording / "csv_files" / "log_q_actual.csv", delimiter=",")
    np.testing.assert_array_equal(robot[[f"actual_q_{j}" for j in range(6)]], saved[:, 1:])


def test_imu_columns_are_acceleration_magnetometer_gyroscope(recording: Path) -> None:
    saved = np.loadtxt(recording / "csv_files" / "acc_data.csv", delimiter=",")
    imu = read(recording).sensors["imu"].table
    np.testing.assert_array_equal(imu[["imu_gx", "imu_gy", "imu_gz"]], saved[:, 7:])
    np.testing.assert_allclose(imu["time"], (saved[:, 0] - saved[0, 0]) / 1000)


def test_channels_of_unequal_length_share_their_frames(recording: Path) -> None:
    path = recording / "csv_files" / "log_m_target.csv"
    path.write_text("".join(path.read_text().splitlines(keepends=True)[:100]))
    raw = read(recording)
    assert found(raw.findings, Found.CHANNELS_OF_UNEQUAL_LENGTH).count == 25
    assert raw.robot.table["time"].iloc[-1] == pytest.approx(99 * PERIOD)


@pytest.mark.parametrize(("count", "step"), [(125, 0.0039), (125, 0.003), (2, 0.001)])
def test_a_channel_faster_than_half_a_cycle_is_refused(
    recording: Path, count: int, step: float
) -> None:
    """However short: its times are not in seconds."""
    path = recording / "csv_files" / "log_q_actual.csv"
    rows = [line.split(",", 1)[1] for line in path.read_text().splitlines()[:count]]
    path.write_text("".join(f"{k * step:.4f},{row}\n" for k, row in enumerate(rows)))
    with pytest.raises(InputError, match=r"log_q_actual.csv: the median step"):
        read(recording)


def test_channels_of_two_runs_are_refused(recording: Path) -> None:
    path = recording / "csv_files" / "log_m_target.csv"
    write_channel(path, np.arange(9) + 99.0, np.ones((9, 6)))
    with pytest.raises(InputError, match="the channels have no frame in common"):
        read(recording)


# Tables


TABLE = {"format": "table-csv"}


def write_table(folder: Path, start: float = 0.0) -> None:
    time = np.arange(200) * 0.01
    q = 0.1 * np.sin(time[:, None] + np.arange(6))
    rows = np.column_stack([start + time, q, np.full_like(q, 0.5)])
    np.savetxt(folder / "log.csv", rows, delimiter=",", fmt="%.6f")


def test_units_and_skipped_columns(tmp_path: Path) -> None:
    write_table(tmp_path)
    entry = TABLE | {
        "folder": str(tmp_path),
        "file": "log.csv",
        "columns": ["time", "actual_q", "-", "-", "-", "-", "-", "actual_current_5"],
        "units": {"actual_q": "deg", "actual_current_5": "mA"},
    }
    robot = read_recording(entry).robot.table
    assert list(robot) == ["time", *(f"actual_q_{j}" for j in range(6)), "actual_current_5"]
    assert robot["actual_current_5"].eq(0.0005).all()
    assert robot["actual_q_1"].iloc[0] == pytest.approx(np.deg2rad(0.084147), abs=1e-9)


def test_rtde_names_in_other_units(tmp_path: Path, ur5: Robot) -> None:
    """Impossible values name the likely unit, and the entry takes it."""
    time = 0.008 * np.arange(100)
    columns = {f"actual_q_{k}": np.full_like(time, 60.0 + k) for k in range(6)}
    columns |= {f"actual_current_{k}": np.full_like(time, 1500.0) for k in range(6)}
    pd.DataFrame({"timestamp": time, **columns}).to_csv(tmp_path / "log.csv", index=False)
    entry: dict[str, Any] = {"format": "rtde-csv", "folder": str(tmp_path), "file": "log.csv"}
    for units, likely in (({}, "degrees"), ({"actual_q": "deg"}, "mA")):
        with pytest.raises(InputError, match=f"is it in {likely}"):
            read_and_check(entry | {"units": units}, ur5, 0.1)
    units = {"actual_q": "deg", "actual_current": "mA"}
    robot = read_recording(entry | {"units": units}).robot.table
    assert robot["actual_current_5"].eq(1.5).all()
    assert robot["actual_q_3"].iloc[0] == pytest.approx(np.deg2rad(63))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (
            {"units": {"actual_q": "furlong"}},
            "`units` in the study give actual_q in furlong; use one of",
        ),
        ({"units": {"target_q": "deg"}}, "`units` in the study give target_q in deg; use one of"),
        (
            {"columns": ["time", "actual_q", "actual_q"]},
            "name actual_q_0 twice; name each channel once",
        ),
        ({"file": "none.csv"}, "none.csv .*; add the file"),
        ({"columns": ["time", "actual_q"]}, "line 1: expected 7 numbers .*; correct `columns`"),
    ],
)
def test_a_wrongly_named_table_is_reported(tmp_path: Path, change: dict, sentence: str) -> None:
    write_table(tmp_path)
    columns = ["time", "actual_q", "actual_current"]
    entry = TABLE | {"folder": str(tmp_path), "file": "log.csv", "columns": columns} | change
    with pytest.raises(InputError, match=sentence):
        read_recording(entry)


@pytest.mark.parametrize("rate", [125, 43.478, 300])
def test_a_log_without_a_clock_has_the_rate_that_the_study_states(
    tmp_path: Path, ur5: Robot, rate: float
) -> None:
    """Its damaged rows count, too: they are gaps."""
    q = 0.1 * np.sin(np.arange(400)[:, None] / rate + np.arange(6))
    np.savetxt(tmp_path / "log.txt", q, fmt="%.9f")
    lines = (tmp_path / "log.txt").read_text().splitlines()
    lines[100] = lines[200] = "torn"
    (tmp_path / "log.txt").write_text("\n".join(lines) + "\n")
    entry = TABLE | {"folder": str(tmp_path), "file": "log.txt", "columns": ["actual_q"]}
    taken = read_and_check(entry | {"rate": rate}, ur5, 0.1)
    np.testing.assert_allclose(taken.robot["time"], np.arange(400) / rate, atol=1e-9)
    assert np.flatnonzero(taken.robot["interpolated"]).tolist() == [100, 200]
    np.testing.assert_allclose(channel(taken.robot, "actual_q"), q, atol=1e-5)


def test_joints_are_counted_as_the_arm_s_description_counts_them(
    tmp_path: Path, ur5: Robot
) -> None:
    """q = home + s recorded; what has no direction stays."""
    home, signs = np.array([0.0, -90, 90, 0, 45, 180]), np.array([1, -1, -1, 1, -1, 1])
    rows = np.random.default_rng(0).normal(size=(50, 30))
    names = ["actual_q", "target_q", "actual_qd", "actual_current", "joint_temperatures"]
    time = 0.01 * np.arange(len(rows))
    np.savetxt(tmp_path / "log.csv", np.column_stack([time, rows]), delimiter=",")
    entry = TABLE | {"folder": str(tmp_path), "file": "log.csv", "columns": ["time", *names]}
    stated = {"home_deg": home.tolist(), "directions": signs.tolist()}

    def counted(keys: dict[str, list[float]]) -> pd.DataFrame:
        recording = ENTRY.validate_python(entry | keys)
        return known_frames(read_recording(entry), counted_as(recording, ur5))[0]

    table = counted(stated)
    q, target_q, qd, current, temperature = np.split(rows, 5, axis=1)
    for name, expected in {
        "actual_q": np.radians(home) + signs * q,
        "target_q": np.radians(home) + signs * target_q,
        "actual_qd": signs * qd,
        "actual_current": signs * current,
        "joint_temperatures": temperature,
    }.items():
        np.testing.assert_allclose(channel(table, name), expected)
    for key, values in stated.items():
        with pytest.raises(InputError, match=f"`{key}` .* 5 entries .* has 6 joints; give one"):
            counted({key: values[1:]})


def test_sensors_of_a_table_have_their_own_clock(tmp_path: Path) -> None:
    epoch = 1.7e9
    write_table(tmp_path, epoch)
    rows = "".join(f"{epoch + 0.3 + k / 200:.4f};1,5;2;3;0;0;0\n" for k in range(300))
    (tmp_path / "force.csv").write_text(rows)
    sensor = {"file": "force.csv", "columns": ["time", "ft"], "time": "epoch_s"}
    entry = TABLE | {
        "folder": str(tmp_path),
        "file": "log.csv",
        "time": "epoch_s",
        "columns": ["time", "actual_q", "actual_current"],
        "force_sensor": sensor,
    }
    raw = read_recording(entry)
    record, start = place_sensors(raw, [])["force"]
    assert start.seconds == pytest.approx(0.3, abs=1e-3)
    assert record.table["ft_fx"].eq(1.5).all()


def test_a_part_of_a_recording_is_counted_on_where_the_clock_restarts(tmp_path: Path) -> None:
    entry = write_rtde(tmp_path, rows=500)
    path = tmp_path / "robot.csv"
    head, *rows = path.read_text().splitlines()
    again = [f"{0.002 * k:.4f};" + row.partition(";")[2] for k, row in enumerate(rows)]
    path.write_text("\n".join([head, *rows, *again, ""]))
    raw = read_recording(entry | {"from_s": 0.499, "to_s": 1.199})
    time = raw.robot.table["time"].to_numpy()
    assert (len(time), time[0], np.ptp(time[250:])) == pytest.approx((350, 0.5, 0.198))


# What users do to files before they get here

SPREADSHEETS = {  # a number, and what a spreadsheet program may have made of it
    "thousands": "1.801.822",
    "a date": "01. Feb",
    "another date": "Feb 17",
    "a time": "10:04.5",
    "a date with a time": "01.02.2024 10:04:05",
    "a narrow column": "#######",
}


def write_rtde(folder: Path, row: str = "{t};{q}", rows: int = 500, head: str = "") -> dict:
    """A recording at rest as a spreadsheet program saves it, and its entry in a study."""
    names = ";".join(["timestamp", *(f"actual_q_{j}" for j in range(6))])
    lines = [row.format(t=f"{9 + 0.002 * k:.4f}", q=";".join(["0.1"] * 6)) for k in range(rows)]
    (folder / "robot.csv").write_text(head + "\n".join([names, *lines]) + "\n")
    return {"format": "rtde-csv", "folder": str(folder), "file": "robot.csv"}


def test_the_separator_that_a_spreadsheet_program_names_is_skipped(tmp_path: Path) -> None:
    raw = read_recording(write_rtde(tmp_path, head="sep=;\n"))
    assert len(raw.robot.table) == 500


def test_a_robot_s_own_log_begins_at_zero_for_certain(tmp_path: Path) -> None:
    robot = read_recording(write_rtde(tmp_path)).robot
    assert (robot.start.seconds, robot.start.std) == (0.0, 0.0)
    assert robot.table["time"].iloc[0] == 0.0


@pytest.mark.parametrize("cell", SPREADSHEETS.values(), ids=SPREADSHEETS)
def test_what_a_spreadsheet_program_made_is_named(tmp_path: Path, cell: str) -> None:
    entry = write_rtde(tmp_path, row="{t};0.1;" + cell + ";0.1;0.1;0.1;0.1")
    sentence = (
        r"line 2: expected .*is not a number; a spreadsheet program may have .*record it again"
    )
    with pytest.raises(InputError, match=sentence):
        read_recording(entry)


@pytest.mark.parametrize("row", ["{t};{q}\t", "{t};{q}; ", "x;{q}", " ;{q};", "{t};{q};\t"])
def test_whatever_ends_a_line_its_fault_is_reported(tmp_path: Path, row: str) -> None:
    """Three lines are read, as where only a blank follows their numbers, or reported."""
    entry = write_rtde(tmp_path, rows=20)
    text = (tmp_path / "robot.csv").read_text()
    for mark in (";", "\t", " ", ","):
        lines = [row.format(t=9.5, q=";".join(["0.1"] * 6)).replace(";", mark)] * 3
        (tmp_path / "robot.csv").write_text(text.replace(";", mark) + "\n".join(lines) + "\n")
        raw = read_recording(entry)
        if row == "{t};{q}\t" and mark != "\t":
            assert not raw.findings
            assert raw.robot.table["time"].tolist()[20:] == pytest.approx([0.5] * 3)
        else:
            (damaged,) = raw.findings
            assert (damaged.code, damaged.count) == (Found.DAMAGED_LINES, 3)
            assert len(raw.robot.table) == 20


# The realtime port


def test_a_capture_of_the_port_is_taken_in(tmp_path: Path, ur5: Robot) -> None:
    """756-byte messages at 8 ms, each split between two reads; `received_s` counts from 1970."""
    time = np.arange(200) * PERIOD
    angle = time[:, None] + np.arange(6)
    channels = dict.fromkeys(fields(MESSAGE_BYTES), 0 * angle) | {
        **dict.fromkeys(("target_q", "actual_q"), 0.1 * np.sin(angle)),
        **dict.fromkeys(("target_qd", "actual_qd"), 0.1 * np.cos(angle)),
        "target_qdd": -0.1 * np.sin(angle),
    }
    columns = {n: c for name, values in channels.items() for n, c in named(values, name).items()}
    lines = ["received_s,payload_hex"]
    for k, message in enumerate(messages(pd.DataFrame({"time": time} | columns))):
        received = START + k * PERIOD
        lines += [
            f"{received:.6f},{message[:FIRST_PART_BYTES].hex()}",
            f"{received + 1e-3:.6f},{message[FIRST_PART_BYTES:].hex()}",
        ]
    (tmp_path / "capture.csv").write_text("\n".join(lines) + "\n")
    entry = {"format": "realtime-stream", "folder": str(tmp_path), "file": "capture.csv"}
    taken = intake(entry, ur5)
    assert taken.quality.findings == []
    np.testing.assert_allclose(taken.robot["time"], np.arange(200) * PERIOD, atol=1e-9)
    expected = 0.1 * np.sin(np.arange(200) * PERIOD + 3)
    np.testing.assert_allclose(taken.robot["actual_q_3"], expected, atol=1e-12)
    start = read_recording(entry).robot.start
    assert start is not None
    assert start.seconds == pytest.approx(START + 1e-3, abs=1e-6)


# All real recordings


THESIS_FINDINGS = {  # beside torn last lines and unequal lengths: DATA.md, defects
    "Movement_No1": {Found.NO_SENSOR, Found.LOST_FRAMES, "jitter"},
    "Movement_No2": {Found.NO_SENSOR, Found.LOST_FRAMES, "jitter"},
    "Movement_No3_Acc": {
        Found.NO_SENSOR,
        Found.LOST_FRAMES,
        "jitter",
        Found.NO_START_STAMP,
        Found.JOINT_LIMITS,
    },
    "Movement_No4_Acc": {Found.NO_SENSOR, Found.JOINT_LIMITS},
    "Movement_No10_Standstill_ForceSensor_All": {Found.STALE_COPY},
    "Movement_No10_Standstill_ForceSensor_Fx": {Found.STALE_COPY},
    "Movement_No9_Singularity_Free_ForceSensor": {Found.STALE_COPY},
}
CUT = {Found.TORN_LAST_LINE, Found.CHANNELS_OF_UNEQUAL_LENGTH}


def intake(entry: dict, arm: Robot) -> Intake:
    return read_and_check(entry, arm, max_gap=0.1)


def test_every_defect_of_the_thesis_is_found_and_no_other(thesis_data: Path, ur5: Robot) -> None:
    for folder in sorted(path for path in thesis_data.iterdir() if path.is_dir()):
        taken = intake({"format": "thesis-csv", "folder": str(folder)}, ur5)
        names = {finding.code for finding in taken.quality.findings}
        assert names - CUT == THESIS_FINDINGS.get(folder.name, {Found.NO_SENSOR}), folder.name
        torn = [said(f) for f in taken.quality.findings if f.code == Found.TORN_LAST_LINE]
        ragged = {
            path.name
            for path in (folder / "csv_files").glob("log_*.csv")
            if path.name not in ("log_tool_acc.csv", "log_force_sensor.csv")
            and not path.read_bytes().endswith(b"\n")
        }
        assert {detail.split(",")[0] for detail in torn} <= ragged


@pytest.mark.parametrize(
    ("name", "short", "long"),
    [("Movement_No1", 1135, 1108), ("Movement_No2", 669, 642), ("Movement_No3_Acc", 638, 612)],
)
def test_the_pattern_of_lost_frames_is_counted(
    thesis_data: Path, ur5: Robot, name: str, short: int, long: int
) -> None:
    """Figure 4.4: two frames lost after every second one."""
    folder = thesis_data / name
    stamps = np.loadtxt(
        line.split(b",")[0] for line in (folder / "csv_files/log_q_actual.csv").open("rb")
    )
    taken = intake({"format": "thesis-csv", "folder": str(folder)}, ur5)
    steps = np.diff(stamps[: taken.quality.rows])
    (lost,) = [f for f in taken.quality.findings if f.code == Found.LOST_FRAMES]
    assert f"{short} of 8 ms, {long} of 24 ms" in said(lost)
    assert lost.count == 2 * long
    assert (np.sum(steps <= 0.016), np.sum(steps > 0.016)) == (short, long)  # counted here


def test_every_log_of_the_ur10e_goes_through(ur10e_data: Path, real_ur10e: RealStudy) -> None:
    arm = load_robot(robot_path("ur10e"))
    logs = {path.stem for path in ur10e_data.glob("*.csv")}
    assert {*real_ur10e.entries} <= logs  # the folder has more of them than the study uses
    for name, entry in real_ur10e.entries.items():
        taken = intake(entry, arm)
        names = {finding.code for finding in taken.quality.findings}
        assert Found.IRREGULAR_STEPS in names
        damaged = {Found.TORN_LAST_LINE, Found.IMPOSSIBLE_FRAMES, "split"}
        assert names & damaged == (damaged if "15harm" in name else set()), name
        assert (Found.LOST_FRAMES in names) == name.endswith("-unload")  # one step of 30 ms
        assert Found.INCONSISTENT_CHANNELS not in names
        assert abs(taken.quality.duration_s / (0.0106 * taken.quality.rows) - 1) < 0.05


def table_of(columns: dict[str, np.ndarray | float], folder: Path) -> dict[str, object]:
    """The entry of a recording of an arm at rest, with these columns beside or instead."""
    rest = {"timestamp": np.arange(200) * 0.008} | {f"actual_q_{k}": 0.0 for k in range(6)}
    pd.DataFrame(rest | columns).to_csv(folder / "robot.csv", index=False)
    return {"format": "rtde-csv", "folder": str(folder), "file": "robot.csv"}


def test_only_an_endless_joint_may_be_anywhere(tmp_path: Path, ur5: Robot) -> None:
    entry = table_of({"actual_q_5": np.linspace(0, 18 * np.pi, 200)}, tmp_path)
    for name in ("ur3", "ur3e"):
        robot = intake(entry, load_robot(robot_path(name))).robot
        assert robot["actual_q_5"].max() == pytest.approx(18 * np.pi)
    with pytest.raises(InputError, match="actual_q_5 exceeds"):
        intake(entry, ur5)


def test_channels_that_nothing_uses_are_told_from_unknown_ones(tmp_path: Path, ur5: Robot) -> None:
    names = ["output_int_register_12", "standard_analog_input0", "output_bit_registers0_to_31"]
    names += ["i_actual_0", "actual_curent_0", "actual_qdd_0"]
    quality = intake(table_of(dict.fromkeys(names, 0.0), tmp_path), ur5).quality
    found = {one.code: one for one in quality.findings}
    assert found[Found.UNUSED_CHANNELS].count == 3
    assert said(found[Found.UNKNOWN_CHANNELS]).startswith("i_actual_0, actual_qdd_0: ")
    assert "actual_current is meant" in said(found[Found.MISSPELT_CHANNELS])


@pytest.mark.parametrize(
    ("columns", "finding"),
    [
        (FORCE_CHANNELS, Found.ASSUMED_FRAME),
        ([f"ft_{k}" for k in range(6)], Found.UNUSED_WRENCH),
        (FORCE_CHANNELS[:3], Found.NO_MOMENTS),
        (FORCE_CHANNELS[:4], Found.UNUSED_WRENCH),
        (FORCE_CHANNELS[1:], Found.UNUSED_WRENCH),
    ],
)
def test_a_wrench_in_the_robot_s_file_is_used_or_reported(
    tmp_path: Path, ur5: Robot, columns: list[str], finding: str
) -> None:
    taken = intake(table_of(dict.fromkeys(columns, 1.0), tmp_path), ur5)
    assert finding in {one.code for one in taken.quality.findings}
    assert ("ft_fx" in taken.robot) == ({*FORCES} <= {*columns})
    assert ("ft_tx" in taken.robot) == ({*FORCE_CHANNELS} <= {*columns})
