"""Logs as labs write them, through `ur5 import` and `ur5 check`: entries of what was recorded."""

from collections.abc import Callable
from pathlib import Path
from threading import Thread
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.command import Command
from tests.identification.test_postures import drawn
from tests.robots.test_from_urdf import made_up, saved
from tests.synthetic import poor_log
from ur5lib.commands.described import describe_urdf
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import (
    ImportedFiles,
    add_to_study,
    as_entries,
    import_files,
    write_study,
)
from ur5lib.recordings import formats
from ur5lib.recordings.counting import counted_as
from ur5lib.recordings.intake import known_frames
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.stand.controller_channels import frames
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import perform
from ur5lib.study.model import Study
from ur5lib.study.reading import parse_study, read_study
from ur5lib.tables import channel

SHORT = {"actual_q": "Act_q{k}", "actual_qd": "Act_qd{k}", "actual_current": "Act_I{k}"}
Write = Callable[[pd.DataFrame], list[str]]  # a log, as a file; returns the words of the command


def renamed(log: pd.DataFrame, names: dict[str, str]) -> pd.DataFrame:
    pairs = {f"{old}_{k}": new.format(k=k, n=k + 1) for old, new in names.items() for k in range(7)}
    return log.rename(columns=pairs)


def rtde_names(log: pd.DataFrame) -> list[str]:
    """With a wrench that was zeroed nowhere, held at 6 Hz."""
    force = np.repeat(np.random.default_rng(0).normal(3, 0.1, (len(log), 3))[::21], 21, axis=0)
    log[["wrench_fx", "wrench_fy", "wrench_fz"]] = force[: len(log)]
    log.to_csv("run.csv", index=False)
    return ["run.csv"]


def two_clocks(log: pd.DataFrame) -> list[str]:
    """Polled faster than the controller writes, and stamped by the receiver."""
    random = np.random.default_rng(1)
    rows = log.iloc[np.sort(random.integers(0, len(log), 2 * len(log)))]
    rows = renamed(rows, SHORT).rename(columns={"time": "Time"})
    rows.insert(0, "epoch_time", 1.7e9 + np.cumsum(random.exponential(0.004, len(rows))))
    rows.to_csv("run.csv", index=False)
    return ["run.csv"]


def without_clock(log: pd.DataFrame) -> list[str]:
    log.drop(columns="time").to_csv("run.txt", sep=" ", index=False)
    return ["run.txt", "--rate", "125"]


def without_clock_and_names(log: pd.DataFrame) -> list[str]:
    log.drop(columns="time").to_csv("run.csv", index=False, header=False)
    return ["run.csv", "--rate", "125"]


def hdf5(log: pd.DataFrame) -> list[str]:
    import h5py

    with h5py.File("run.h5", "w") as file:
        file["robot/timestamp"] = log["time"].to_numpy()
        for name in SHORT:
            file[f"robot/{name}"] = channel(log, name)
    return ["run.h5"]


def numbered(log: pd.DataFrame) -> list[str]:
    names = {
        "actual_q": "J{n} Position",
        "actual_qd": "J{n} Speed",
        "actual_current": "J{n} Current",
    }
    renamed(log, names).to_csv("run.csv", sep=";", index=False)
    return ["run.csv"]


FORMS = {
    "ur16e": rtde_names,
    "ur3": two_clocks,
    "ur5": without_clock,
    "ur10": without_clock_and_names,
    "ur5e": hdf5,
    "ur10e": numbered,
}


def test_a_study_that_exists_is_kept_before_recordings_are_read(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("mine.yaml").write_text("mine")
    refused = run_ur5("import", "nowhere.csv", "--output", "mine.yaml")
    assert refused.status == 1
    assert "mine.yaml exists" in refused.line
    assert Path("mine.yaml").read_text() == "mine"


def two_logs(folder: Path) -> list[Path]:
    paths = [folder / "one.csv", folder / "two.csv"]
    for path in paths:
        poor_log(load_robot(robot_path("ur5")), 20, 1).to_csv(path, index=False)
    return paths


def test_a_study_that_another_import_writes_at_this_moment_is_kept(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    monkeypatch.chdir(tmp_path)
    one, two = two_logs(tmp_path)
    other = import_files([two], UserStatement("ur5"))

    def written_meanwhile(imported: ImportedFiles) -> str:
        monkeypatch.setattr("ur5lib.importing.files.as_entries", as_entries)
        write_study(other, Path("mine.yaml"))
        return as_entries(imported)

    monkeypatch.setattr("ur5lib.importing.files.as_entries", written_meanwhile)
    refused = run_ur5("import", one, "--robot", "ur5", "--output", "mine.yaml")
    assert (refused.status, "mine.yaml exists; name another" in refused.line) == (1, True)
    assert [entry.name for entry in read_study(Path("mine.yaml")).recordings] == ["two"]


def test_two_imports_add_to_one_study_at_the_same_time(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The second while the first has read it, and not yet written."""
    study, (one, two) = tmp_path / "mine.yaml", two_logs(tmp_path)
    study.write_text("study: mine\ntitle: Mine\nrecordings:\n")
    first, second = (import_files([path], UserStatement("ur5")) for path in (one, two))
    other = Thread(target=add_to_study, args=[second, study])

    def parsed_when_the_other_has_written_or_waits(*given: Any) -> Study:
        monkeypatch.setattr("ur5lib.importing.files.parse_study", parse_study)
        other.start()
        other.join(0.5)
        return parse_study(*given)

    monkeypatch.setattr(
        "ur5lib.importing.files.parse_study", parsed_when_the_other_has_written_or_waits
    )
    add_to_study(first, study)
    other.join()
    assert [entry.name for entry in read_study(study).recordings] == ["one", "two"]


def test_recordings_given_as_a_study_are_answered_by_import(
    tmp_path: Path, run_ur5: Command
) -> None:
    (tmp_path / "run.csv").write_text("timestamp,actual_q_0\n0.0,1.5\n")
    assert "ur5 import" in run_ur5("check", str(tmp_path / "run.csv")).line


def imported(words: list[str], arm: str, run_ur5: Command) -> tuple[pd.DataFrame, str]:
    """The table that `ur5 check` accepts, and what import wrote into its study."""
    assert run_ur5("import", *words, "--robot", arm, "--output", "mine.yaml").status == 0
    checked = run_ur5("check", "mine.yaml")
    assert checked.status == 0, checked.line
    (recording,) = read_study(Path("mine.yaml")).recordings
    return formats.read_recording(recording).robot.table, Path("mine.yaml").read_text()


@pytest.mark.parametrize("arm", FORMS)
def test_logs_of_urs(
    arm: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    monkeypatch.chdir(tmp_path)
    log = poor_log(load_robot(robot_path(arm)), 30, seed=3)
    table, written = imported(FORMS[arm](log.copy()), arm, run_ur5)
    assert "confidence: check" not in written
    read, sent = (np.hstack([channel(own, name) for name in SHORT]) for own in (table, log))
    assert np.abs(sent - read[-1]).max(axis=1).min() < 1e-5


@pytest.fixture
def seven(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> pd.DataFrame:
    """The log of an arm of seven joints that senses its torques, and its description."""
    monkeypatch.chdir(tmp_path)
    describe_urdf(saved(made_up(7), tmp_path), None, None, "mine")
    moving = {"kind": "fourier", "posture": [0.3, -0.4, 0.5, -0.3, 0.4, 0.2, -0.5]}
    plan = SimulatedRecording.model_validate({"trajectory": moving, "seconds": 20.0})
    arm, random = load_robot("robots/mine.yaml"), np.random.default_rng(0)
    return frames(perform(arm, plan, random), 0.002, random)


def test_joints_named_by_sides(seven: pd.DataFrame, run_ur5: Command) -> None:
    names = {"actual_q": "ang_left_{}", "actual_qd": "vel_left_{}", "actual_torque": "torq_left_{}"}
    sides = ("s0", "s1", "e0", "e1", "w0", "w1", "w2")
    columns = {
        new.format(side): seven[f"{old}_{k}"]
        for old, new in names.items()
        for k, side in enumerate(sides)
    }
    pd.DataFrame({"t": seven["time"]} | columns).to_csv("run.csv", index=False)
    table, written = imported(["run.csv"], "mine", run_ur5)
    assert "confidence: check" not in written
    for name in names:
        assert channel(table, name, 7) == pytest.approx(channel(seven, name, 7), abs=1e-5)


def test_positions_from_a_home_posture(seven: pd.DataFrame, run_ur5: Command) -> None:
    """As of a KUKA: the entry takes the home posture, and `ur5 check` accepts it."""
    home = np.array([10.0, -90.0, 45.0, 0.0, 30.0, 0.0, 5.0])
    names = {"actual_q": "q_{}", "actual_qd": "qd_{}", "actual_torque": "motor_torque_{}"}
    columns = {
        new.format(k): seven[f"{old}_{k}"] - np.radians(home[k]) * (old == "actual_q")
        for old, new in names.items()
        for k in range(7)
    }
    pd.DataFrame({"t": seven["time"]} | columns).to_csv("run.csv", index=False)
    run_ur5("import", "run.csv", "--robot", "mine", "--output", "mine.yaml")
    written = Path("mine.yaml").read_text()
    Path("mine.yaml").write_text(f"{written}  home_deg: {home.tolist()}\n")
    checked = run_ur5("check", "mine.yaml")
    assert checked.status == 0, written + checked.line
    (recording,) = read_study(Path("mine.yaml")).recordings
    arm = counted_as(recording, load_robot("robots/mine.yaml"))
    table, _ = known_frames(formats.read_recording(recording), arm)
    assert channel(table, "actual_q", 7) == pytest.approx(channel(seven, "actual_q", 7), abs=1e-5)


def test_postures_at_rest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    monkeypatch.chdir(tmp_path)
    arm = load_robot(robot_path("ur5"))
    q, current, _ = drawn(arm, np.array(arm.maker_torque_constants()))
    names = [f"{name}_{k}" for name in ("actual_q", "actual_current") for k in range(6)]
    pd.DataFrame(np.hstack([q, current]), columns=names).to_csv("run.csv", index=False)
    table, written = imported(["run.csv"], "ur5", run_ur5)
    assert "still: true" in written
    assert channel(table, "actual_current") == pytest.approx(current, abs=1e-5)
