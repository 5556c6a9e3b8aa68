"""`ur5 record`: what it asks, refuses, and leaves behind."""

import io
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml
from rich.console import Console
from typer.testing import CliRunner

from tests.conftest import PROJECT
from tests.entries import read_recording
from tests.examples import examples
from ur5lab.doubles.controller_double import ControllerDouble
from ur5lab.doubles.device_double import HOST
from ur5lab.doubles.net_ft_double import NetFTDouble
from ur5lab.doubles.transmission import TransmissionFaults
from ur5lab.record import RecordOptions, record
from ur5lab.recorded_study import StudyFile
from ur5lab.recorder import display
from ur5lab.recorder.capture import Status
from ur5lab.recorder.commanded_motion import CommandedMotion, dense_path, read_motion, refusals
from ur5lab.recorder.device import Identity
from ur5lab.recorder.session import is_taken, new_folder
from ur5lab.rtde_variables import RuntimeState
from ur5lib.channels import columns
from ur5lib.cli import app
from ur5lib.errors import InputError
from ur5lib.recordings.starts import place_sensors
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.truth import Truth
from ur5lib.study.devices import ArmSettings, LabSettings
from ur5lib.study.reading import read_study
from ur5lib.tables import read_json, write_text

HOME = np.array([0.5, -1.6, 1.6, -1.5, 1.5, 0.3])
STUDY = """\
study: lab
title: First day in the lab
robot: ur5e
devices:
  robot: {address: 127.0.0.1}
"""


@pytest.fixture
def study(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lab.yaml").write_text(STUDY)
    return Path("lab.yaml")


def at(q: np.ndarray) -> SimulatedRecording:
    """An arm at rest."""
    return SimulatedRecording.model_validate(
        {"trajectory": {"kind": "standstill", "posture": q.tolist()}}
    )


def console() -> Console:
    return Console(file=io.StringIO(), width=200)


def said(console: Console) -> str:
    assert isinstance(console.file, io.StringIO)
    return console.file.getvalue()


# From the devices to the study


def on_the_double_of_an_arm(test: Callable[..., None]) -> Callable[..., None]:
    """A test in real time, alone on the ports of a controller."""
    marked: Callable[..., None] = pytest.mark.usefixtures("controller_ports")(test)
    return pytest.mark.slow(pytest.mark.real_time(marked))


def has_kept_up(folder: Path) -> bool:
    """Whether the double was as late in the last fifth of a recording as in the one before."""
    robot = pd.read_csv(folder / "robot.csv")
    late = (robot["host_time"] - robot["timestamp"]).to_numpy()
    *_, before, last = (part.min() for part in np.array_split(late, 5))
    return bool(abs(before - last) < 0.001)


def expect_truth(folder: Path, entry: dict[str, Any]) -> None:
    """The truth about a session: what the encoders read, and when the sensors' first samples were.

    The encoders read it but for their noise, and the clocks are told within 2 ms.
    """
    raw = read_recording(entry)
    truth = Truth.read(folder / "truth.parquet").at(raw.robot.table["time"].to_numpy())
    assert {*columns("wrench_calc_from_currents")} <= {*raw.robot.table}
    read = np.array([raw.robot.table[f"actual_q_{joint}"] for joint in range(6)]).T
    np.testing.assert_allclose(truth.q, read, rtol=0, atol=1e-4)
    if not has_kept_up(folder):
        pytest.skip("this computer is too busy to emulate the arm: its stamps come late")
    clocks = read_json(folder / "truth.json")["clocks"]
    starts = {name: start.seconds for name, (_, start) in place_sensors(raw, []).items()}
    assert starts == pytest.approx({n: one["offset_s"] for n, one in clocks.items()}, abs=0.002)


@pytest.mark.parametrize("emulate", [True, False])
def test_a_missing_package_for_the_imu_is_asked_for_before_anything_moves(
    study: Path, monkeypatch: pytest.MonkeyPatch, emulate: bool
) -> None:
    """Before, after the arm had moved to its start for a minute."""
    monkeypatch.setitem(sys.modules, "serial", None)
    text = study.read_text()
    study.write_text(text if emulate else text + "  imu: {port: /dev/ttyUSB0}\n")
    options = RecordOptions("swing", "fit", move=Path("swing.csv"), yes=True, emulate=emulate)
    with pytest.raises(InputError, match=r"`--without imu` .* extra `record`"):
        record(study, options, console())
    assert not Path("raw").exists()


@on_the_double_of_an_arm
def test_the_arm_follows_a_file_and_the_recording_ends_with_it(study: Path) -> None:
    pytest.importorskip("rtde_control")
    time = np.arange(0, 2, 0.02)
    swing = 0.3 * np.sin(np.pi * time / 2) ** 2
    np.savetxt("swing.csv", np.column_stack([time, HOME + swing[:, None]]), delimiter=",")
    options = RecordOptions(
        "swing", "fit", without=("imu", "force_sensor"), move=Path("swing.csv"), speed=1.0,
        yes=True, emulate=True,
    )  # fmt: skip
    screen = console()
    record(study, options, screen)
    moved = pd.read_csv("raw/lab/swing/robot.csv")
    assert np.ptp(moved["actual_q_0"]) == pytest.approx(0.3, abs=0.02)
    assert moved["actual_q_0"].iloc[-1] == pytest.approx(HOME[0], abs=0.01)
    assert "joint 1, 2, 3, 4, 5, 6 " in said(screen)
    assert "recordings" not in yaml.safe_load(study.read_text())  # without --add, it is printed
    assert "- name: swing" in said(screen)


@pytest.mark.thorough
@on_the_double_of_an_arm
def test_an_arm_that_is_led_by_hand_is_recorded(study: Path) -> None:
    """By a hand that pulls again and again, from before freedrive until after it."""
    pytest.importorskip("rtde_control")
    pull = {"kind": "spring", "displacement": [0.0, 0.1, 0.0], "seconds": 2}
    plan = at(HOME).model_dump() | {"contacts": [pull | {"start_s": 2 * k} for k in range(30)]}
    screen = console()
    with ControllerDouble("ur5e", plan=SimulatedRecording.model_validate(plan)) as arm:
        record(study, RecordOptions("led", "contact", seconds=6, by_hand=True, yes=True), screen)
        assert np.abs(arm.truth.part("qd", arm.truth.latest())).max() < 0.05
    led = pd.read_csv("raw/lab/led/robot.csv")
    turned = np.abs(led[[f"actual_q_{joint}" for joint in range(6)]].to_numpy() - HOME)
    begin = int((led["runtime_state"] == RuntimeState.PLAYING).to_numpy().argmax())
    assert turned[: begin + 1].max() < 0.01
    assert turned.max() > 0.2
    assert set(led["safety_mode"]) == {1}
    assert "the motion ended early" not in said(screen)


@on_the_double_of_an_arm
def test_nothing_moves_without_a_yes_or_a_plan(
    study: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Not by a line through a singularity, nor with a wait between commands of a file of none."""
    pytest.importorskip("rtde_control")
    np.savetxt("points.csv", np.array([HOME, HOME + 0.2]), delimiter=",")
    here, there = (HOME + np.array([0, 0, 0, 0, turn, 0]) for turn in (-1.1, -1.9))
    Path("moves.txt").write_text(f"movej({here.tolist()})\nmovel({there.tolist()})\n")
    screen = console()
    monkeypatch.setattr(screen, "input", lambda *_: "y")
    with ControllerDouble("ur5e", plan=at(HOME)):
        for given, sentence in (
            ({"move": Path("points.csv")}, "not confirmed"),
            ({"by_hand": True}, "not confirmed"),
            ({"move": Path("moves.txt"), "yes": True}, "line 2: .* singularity"),
            ({"move": Path("points.csv"), "wait": 3.0, "yes": True}, "--wait: points.csv"),
        ):
            options = RecordOptions("points", "fit", **given)
            with pytest.raises(InputError, match=sentence):
                record(study, options, screen)
            assert not Path("raw").exists()


@pytest.mark.thorough
@on_the_double_of_an_arm
def test_the_page_is_followed_word_for_word(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its study, and its commands in their order, on the doubles of a laboratory."""
    pytest.importorskip("rtde_control")
    monkeypatch.chdir(tmp_path)
    blocks = examples(PROJECT / "docs" / "recordings.md")
    (page,) = (block.text for block in blocks if block.text.startswith("study: lab"))
    Path("lab.yaml").write_text(page)
    (way_points,) = (block.text for block in blocks if block.text.startswith("0.5, -1.6"))
    Path("points.csv").write_text(way_points)
    (moves,) = (block.text for block in blocks if block.text.startswith("movej"))
    Path("moves.txt").write_text(moves)
    lines = [line for block in blocks for line in block.text.splitlines()]
    commands = [line for line in lines if line.startswith("ur5 record lab.yaml")]
    assert len(commands) == 4
    for command in commands:
        done = CliRunner().invoke(app, command.split()[1:], input="yes\n")
        assert done.exit_code == 0, done.output
    assert "next: ur5 run lab.yaml" in done.output
    _, pushed = recordings = read_study(Path("lab.yaml")).recordings
    assert [(one.name, one.role) for one in recordings] == [("free", "fit"), ("pushed", "contact")]
    assert (
        yaml.safe_load(Path("lab.yaml").read_text())["devices"] == yaml.safe_load(page)["devices"]
    )
    expect_moves(pd.read_csv("raw/lab/moves/robot.csv"))
    for name in ("rest", "free", "moves", "pushed"):
        files = {file.name for file in Path("raw/lab", name).iterdir()}
        recorded = {"robot.csv", "force_sensor.csv", "imu.csv", "manifest.json"}
        assert files == recorded | {"truth.parquet", "truth.json"}
    assert (pushed.format, pushed.truth) == ("rtde-csv", "truth")
    expect_truth(Path("raw/lab/pushed"), pushed.model_dump())


def expect_moves(moved: pd.DataFrame) -> None:
    """The page's moves: from the start and back, and there a straight line of the flange."""
    q = moved[[f"actual_q_{joint}" for joint in range(6)]].to_numpy()
    np.testing.assert_allclose(q[[0, -1]], [HOME, HOME], atol=0.01)
    tool = moved[[f"actual_TCP_pose_{axis}" for axis in range(3)]].to_numpy()
    end = np.array([-0.25, -0.45, 0.6])
    there = np.linalg.norm(tool - end, axis=1)
    assert there.min() < 0.002
    way = tool[there.argmin() :] - end
    home = tool[-1] - end
    beside = way - np.outer(way @ home, home) / (home @ home)
    assert np.linalg.norm(beside, axis=1).max() < 0.002


@pytest.mark.thorough
@on_the_double_of_an_arm
def test_the_arm_stops_when_a_device_dies(study: Path) -> None:
    """One that this program moves; the others are recorded on."""
    pytest.importorskip("rtde_control")
    far = HOME + np.array([1.5, 0, 0, 0, 0, 0])
    np.savetxt("far.csv", np.array([HOME, far]), delimiter=",")
    arm = ControllerDouble("ur5e", plan=at(HOME))
    with arm, NetFTDouble(lambda _: np.zeros(6), faults=TransmissionFaults(dies_at=6.0)) as box:
        devices = {"robot": {"address": HOST}}
        devices["force_sensor"] = {"address": HOST, "port": box.port, "http_port": box.http_port}
        study.write_text(yaml.safe_dump(yaml.safe_load(STUDY) | {"devices": devices}))
        screen = console()
        record(
            study,
            RecordOptions("far", "contact", move=Path("far.csv"), speed=0.1, yes=True),
            screen,
        )
        at_the_end = arm.truth.part("qd", arm.truth.latest())
    moved = pd.read_csv("raw/lab/far/robot.csv")["actual_q_0"].to_numpy()
    assert HOME[0] + 0.05 < moved[-1] < far[0] - 0.1
    assert np.abs(at_the_end).max() < 0.01
    assert "force_sensor has ended: the Net F/T box" in said(screen)


# What is refused


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"devices": None}, "devices"),
        ({"devices": "-"}, r"lab\.yaml .*`devices`.*\{robot"),
        ({"devices": {"robot": {}}}, "`robot.address` is missing"),
        ({"devices": {"robot": {"adress": "a"}}}, "did you mean `address`"),
        ({"robot": "ur4"}, "names no described arm"),
    ],
)
def test_a_study_that_lacks_something_is_refused(
    study: Path, change: dict[str, Any], sentence: str
) -> None:
    plain = yaml.safe_load(STUDY) | change
    study.write_text(yaml.safe_dump({k: value for k, value in plain.items() if value != "-"}))
    with pytest.raises(InputError, match=sentence):
        record(study, RecordOptions("run", "contact", seconds=1), console())
    assert not Path("raw").exists()


def test_a_name_that_is_no_new_folder_is_refused(study: Path) -> None:
    with pytest.raises(InputError, match="cannot name a recording"):
        record(study, RecordOptions("../run", "contact"), console())
    Path("raw/lab/run").mkdir(parents=True)
    Path("raw/lab/run/robot.csv").write_text("of another")
    with pytest.raises(InputError, match="raw/lab/run exists"):
        record(study, RecordOptions("run", "contact"), console())


def test_an_empty_folder_is_no_recording(tmp_path: Path) -> None:
    """A recorder that was killed at its start leaves one."""
    new_folder(tmp_path / "run")
    assert not is_taken(tmp_path / "run")
    new_folder(tmp_path / "run")
    (tmp_path / "run" / "robot.csv").write_text("of another")
    assert is_taken(tmp_path / "run")
    with pytest.raises(InputError, match="run exists; give the recording another name"):
        new_folder(tmp_path / "run")
    assert is_taken(tmp_path / "run" / "robot.csv")
    with pytest.raises(InputError, match="exists; give"):
        new_folder(tmp_path / "run" / "robot.csv")


def test_a_folder_that_another_start_makes_at_this_moment_is_refused(
    study: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    @contextmanager
    def laboratory(robot: Robot, is_pushed: bool, folder: Path) -> Iterator[LabSettings]:
        folder.mkdir(parents=True)
        (folder / "robot.csv").write_text("of the other")
        yield LabSettings(robot=ArmSettings(address=HOST))

    monkeypatch.setattr("ur5lab.record.lab_double", laboratory)
    options = RecordOptions("run", "contact", seconds=1, emulate=True, without=("imu",))
    with pytest.raises(InputError, match="raw/lab/run exists; give the recording another name"):
        record(study, options, console())
    [file] = Path("raw/lab/run").iterdir()
    assert file.read_text() == "of the other"


def test_two_recordings_enter_one_study_at_the_same_time(
    study: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both have read it at their start; the second enters while the first writes."""
    first, second = StudyFile.read(study), StudyFile.read(study)
    other = Thread(target=second._append, args=["- name: second\n"])

    def write_when_the_other_has_or_waits(text: str, path: Path) -> None:
        monkeypatch.setattr("ur5lab.recorded_study.write_text", write_text)
        other.start()
        other.join(0.5)
        write_text(text, path)

    monkeypatch.setattr("ur5lab.recorded_study.write_text", write_when_the_other_has_or_waits)
    assert first._append("- name: first\n")
    other.join()
    names = [one["name"] for one in yaml.safe_load(study.read_text())["recordings"]]
    assert names == ["first", "second"]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("1,2,3\n", "six joint angles"),
        ("0,0,0,0,0,zero\n", "six joint angles"),
        ("0,0,0,0,0,nan\n", "six joint angles"),
        ("1,0,0,0,0,0,0\n1,0,0,0,0,0,0\n", "must increase"),
    ],
)
def test_a_file_that_is_no_motion_is_refused(tmp_path: Path, text: str, sentence: str) -> None:
    (tmp_path / "motion.csv").write_text(text)
    with pytest.raises(InputError, match=sentence):
        read_motion(tmp_path / "motion.csv", 1.0)


LOW = np.array([0.5, -0.1, 0.6, -1.5, 1.5, 0.3])  # both ends of the way are above the table


@pytest.mark.parametrize(
    ("goal", "table", "reason"),
    [
        (HOME + 0.2, 0.0, ""),
        (LOW, 0.0, "hits the table"),
        (LOW, None, ""),
        (HOME * [1, 1, 0, 1, 1, 1] + [0, 0, 3.0, 0, 0, 0], None, "link_1 hits link_3"),
        (np.add(HOME, [0, 0, 0, 0, 0, 6.5]), 0.0, "joint 6 turns to 6.80 rad"),
    ],
)
def test_a_path_is_refused_for_a_reason(
    ur5e: Robot, goal: np.ndarray, table: float | None, reason: str
) -> None:
    motion = CommandedMotion(goal[None], None, 0.25)
    reasons = [*refusals(motion, ur5e, HOME, table)]
    assert any(reason in one for one in reasons) if reason else not reasons


def test_a_trajectory_may_be_slowed_until_it_is_allowed(ur5e: Robot) -> None:
    time = np.array([0.0, 0.1])
    quick = CommandedMotion(np.array([HOME, HOME + 0.5]), time, 1.0)
    assert any("lower --speed" in one for one in refusals(quick, ur5e, HOME, None))
    slow = CommandedMotion(quick.q, time, 0.5)
    assert [*refusals(slow, ur5e, HOME, None)] == []
    assert slow.duration() == pytest.approx(0.2)
    assert np.abs(np.diff(slow.at_rate(500), axis=0)).max() == pytest.approx(0.005)


def test_a_path_is_checked_without_gaps() -> None:
    ends = np.array([HOME, HOME + np.array([1, 0, 0, 0, 0, 0])])
    path = dense_path(ends)
    assert np.abs(np.diff(path, axis=0)).max() <= 0.02
    np.testing.assert_array_equal(path[[0, -1]], ends)


# What an earlier session left


def test_what_a_session_that_was_cut_off_left_is_said_first(study: Path) -> None:
    """Of the name that is asked for, too; nothing of whole ones, and of other folders."""
    for name, manifest in {
        "whole": '{"complete": true}',
        "cut": '{"complete": false}',
        "empty": '{"complete": false}',
        "other": "{",
    }.items():
        folder = Path("raw/lab", name)
        folder.mkdir(parents=True)
        (folder / "manifest.json").write_text(manifest)
    Path("raw/lab/cut/robot.csv").write_text("timestamp,host_time\n0.0,1.0\n0.1,1.1\n0.2,1")
    screen = console()
    with pytest.raises(InputError, match=r"raw/lab/cut exists; give the recording another name"):
        record(study, RecordOptions("cut", "fit"), screen)
    left = "was left by a session that was cut off; "
    cut, empty = said(screen).splitlines()
    assert cut == f"raw/lab/cut {left}robot.csv has 2 samples"
    assert empty == f"raw/lab/empty {left}it has no files"


# Warnings

SOUND = {"status": 0.0, "safety_mode": 1.0}


@pytest.mark.parametrize(
    ("status", "sentence"),
    [
        (Status(samples=1000, lost=2), "loses samples"),
        (Status(samples=1000, lost=1, seconds=10.0, latest=SOUND), ""),
        (Status(samples=100, seconds=3.0), " 100 "),
        (Status(ended="the box has gone"), "has ended: the box has gone"),
        (Status(latest={"status": float(1 << 17)}), "is saturated"),
        (Status(latest={"safety_mode": 3.0}), "safety stop"),
    ],
)
def test_a_device_s_trouble_is_warned_of(status: Status, sentence: str) -> None:
    identity = Identity(model="made up", address="here", units="SI", rate_hz=100.0)
    warnings = [*display.warnings({"device": status}, {"device": identity})]
    assert len(warnings) == bool(sentence)
    assert all(sentence in warning for warning in warnings)
