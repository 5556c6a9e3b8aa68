"""What a sensor's file has to hold: samples in order, of a sensor that was connected."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import said
from ur5lib.channels import columns
from ur5lib.errors import InputError
from ur5lib.recordings.delimited import read_numbers
from ur5lib.recordings.intake import with_wrist_sensor
from ur5lib.recordings.recording import Stamp
from ur5lib.recordings.sensors import FORCE_CHANNELS, first_number, read_device
from ur5lib.recordings.starts import robot_coverage, sensor_coverage
from ur5lib.records.codes import Found
from ur5lib.records.quality import Finding, Log
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import link_frames
from ur5lib.tables import named
from ur5lib.timeseries.arrays import Array

NAMES = ["time", *FORCE_CHANNELS]


def write(path: Path, time: np.ndarray, force: float = 1.0) -> Path:
    values = force * np.random.default_rng(0).uniform(0.5, 1.0, (len(time), 6))
    np.savetxt(path, np.column_stack([time, values]), delimiter=",", fmt="%.9g")
    return path


def read(path: Path) -> tuple[np.ndarray | None, dict[str, Finding]]:
    """The times of a force sensor's samples, and the findings."""
    findings: list[Finding] = []
    samples = read_device(Log(path, "force", findings), NAMES)
    time = None if samples is None else samples.table["time"].to_numpy()
    return time, {one.code: one for one in findings}


@pytest.mark.parametrize(("steps", "reported"), [(3.9, False), (4.1, True)])
def test_a_single_gap_is_told_from_four_steps_on(
    tmp_path: Path, steps: float, reported: bool
) -> None:
    time = 0.01 * np.arange(1000.0)
    time[500:] += 0.01 * (steps - 1)
    _, findings = read(write(tmp_path / "force.csv", time))
    assert list(findings) == [Found.LOST_SAMPLES] * reported
    if reported:
        assert findings[Found.LOST_SAMPLES].count == 3
        assert said(findings[Found.LOST_SAMPLES]) == "longest step 41 ms, median step 10.0 ms"


@pytest.mark.parametrize(("gaps", "reported"), [(10, False), (11, True)])
@pytest.mark.parametrize(("steps", "lost"), [(2.4, False), (2.6, True)])
def test_many_short_gaps_are_told_from_a_hundredth_on(
    tmp_path: Path, steps: float, lost: bool, gaps: int, reported: bool
) -> None:
    """Of two samples and a half, which is beyond ordinary jitter; two are lost in each."""
    step = np.full(1999, 0.01)
    step[100 : 100 + 10 * gaps : 10] *= steps
    time = np.concatenate([[0.0], np.cumsum(step)])
    _, findings = read(write(tmp_path / "force.csv", time))
    assert (Found.LOST_SAMPLES in findings) == (reported and lost)
    if reported and lost:
        assert findings[Found.LOST_SAMPLES].count == 2 * gaps


def test_stamps_of_whole_seconds_are_stale_and_lose_no_sample(tmp_path: Path) -> None:
    """More than half of all steps are zero then."""
    times, findings = read(write(tmp_path / "force.csv", np.floor(0.04 * np.arange(1000.0))))
    assert list(findings) == [Found.STALE_STAMPS]
    assert times is not None
    assert len(times) == 1000


@pytest.mark.parametrize(("still", "reported"), [(10, False), (11, True)])
def test_stale_stamps_are_told_from_a_hundredth_on(
    tmp_path: Path, still: int, reported: bool
) -> None:
    time = 0.01 * np.arange(1000.0)
    time[100 : 100 + 2 * still : 2] = time[99 : 99 + 2 * still : 2]
    times, findings = read(write(tmp_path / "force.csv", time))
    assert (Found.STALE_STAMPS in findings) == reported
    assert not reported or findings[Found.STALE_STAMPS].count == still
    assert times is not None
    assert len(times) == 1000


@pytest.mark.parametrize(("size", "connected"), [(9e-7, False), (3e-6, True)])
def test_a_sensor_that_reads_nothing_was_not_connected(
    tmp_path: Path, size: float, connected: bool
) -> None:
    """Up to a millionth of a newton; a device that is no force sensor may rest at zero."""
    path = write(tmp_path / "force.csv", 0.01 * np.arange(100.0), size)
    times, findings = read(path)
    assert (times is not None) == connected
    assert list(findings) == [Found.NO_SENSOR] * (not connected)
    names = ["time", *columns("imu_a"), *columns("imu_m")]
    assert read_device(Log(path, "imu", []), names) is not None


@pytest.mark.parametrize("content", [None, ""])
def test_a_missing_or_empty_file_is_no_sensor_once(tmp_path: Path, content: str | None) -> None:
    path = tmp_path / "force.csv"
    if content is not None:
        path.write_text(content)
    times, findings = read(path)
    assert times is None
    assert [(found.code, found.count) for found in findings.values()] == [(Found.NO_SENSOR, 1)]


@pytest.mark.parametrize(("rows", "usable"), [(1, False), (2, True)])
def test_a_sensor_has_two_samples(tmp_path: Path, rows: int, usable: bool) -> None:
    times, findings = read(write(tmp_path / "force.csv", 0.01 * np.arange(float(rows))))
    assert (times is not None) == usable
    if not usable:
        detail = "force.csv has fewer than two complete rows of 7 numbers"
        assert said(findings[Found.NO_SENSOR]) == detail


def test_samples_are_sorted_and_each_is_counted_once(tmp_path: Path) -> None:
    """Of two runs in one file, the first; cells that are empty take their sample along."""
    path = write(tmp_path / "force.csv", 0.01 * np.arange(200.0))
    lines = path.read_text().splitlines()
    lines[50], lines[51] = lines[51], lines[50]
    lines[80] = "0.80,,1,1,1,1,1"
    path.write_text("\n".join([*lines, lines[120]]) + "\n")
    times, findings = read(path)
    np.testing.assert_allclose(times, np.delete(0.01 * np.arange(200.0), 80))
    assert {name: one.count for name, one in findings.items()} == {
        Found.MISSING_CELLS: 1,
        Found.REPEATED_FRAMES: 1,
        Found.SAMPLES_OUT_OF_ORDER: 1,
    }
    runs = np.concatenate([5 + 0.01 * np.arange(100.0), 0.01 * np.arange(60.0)])
    times, findings = read(write(path, runs))
    assert findings[Found.CLOCK_RESET].count == 60
    np.testing.assert_allclose(times, 5 + 0.01 * np.arange(100.0))


@pytest.mark.parametrize(
    ("text", "ended", "number"),
    [
        ("12.5\n", True, 12.5),
        ("12.5", True, None),
        ("12.5", False, 12.5),
        ("12.5 13.5", True, 12.5),
        ("", False, None),
        ("inf\n", False, None),
        ("x\n", False, None),
    ],
)
def test_a_start_stamp_is_the_first_number(
    tmp_path: Path, text: str, ended: bool, number: float | None
) -> None:
    (tmp_path / "start.txt").write_text(text)
    assert first_number(tmp_path / "start.txt", ended) == number


@pytest.mark.parametrize(
    ("one", "other", "apart"),
    [
        (("epoch_s", 1000.0), ("epoch_s", 400.0), 600.0),
        (("relative_s", 3.0), ("relative_s", 5.0), -2.0),
        (("relative_s", 3.0), ("epoch_s", 5.0), None),
        (("relative_s", 3.0), ("day_ms", 5.0), None),
        (("day_ms", 10.0), ("day_ms", 86390.0), 20.0),
        (("day_ms", 86390.0), ("day_ms", 10.0), -20.0),
        (("epoch_s", 5 * 86400.0 + 10), ("day_ms", 86390.0), 20.0),
        (("day_ms", 43100.0), ("day_ms", 0.0), 43100.0),
    ],
)
def test_stamps_of_a_day_are_compared_around_midnight(
    one: tuple, other: tuple, apart: float | None
) -> None:
    stamps = [Stamp(seconds, 0.0, since) for since, seconds in (one, other)]
    assert stamps[0].after(stamps[1]) == (None if apart is None else pytest.approx(apart))


# Tables of numbers


def table(path: Path, rows: int, damaged: list[int]) -> Path:
    """Row k holds k and 2 k; lines that are damaged say something else."""
    lines = [f"{k},{2 * k}" for k in range(rows)]
    for line in damaged:
        lines[line - 1] = "1,2,3"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize(
    ("damaged", "reported"), [(5, "line 1, 2, 3, 4, 5 (it"), (6, "5 and 1 more")]
)
def test_the_first_five_damaged_lines_are_named(
    tmp_path: Path, damaged: int, reported: str
) -> None:
    findings: list[Finding] = []
    path = table(tmp_path / "t.csv", 50, [*range(1, damaged + 1)])
    read_numbers(Log(path, "robot", findings), ["a", "b"])
    assert reported in said(findings[0])


@pytest.mark.parametrize(("damaged", "refused"), [(25, False), (26, True)])
def test_a_table_of_which_most_lines_are_damaged_is_another(
    tmp_path: Path, damaged: int, refused: bool
) -> None:
    path = table(tmp_path / "t.csv", 50, [*range(1, damaged + 1)])
    if refused:
        with pytest.raises(InputError, match="26 of 50 lines do not fit"):
            read_numbers(Log(path, "robot", []), ["a", "b"])
    else:
        assert len(read_numbers(Log(path, "robot", []), ["a", "b"])) == 25


@pytest.mark.parametrize(
    ("other", "last", "whole"),
    [
        *((0, last, True) for last in ("7.25,8.25", "7.25,8.25\n")),
        *((0, last, False) for last in ("7.25,8.2", "7.25", "7.25,8")),
        (8, "7.25,8.25", True),
        (9, "7.25,8.25", False),
    ],
)
def test_a_last_line_without_an_end_has_the_form_of_the_twenty_before(
    tmp_path: Path, other: int, last: str, whole: bool
) -> None:
    """As many cells, and as many decimals in the last; other: a line that has fewer."""
    lines = ["1.5,2.5" if number == other else "1.25,2.25" for number in range(29)]
    (tmp_path / "t.csv").write_text("\n".join([*lines, last]))
    findings: list[Finding] = []
    table = read_numbers(Log(tmp_path / "t.csv", "robot", findings), ["a", "b"])
    assert len(table) == 29 + whole
    assert [one.code for one in findings] == [Found.TORN_LAST_LINE] * (not whole)
    assert all(said(one).startswith("t.csv, line 30: last line is cut off") for one in findings)


@pytest.mark.parametrize("empty", ["", "nan", "NaN", "NAN", "-nan", "NA", "N/A", "null", "NULL"])
@pytest.mark.parametrize("beside", ["", "x,y\n"])
def test_what_stands_for_no_number(tmp_path: Path, empty: str, beside: str) -> None:
    """Also where a damaged line has the others read one by one."""
    (tmp_path / "t.csv").write_text(f"1,2\n3,{empty}\n{beside}5,6\n")
    numbers = read_numbers(Log(tmp_path / "t.csv", "robot", []), ["a", "b"])
    np.testing.assert_array_equal(numbers["b"], [2, np.nan, 6])


@pytest.mark.parametrize(("place", "text"), [(999, False), (1000, True)])
def test_zeros_far_down_are_a_damaged_line(tmp_path: Path, place: int, text: bool) -> None:
    """As of a lost block of a disk; at the beginning, the file is none of text."""
    lines = b"1.5,2.5\n" * 200
    content = lines[:place] + b"\0" + lines[place + 1 :]
    (tmp_path / "t.csv").write_bytes(content)
    findings: list[Finding] = []
    if text:
        assert len(read_numbers(Log(tmp_path / "t.csv", "robot", findings), ["a", "b"])) == 199
        assert findings[0].code == Found.DAMAGED_LINES
    else:
        with pytest.raises(InputError, match="line 1: not a text file"):
            read_numbers(Log(tmp_path / "t.csv", "robot", findings), ["a", "b"])


# How much of a recording each device covers


LENGTH, STD = 200.0, 0.5  # s, of the robot's recording, and of a sensor's start stamp
SENSOR = 2 + 0.005 * LENGTH + 3 * STD  # s that may be missing: tolerance, drift, start stamp
ROBOT = 2 + 0.005 * LENGTH


@pytest.mark.parametrize("late", [0.0, 1.0])
@pytest.mark.parametrize(("beyond", "count"), [(-0.01, 0), (0.01, 1)])
def test_a_sensor_may_lack_as_much_as_its_clock_may_err(
    late: float, beyond: float, count: int
) -> None:
    span = late, LENGTH - (SENSOR - late) - beyond
    assert len(sensor_coverage("force", span, (0.0, LENGTH), STD)) == count


@pytest.mark.parametrize(("beyond", "count"), [(-0.01, 0), (0.01, 1)])
def test_a_robot_may_lack_as_much_as_its_clock_may_drift(beyond: float, count: int) -> None:
    robot = 0.0, LENGTH - ROBOT - beyond
    assert len(robot_coverage(robot, (0.0, LENGTH))) == count


@pytest.mark.parametrize(("late", "starts"), [(0.04, False), (0.06, True)])
def test_a_delay_that_rounds_to_nothing_is_not_mentioned(late: float, starts: bool) -> None:
    (finding,) = sensor_coverage("imu", (late, 100.0), (0.0, LENGTH), STD)
    assert ("after the robot" in said(finding)) == starts
    assert f"ends 100.0 s before {'it' if starts else 'the robot'};" in said(finding)


# The arm's own force sensor, from the columns of RTDE


ARM = load_robot(robot_path("ur5e"))
RANDOM = np.random.default_rng(1)
Q, WRENCH = RANDOM.uniform(-1, 1, (50, 6)), RANDOM.normal(size=(50, 6))


def recorded(**channels: Array) -> pd.DataFrame:
    columns: dict[str, Array] = {}
    for name, values in {"actual_q": Q, **channels}.items():
        columns |= named(values, name)
    return pd.DataFrame({"time": 0.002 * np.arange(50), **columns})


def test_the_raw_reading_is_taken_as_it_is() -> None:
    findings: list[Finding] = []
    robot = with_wrist_sensor(recorded(ft_raw_wrench=WRENCH), ARM, False, findings)
    np.testing.assert_array_equal(robot[FORCE_CHANNELS], WRENCH)
    assert [(one.device, one.severity) for one in findings] == [("force", "note")]


def test_the_controller_s_force_is_turned_into_the_flange_s_axes() -> None:
    """Only where the raw reading is missing."""
    robot = with_wrist_sensor(recorded(actual_TCP_force=WRENCH), ARM, False, [])
    rotation = link_frames(ARM, Q)[0][:, 6]
    back = np.einsum("nij,nhj->nhi", rotation, robot[FORCE_CHANNELS].to_numpy().reshape(-1, 2, 3))
    np.testing.assert_allclose(back.reshape(-1, 6), WRENCH, atol=1e-12)
    both = recorded(actual_TCP_force=WRENCH, ft_raw_wrench=2 * WRENCH)
    raw = with_wrist_sensor(both, ARM, False, [])
    np.testing.assert_array_equal(raw[FORCE_CHANNELS], 2 * WRENCH)


@pytest.mark.parametrize("name", ["ft_raw_wrench", "actual_TCP_force"])
def test_a_constant_is_no_sensor(name: str) -> None:
    silent = recorded(**{name: np.zeros((50, 6))})
    findings: list[Finding] = []
    assert with_wrist_sensor(silent, ARM, False, findings) is silent
    assert not findings


def test_an_arm_without_a_wrist_sensor_has_none() -> None:
    """The controller of a CB3 estimates actual_TCP_force from currents."""
    estimated = recorded(actual_TCP_force=WRENCH)
    assert with_wrist_sensor(estimated, load_robot(robot_path("ur5")), False, []) is estimated


def test_another_sensor_that_the_study_names_comes_first() -> None:
    findings: list[Finding] = []
    robot = with_wrist_sensor(recorded(ft_raw_wrench=WRENCH), ARM, True, findings)
    assert not {*FORCE_CHANNELS} & {*robot}
    assert "another force sensor" in said(findings[0])
