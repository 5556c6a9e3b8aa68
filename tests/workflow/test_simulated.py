"""Simulated recordings in the workflow: made first, made alike, their truth kept apart."""

import re
import shutil
from collections import Counter
from pathlib import Path

import pytest
import yaml

from tests.conftest import Workflow, copy_project
from ur5lib.jobs.code import all_steps

STUDY = """\
study: made
title: Two simulated recordings
recordings:
  - name: moved
    robot: ur5
    format: thesis-csv
    role: fit
    simulate:
      trajectory: {kind: movej, way_points: points.txt}
      seconds: 3
      imu: {}
  - name: held.1
    robot: ur5
    format: rtde-csv
    role: contact
    simulate:
      trajectory: {kind: standstill}
      seconds: 2
      seed: 1
      force_sensor: {}
      contacts:
        - {kind: push, start_s: 0.5, seconds: 1, force: [20, 0, 0]}
"""
POINTS = "movej([0.5, -1.6, 1.6, -1.5, 1.5, 0.3])\nmovej([0.2, -1.4, 1.5, -1.2, 1.2, 0.1])\n"
DESCRIBED = {"describe_arm": 1}
MOVED, HELD = {"simulate_recording_moved": 1}, {"simulate_recording_held.1": 1}
BOTH = MOVED | HELD | {"read_recording": 2}
COMPARISON = {*all_steps()} & {"compare_with_truth"}  # none where its topic is deleted
READ = ("--until", "read_recording")  # as far as these tests build


@pytest.fixture(scope="module")
def read_workflow(tmp_path_factory: pytest.TempPathFactory) -> Workflow:
    """Two recordings, simulated and read."""
    folder = copy_project(tmp_path_factory.mktemp("made") / "project")
    (folder / "config.yaml").write_text(STUDY)
    (folder / "points.txt").write_text(POINTS)
    workflow = Workflow(folder)
    workflow.build(*READ)
    return workflow


@pytest.fixture
def made(read_workflow: Workflow, tmp_path: Path) -> Workflow:
    """The same, in a copy of its own."""
    return read_workflow.copied(tmp_path / "project")


def edit(path: Path, old: str, new: str) -> None:
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new))


def simulated_files(workflow: Workflow) -> dict[str, bytes]:
    folders = workflow.folder / "raw" / "made", workflow.folder / "results" / "made" / "truth"
    files = [path for folder in folders for path in folder.rglob("*") if path.is_file()]
    return {str(path.relative_to(workflow.folder)): path.read_bytes() for path in files}


def test_deleted_files_are_made_again_to_the_byte(made: Workflow) -> None:
    before = simulated_files(made)
    (made.folder / "raw/made/moved/csv_files/log_i_actual.csv").unlink()
    assert made.plan(*READ) == MOVED | {"read_recording": 1}
    (made.folder / "raw/made/held.1/force_sensor.csv").unlink()
    made.build(*READ)
    assert simulated_files(made) == before


@pytest.mark.parametrize(
    ("file", "old", "new", "expected"),
    [
        ("config.yaml", "seed: 1", "seed: 2", HELD | {"read_recording": 1}),
        ("config.yaml", "role: contact", "role: validate\n    payload: {mass: 1}", {}),
        (
            "config.yaml",
            "role: contact",
            "role: contact\n    gravity: [0, 0, 9.81]",
            HELD | {"read_recording": 1},
        ),
        ("points.txt", "0.5", "0.6", MOVED | {"read_recording": 1}),
        ("ur5lib/stand/friction.py", "0.054", "0.055", BOTH),
        ("ur5lib/robots/ur5.yaml", "1.61", "1.62", DESCRIBED | BOTH),
    ],
)
def test_an_edit_simulates_again_what_it_concerns(
    made: Workflow, file: str, old: str, new: str, expected: dict[str, int]
) -> None:
    edit(made.folder / file, old, new)
    assert made.plan(*READ) == expected


def test_no_step_but_the_comparison_is_given_the_truth(made: Workflow) -> None:
    """Of all jobs of a run, by their inputs; every recording's truth is written where they look."""
    done = made.run("--dry-run", "--forceall", "--quiet", "host")
    jobs = re.findall(r"\nrule (\S+):\n    input: (.*)\n", done.stdout)
    plan = Counter(job for job, _ in jobs)
    assert plan.items() >= BOTH.items()
    assert {"estimate_forces", "write_report"} <= {*plan}
    given = {job for job, files in jobs if "made/truth/" in files}
    assert given - {"all"} == COMPARISON  # `all` wants it made, and runs nothing
    assert {name for name in simulated_files(made) if "truth" in name} == {
        f"results/made/truth/{name}.{suffix}"
        for name in ("moved", "held.1")
        for suffix in ("parquet", "json")
    }


def test_the_truth_of_the_emulated_lab_is_for_the_comparison_alone(made: Workflow) -> None:
    """Whose recordings are files like real ones; their entry says where their truth lies."""
    raw, truth = made.folder / "raw/made/held.1", made.folder / "results/made/truth"
    for suffix in (".parquet", ".json"):
        shutil.copy(truth / f"held.1{suffix}", raw / f"truth{suffix}")
    study = yaml.safe_load(STUDY)
    held = study["recordings"][1]
    del held["simulate"]
    held |= {"folder": "raw/made/held.1", "file": "robot.csv", "truth": "truth"}
    (made.folder / "config.yaml").write_text(yaml.safe_dump(study))
    done = made.run("--dry-run", "--forceall", "--quiet", "host")
    jobs = re.findall(r"\nrule (\S+):\n    input: (.*)\n", done.stdout)
    given = [job for job, files in jobs if "raw/made/held.1/truth" in files]
    assert {*given} == COMPARISON


def test_what_an_arm_cannot_do_is_told(made: Workflow) -> None:
    edit(made.folder / "points.txt", "0.5", "50")
    done = made.run(*READ)
    assert done.returncode == 1
    assert "simulate_recording: the trajectory takes joint 1 of ur5 to" in done.stdout
    assert "Traceback" not in done.stdout


def test_a_missing_file_of_way_points_is_told(made: Workflow) -> None:
    (made.folder / "points.txt").unlink()
    done = made.run("--dry-run")
    assert done.returncode == 1
    assert "simulate.trajectory.way_points` is 'points.txt'; give an existing file" in done.stdout
