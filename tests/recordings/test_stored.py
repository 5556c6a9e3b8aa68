"""Files that hold arrays: HDF5, MAT, ROS bags, Parquet, Feather, one file a channel."""

import json
import random
import re
import subprocess
import sys
import tomllib
from contextlib import suppress
from importlib import metadata
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pytest
from hypothesis import given
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from tests.command import time_limit
from tests.conftest import PROJECT
from tests.damage import DRAWS, FLIPPED, compare, damaged_file, drawn, findings
from tests.entries import read_and_check, read_recording
from tests.stored_files import (
    JOINTS,
    WRITERS,
    Made,
    entry_of,
    frame,
    made_up_channels,
    write,
    write_bag,
    write_channel_files,
    write_hdf5,
    write_npz,
)
from ur5lib.errors import InputError
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import import_files
from ur5lib.recordings.intake import Intake
from ur5lib.recordings.recording import RawRecording
from ur5lib.recordings.starts import place_sensors
from ur5lib.records.codes import Found
from ur5lib.robots.description import Robot
from ur5lib.signals.clock import clock_from_stamps
from ur5lib.signals.device_clock import device_clock
from ur5lib.tables import channel

KINDS = ("hdf5", "mat", "mat 7.3", "rosbag", "rosbag mcap", "rosbag 1")
JARGON = re.compile(r"Traceback|Error\b|Exception|numpy|NoneType|dtype|0x[0-9a-f]+|h5py|sqlite")
SECONDS = 10  # for one file
IMPORTED = 0.15  # share of the damaged files that are imported, too


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    return made_up_channels(tmp_path_factory.mktemp("made"))


def same(raw: RawRecording, made: Made, names: list[str]) -> None:
    """Assert that a recording holds what was written."""
    time, channels = made
    np.testing.assert_allclose(raw.robot.table["time"], time - time[0], atol=2e-6)
    for name in names:
        np.testing.assert_allclose(channel(raw.robot.table, name), channels[name], atol=1e-9)


@pytest.mark.parametrize("kind", WRITERS)
def test_each_format_gives_what_was_written(tmp_path: Path, made: Made, kind: str) -> None:
    entry = write(kind, tmp_path, *made)
    raw = read_recording(entry)
    same(raw, made, [name for name in entry["channels"] if name != "time"])
    assert raw.findings == []


@pytest.mark.parametrize("kind", [kind for kind in WRITERS if not kind.startswith("ros")])
def test_a_rate_takes_the_place_of_stamps(tmp_path: Path, made: Made, kind: str) -> None:
    entry = write(kind, tmp_path, *made)
    del entry["channels"]["time"]
    raw = read_recording(entry | {"rate": 125})
    same(raw, made, [*entry["channels"]])
    assert raw.cycle == 0.008


def test_a_sensor_beside_arrays_without_stamps_has_a_rate_too(tmp_path: Path, made: Made) -> None:
    force = np.random.default_rng(1).normal(size=(len(made[0]), 3))
    write_hdf5(tmp_path / "run.h5", made[0], made[1] | {"force": force})
    entry = entry_of("hdf5", tmp_path / "run.h5", ["actual_q"]) | {"rate": 125}
    del entry["channels"]["time"]
    entry["force_sensor"] = {"channels": {"ft_f": "run/force"}, "rate": 125}
    raw = read_recording(entry)
    np.testing.assert_allclose(raw.sensors["force"].table["time"], raw.robot.table["time"])


def test_the_columns_of_any_number_of_joints_may_be_reordered(tmp_path: Path) -> None:
    q, order = np.random.default_rng(3).normal(size=(90, 7)), [2, 1, 3, 4, 7, 6, 5]
    shuffled = q[:, [joint - 1 for joint in order]]
    np.savez(tmp_path / "run.npz", time=0.01 * np.arange(90), actual_q=shuffled)
    entry = entry_of("npz", tmp_path / "run.npz", ["actual_q"]) | {"joints": order}
    table = read_recording(entry).robot.table
    np.testing.assert_allclose(table[[f"actual_q_{joint}" for joint in range(7)]], q)
    with pytest.raises(InputError, match=r"lists 6 joints, but .* has 7; list the joint"):
        read_recording(entry | {"joints": [1, 2, 3, 4, 5, 6]})


def test_arrays_may_be_turned_and_stamps_may_be_pairs(tmp_path: Path, made: Made) -> None:
    time, channels = made
    epoch = time + 1577738076.0
    write_hdf5(tmp_path / "run.h5", epoch, channels, turned=True)
    raw = read_recording(entry_of("hdf5", tmp_path / "run.h5", [*channels]) | {"time": "epoch_s"})
    same(raw, made, [*channels])
    assert raw.robot.start is not None
    assert raw.robot.start.seconds == pytest.approx(epoch[0])


def test_columns_are_put_in_the_arm_s_order(tmp_path: Path, made: Made) -> None:
    order = [3, 2, 1, 4, 5, 6]
    shuffled = {name: values[:, [j - 1 for j in order]] for name, values in made[1].items()}
    pose = "actual_TCP_pose"
    shuffled[pose] = made[1][pose]
    write_hdf5(tmp_path / "run.h5", made[0], shuffled)
    entry = entry_of("hdf5", tmp_path / "run.h5", [*shuffled])
    same(read_recording(entry | {"joints": order}), made, [*made[1]])


def test_a_channel_may_be_made_of_several_arrays(tmp_path: Path, made: Made) -> None:
    time, channels = made
    parts = {"position": channels["actual_TCP_pose"][:, :3]}
    parts |= {f"r{k}": channels["actual_TCP_pose"][:, 3 + k : 4 + k] for k in range(3)}
    write_hdf5(tmp_path / "run.h5", time, channels | parts)
    entry = entry_of("hdf5", tmp_path / "run.h5", ["actual_q"])
    entry["channels"]["actual_TCP_pose"] = ["run/position", "run/r0", "run/r1", "run/r2"]
    same(read_recording(entry), made, ["actual_q", "actual_TCP_pose"])


def test_a_sensor_may_lie_in_the_robot_s_file(tmp_path: Path, made: Made) -> None:
    force = np.random.default_rng(1).normal(size=(len(made[0]), 3))
    stamps = 3.0 + made[0]
    own = {"force": force, "torque": force / 9, "stamps": stamps}
    write_hdf5(tmp_path / "run.h5", made[0], made[1] | own)
    entry = entry_of("hdf5", tmp_path / "run.h5", ["actual_q"])
    its = {"time": ["run/stamps"], "ft_f": "run/force", "ft_t": "run/torque"}
    entry["force_sensor"] = {"channels": its}
    sensor = read_recording(entry).sensors["force"]
    np.testing.assert_allclose(sensor.table[["ft_fx", "ft_fy", "ft_fz"]], force)
    assert sensor.start is not None
    assert sensor.start.seconds == pytest.approx(stamps[0])
    np.testing.assert_allclose(sensor.table["time"], stamps - stamps[0], atol=1e-12)


@pytest.mark.parametrize("clock", [{}, {"time": "epoch_s"}])
def test_a_sensor_with_the_robot_s_stamps_is_late_by_less_than_a_sample(
    tmp_path: Path, made: Made, clock: dict[str, str]
) -> None:
    """Whatever its entry says of the clock that the robot's says, too."""
    stamps, wrench = 1000 * (9.0 + made[0]), np.random.default_rng(4).normal(size=(len(made[0]), 6))
    write_npz(tmp_path / "run.npz", stamps, made[1] | {"wrench": wrench})
    entry = entry_of("npz", tmp_path / "run.npz", ["actual_q"])
    entry |= {"time": "epoch_s", "units": {"time": "ms"}}
    entry["force_sensor"] = {"channels": {"time": "time", "ft": "wrench"}} | clock
    record, start = place_sensors(read_recording(entry), [])["force"]
    np.testing.assert_allclose(record.table["time"], made[0] - made[0][0], atol=1e-9)
    assert (start.seconds, start.drift_std) == (0.0, 0.0)
    assert 0 < start.std < np.diff(made[0]).min()
    nothing = np.zeros((0, 3))
    stated = clock_from_stamps(start.seconds, start.std, start.drift_std)
    assert device_clock(np.zeros(0), nothing, stated, (nothing,) * 3, (nothing,) * 2)[0] == stated


def test_the_same_stamps_of_another_clock_leave_a_doubt(tmp_path: Path, made: Made) -> None:
    own = {"wrench": np.ones((len(made[0]), 6)), "stamps": made[0]}
    write_npz(tmp_path / "run.npz", made[0], made[1] | own)
    entry = entry_of("npz", tmp_path / "run.npz", ["actual_q"])
    entry["force_sensor"] = {"channels": {"time": "stamps", "ft": "wrench"}}
    _, start = place_sensors(read_recording(entry), [])["force"]
    assert (start.std > 0.05, start.drift_std) == (True, None)


# Bags


PANEL = ["Base", "Shoulder", "Elbow", "Wrist 1", "Wrist 2", "Wrist 3"]  # the teach panel's names
BAGS = [  # a file, the order of its columns, their names, others' messages, and the finding
    (
        "run.db3",
        [2, 1, 0, 3, 5, 4],
        [f"left_{name}_joint" for name in JOINTS],
        9,
        Found.OTHER_MESSAGES,
    ),
    ("run.bag", [5, 4, 3, 2, 1, 0], PANEL, 0, ""),
    ("run.mcap", [0, 1, 2, 3, 4, 5], [f"j{k}" for k in range(6)], 0, Found.UNNAMED_JOINTS),
]


@pytest.mark.parametrize(("file", "order", "names", "others", "finding"), BAGS)
def test_joints_of_a_bag_are_ordered_by_their_names(
    tmp_path: Path,
    made: Made,
    file: str,
    order: list[int],
    names: list[str],
    others: int,
    finding: str,
) -> None:
    shuffled = {name: made[1][name][:, order] for name in ("actual_q", "actual_qd")}
    write_bag(tmp_path / file, made[0], shuffled, [names[k] for k in order], others)
    raw = read_recording(entry_of("rosbag", tmp_path / file, [*shuffled]))
    same(raw, made, [*shuffled])
    assert [one.code for one in raw.findings] == [finding] * bool(finding)
    assert not others or raw.findings[0].count == others


def test_units_may_be_a_number_for_each_column(tmp_path: Path, made: Made) -> None:
    write_hdf5(tmp_path / "run.h5", *made)
    entry = entry_of("hdf5", tmp_path / "run.h5", ["actual_q"])
    factors = [1.0, -1.0, 2.0, 0.5, 1.0, 1.0]
    table = read_recording(entry | {"units": {"actual_q": factors}}).robot.table
    np.testing.assert_allclose(channel(table, "actual_q"), factors * made[1]["actual_q"])
    with pytest.raises(InputError, match="a number for each of its columns"):
        read_recording(entry | {"units": {"actual_q": factors[1:]}})


def test_a_wrench_of_a_bag_has_its_own_stamps(tmp_path: Path, made: Made) -> None:
    wrench = np.random.default_rng(2).normal(size=(len(made[0]), 6))
    kept = {"actual_q": made[1]["actual_q"]}
    write_bag(tmp_path / "run.db3", made[0], kept, wrench=wrench)
    entry = entry_of("rosbag", tmp_path / "run.db3", ["actual_q"])
    its = {"time": "/wrench/bag_stamp", "ft_f": "/wrench/force", "ft_t": "/wrench/torque"}
    entry["force_sensor"] = {"channels": its}
    sensor = read_recording(entry).sensors["force"].table
    np.testing.assert_allclose(sensor.drop(columns="time"), wrench)


# What is wrong is reported


def test_an_array_that_is_missing_is_reported(tmp_path: Path, made: Made) -> None:
    write_hdf5(tmp_path / "run.h5", *made)
    entry = entry_of("hdf5", tmp_path / "run.h5", ["actual_q", "target_q"])
    with pytest.raises(InputError, match=r"run.h5: target_q names run/target_q, which .*; correct"):
        read_recording(entry)


def test_arrays_of_another_length_are_reported(tmp_path: Path, made: Made) -> None:
    time, channels = made
    write_hdf5(tmp_path / "run.h5", time, channels | {"actual_qd": channels["actual_qd"][:-3]})
    entry = entry_of("hdf5", tmp_path / "run.h5", [*channels])
    with pytest.raises(InputError, match=r"actual_qd.* has shape .* stamps .*; correct"):
        read_recording(entry)


@pytest.mark.parametrize("line", ["", "lost"])
def test_a_line_without_a_number_would_shift_the_rows(
    tmp_path: Path, made: Made, line: str
) -> None:
    write_channel_files(tmp_path / "run", *made)
    file = tmp_path / "run/actual_q.txt"
    lines = file.read_text().splitlines()
    file.write_text("\n".join([*lines[:99], line, *lines[99:]]) + "\n")
    entry = entry_of("channel-files", tmp_path / "run", ["actual_q"])
    with pytest.raises(InputError, match=r"actual_q.txt has lines without a number, .*; correct"):
        read_recording(entry)


BASE = """
import json, sys
packages, entries = json.loads(sys.stdin.read())
sys.modules.update(dict.fromkeys(packages))  # as if these were not installed
from ur5lib.recordings.entries import ENTRY
from ur5lib.recordings.formats import read_recording
print(*(len(read_recording(ENTRY.validate_python(entry)).robot.table) for entry in entries))
"""


def not_of_the_base_install() -> list[str]:
    """Packages that are here, but not among those that `pip install .` brings."""
    project = tomllib.loads((PROJECT / "pyproject.toml").read_text())["project"]
    waiting, brought = [Requirement(line) for line in project["dependencies"]], set[str]()
    while waiting:
        one = waiting.pop()
        name = canonicalize_name(one.name)
        if name not in brought and (not one.marker or one.marker.evaluate({"extra": ""})):
            brought.add(name)
            waiting += map(Requirement, metadata.requires(name) or [])
    here = metadata.packages_distributions().items()
    given = {package for package, names in here if {*map(canonicalize_name, names)} & brought}
    return sorted({package for package, _ in here} - given - {"ur5lib", "_distutils_hack"})


def test_the_base_install_reads_every_format(tmp_path: Path, made: Made) -> None:
    entries = [write(kind, tmp_path, *made) for kind in WRITERS]
    told = json.dumps([not_of_the_base_install(), entries])
    run = [sys.executable, "-c", BASE]
    counts = subprocess.check_output(run, input=told, text=True, cwd=PROJECT)
    assert counts.split() == [str(len(made[0]))] * len(WRITERS)


def test_a_block_that_was_never_written_is_reported(tmp_path: Path, made: Made, ur5: Robot) -> None:
    time, channels = made
    q = channels["actual_q"].copy()
    q[200:285] = 0.0
    write_hdf5(tmp_path / "run.h5", time, channels | {"actual_q": q})
    taken = read_and_check(entry_of("hdf5", tmp_path / "run.h5", [*channels]), ur5, 0.1)
    assert Found.ZEROED_CELLS in [finding.code for finding in taken.quality.findings]
    assert (np.abs(taken.robot["actual_q_1"]) > 0.5).all()


@pytest.mark.parametrize("kind", ["hdf5", "parquet", "table"])
def test_a_channel_that_was_never_written_is_not_recorded(
    tmp_path: Path, made: Made, ur5: Robot, kind: str
) -> None:
    """A driver's efforts are what its memory held, nearer to zero than any number, or zero."""
    time, channels = made
    stray = np.tile([-5.4e-310, 0.0, -3.5e-308, 1e-320, 0.0, 2e-308], (len(time), 1))
    channels = {name: channels[name] for name in ("actual_q", "actual_qd")}
    channels["actual_current"] = stray
    if kind == "table":
        frame(time, channels).to_csv(tmp_path / "run.csv", index=False)
        entry = {"format": "table-csv", "folder": str(tmp_path), "file": "run.csv"}
        entry |= {"columns": ["time", *channels]}
    else:
        entry = write(kind, tmp_path, time, channels)
    taken = read_and_check(entry, ur5, 0.1)
    assert "actual_current_0" not in taken.robot
    reported = [one.code for one in taken.quality.findings]
    assert Found.UNWRITTEN_CHANNELS in reported
    assert Found.ZEROED_CELLS not in reported
    (found,) = import_files([tmp_path / entry["file"]], UserStatement("ur5"))
    named = found.entry["columns" if kind == "table" else "channels"]
    assert not any("actual_current" in name for name in named)
    (row,) = (row for row in found.account if "actual_current" in row.subject)
    assert (row.confidence, "not recorded" in row.reason) == ("left out", True)


def test_velocities_and_currents_that_are_missing_are_replaced(
    tmp_path: Path, made: Made, ur5: Robot
) -> None:
    time, channels = made
    torque = np.array(ur5.maker_torque_constants()) * channels["actual_current"]
    kept = {"actual_q": channels["actual_q"], "actual_current_as_torque": torque}
    write_hdf5(tmp_path / "run.h5", time, kept)
    taken = read_and_check(entry_of("hdf5", tmp_path / "run.h5", [*kept]), ur5, 0.1)
    reported = {finding.code for finding in taken.quality.findings}
    assert {Found.NO_VELOCITIES, Found.CURRENTS_FROM_TORQUES} <= reported
    np.testing.assert_allclose(channel(taken.robot, "actual_current"), channels["actual_current"])


# Damage


class Whole(NamedTuple):
    """An undamaged file: its entry, its bytes, and what is read from it."""

    entry: dict[str, Any]
    data: bytes
    taken: Intake


@pytest.fixture(scope="module")
def wholes(tmp_path_factory: pytest.TempPathFactory, ur5: Robot) -> dict[str, Whole]:
    folder = tmp_path_factory.mktemp("whole")
    made, found = made_up_channels(folder, seconds=4), {}
    for kind in KINDS:
        entry = write(kind, folder, *made)
        data = (folder / entry["file"]).read_bytes()
        found[kind] = Whole(entry, data, read_and_check(entry, ur5, 0.1))
    return found


@pytest.mark.parametrize("kind", KINDS)
@drawn(24)
@given(draw=DRAWS)
def test_damaged_files_get_an_honest_answer(
    wholes: dict[str, Whole], ur5: Robot, kind: str, draw: random.Random
) -> None:
    """Refused with a clear message, a finding, right, or with a few possible numbers."""
    whole = wholes[kind]
    _, data, in_place = damaged_file(whole.data, draw)
    path = Path(whole.entry["folder"], f"damaged_{whole.entry['file']}")
    path.write_bytes(data)
    if draw.random() < IMPORTED:
        expect_right_import(path, whole)
    try:
        with time_limit(SECONDS):
            taken = read_and_check(whole.entry | {"file": path.name}, ur5, 0.1)
    except InputError as error:
        message = str(error)
        assert path.name in message
        assert "; " in message
        assert "\n" not in message
        assert not JARGON.search(message)
        return
    wrong, lost = compare(taken.robot, whole.taken.robot)
    possible = in_place and not lost and wrong <= FLIPPED
    assert possible or not (wrong or lost) or findings(taken) - findings(whole.taken), wrong


def expect_right_import(path: Path, whole: Whole) -> None:
    """Import refuses a damaged file, or finds in it what the whole one has."""
    with suppress(InputError):
        (one,) = import_files([path], UserStatement("ur5"))
        assert one.entry["channels"].items() <= whole.entry["channels"].items()
        assert "joints" not in one.entry
