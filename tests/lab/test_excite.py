"""`ur5 excite`: its files, what reads them, and what it says of wrong options."""

import socket
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

from ur5lab import excite
from ur5lab.doubles.controller_double import ControllerDouble, Ports
from ur5lab.doubles.device_double import HOST
from ur5lab.excitation import design as search
from ur5lab.excitation.trajectory import Path as Motion
from ur5lab.recorder.arm_state import read_state
from ur5lab.recorder.commanded_motion import read_motion, refusals
from ur5lib.cli import app
from ur5lib.errors import InputError
from ur5lib.recordings.entries import RtdeFiles
from ur5lib.recordings.robot_files import read_rtde_csv
from ur5lib.robots.description import Robot
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.simulate import simulate
from ur5lib.stand.trajectories import INITIAL_REST
from ur5lib.study.reading import read_study
from ur5lib.tables import channel, read_json

SECONDS = 6.0


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What the command writes after a short search."""
    written = tmp_path_factory.mktemp("excite")
    with pytest.MonkeyPatch.context() as patch:
        quick = search.Effort(1, 0, ((1e3, 10),))
        patch.setattr(
            excite, "design", lambda task, seed, _, told: search.design(task, seed, quick, told)
        )
        words = ["excite", "--robot", "ur5e", "--seconds", str(SECONDS)]
        done = CliRunner().invoke(app, [*words, "--output", str(written)])
    assert done.exit_code == 0, done.output
    assert "smallest singular value" in done.output
    assert "log det" in done.output
    return written


def designed(folder: Path) -> Motion:
    path = read_json(folder / "excitation.json")["path"]
    return Motion(np.array(path["posture"]), np.array(path["coefficients"]), path["seconds"])


def test_the_recorder_reads_and_accepts_both_motions(folder: Path, ur5e: Robot) -> None:
    """Above a table at the height of the base, too."""
    trajectory = read_motion(folder / "trajectory.csv", 1.0)
    assert trajectory.duration() == pytest.approx(SECONDS)
    np.testing.assert_allclose(trajectory.q, designed(folder).sampled(125)[1].q, atol=1e-6)
    way_points = read_motion(folder / "way_points.csv", 1.0)
    assert way_points.time is None
    for motion in (trajectory, way_points):
        assert list(refusals(motion, ur5e, motion.q[0], 0.0)) == []


def test_the_program_streams_every_state(folder: Path) -> None:
    lines = (folder / "trajectory.script").read_text().splitlines()
    assert lines[0] == "def excite():"
    assert lines[-2:] == ["  stopj(2.0)", "end"]
    assert len([line for line in lines if line.startswith("  servoj([")]) == 1 + SECONDS * 125


@pytest.mark.slow
@pytest.mark.real_time
def test_the_double_of_a_controller_executes_the_program(folder: Path, ur5e: Robot) -> None:
    """Received by its port for programs; servoj lags by 0.1 s, and smooths a little."""
    with ControllerDouble(ur5e, ports=Ports.free()) as arm:
        ports = arm.setup.ports
        with socket.create_connection((HOST, ports.secondary)) as line:
            line.sendall((folder / "trajectory.script").read_bytes())
            wait_for(lambda: read_state(HOST, ports.rtde).program_runs)
            wait_for(lambda: not read_state(HOST, ports.rtde).program_runs)
        end = arm.truth.latest()
        assert read_state(HOST, ports.rtde).safety_mode == "normal"
        since = np.arange(0, SECONDS, 0.05)
        wanted = designed(folder).at(since).q
        begins = np.arange(end - SECONDS - 3, end - SECONDS, 0.01)
        moved = arm.truth.part("q", begins[:, None] + since)
    off = np.abs(moved - wanted).max(axis=(1, 2)).min()
    assert off < 0.1
    assert 10 * off < np.ptp(wanted, axis=0).max()


def wait_for(condition: Callable[[], bool]) -> None:
    until = time.monotonic() + 60.0
    while not condition():
        assert time.monotonic() < until, "it never came"
        time.sleep(0.25)


def test_the_summary_tells_each_parameter(folder: Path) -> None:
    rows = read_json(folder / "excitation.json")["parameters"]
    assert len(rows) == 40 + 30
    assert all(row["std_error_after"] <= row["std_error_before"] for row in rows)
    assert {row["unit"] for row in rows} >= {"kg m", "kg m²", "Nm/A", "Nm", "Nm s/rad"}
    assert all(row["std_error_before"] == row["std_error_prior"] for row in rows)


def test_the_arm_of_the_stand_follows_it(folder: Path, ur5e: Robot, tmp_path: Path) -> None:
    (recording,) = read_study(folder / "stand.yaml").recordings
    plan = recording.simulate
    assert isinstance(plan, SimulatedRecording)
    simulate(ur5e, plan, "rtde-csv", tmp_path, tmp_path / "truth")
    (file,) = tmp_path.glob("*.csv")
    entry = RtdeFiles(format="rtde-csv", folder=str(tmp_path), file=file.name)
    frames = read_rtde_csv(entry).robot.table
    time = frames["time"].to_numpy() - frames["time"].iloc[0] - INITIAL_REST
    moving = (time > 0) & (time < SECONDS)
    states = designed(folder).at(time[moving])
    np.testing.assert_allclose(channel(frames, "actual_q")[moving], states.q, atol=0.02)
    most = [ur5e.motor(joint).torque_max for joint in range(1, 7)]
    assert (np.abs(channel(frames, "target_moment")) < most).all()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--robot", "ur6"], "no description of `ur6`"),
        (["--question", "tea"], "unknown question 'tea'; available: model, undetermined"),
        (["--payload", "0", "0", "0", "0"], "--payload 0 0 0 0: give a mass above zero"),
        (["--table", "nan"], "--table nan: give its height"),
        (["--boxes", "none.yaml"], "--boxes none.yaml cannot be read"),
        (["--boxes", "wrong.yaml"], "wrong.yaml: boxes.0.size"),
        (["--results", "results/none"], "results/none"),
        (["--output", "wrong.yaml"], "--output wrong.yaml is a file"),
    ],
)
def test_wrong_options_are_told_and_nothing_is_written(
    words: list[str], message: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("wrong.yaml").write_text("[{center: [0, 0, 0], size: [1, 0, 1]}]")
    given = ["excite", "--robot", "ur5e", "--output", "out", *words]
    done = CliRunner().invoke(app, given)
    assert isinstance(done.exception, InputError)
    assert message in str(done.exception)
    assert not Path("out").exists()
