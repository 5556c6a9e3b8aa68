"""A workflow told of what would hang it or fill it ends at once, and says why."""

import os
from pathlib import Path

import pytest

from tests.conftest import Workflow, copy_project
from tests.corpus import rtde
from tests.library.test_hostile import BOMBS, ENTRY, SENSOR
from tests.time_limit import time_limit

SECONDS = 60


@pytest.fixture(scope="module")
def workflow(tmp_path_factory: pytest.TempPathFactory) -> Workflow:
    workflow = Workflow(copy_project(tmp_path_factory.mktemp("hostile") / "project"))
    rtde(workflow.folder, "rtde", b",")
    return workflow


def write_study(workflow: Workflow, rest: str) -> None:
    (workflow.folder / "mine.yaml").write_text(f"study: mine\ntitle: Mine\n{rest}")


def told(workflow: Workflow, *arguments: str) -> str:
    """What Snakemake prints where it must fail."""
    with time_limit(SECONDS):
        done = workflow.run(*arguments, "--configfile", "mine.yaml")
    assert done.returncode != 0
    assert "Traceback" not in done.stdout
    return done.stdout


# Snakemake itself writes out mappings of mappings before it reads any rule.
@pytest.mark.parametrize("kind", ["lists", "a circle"])
def test_a_study_that_expands_beyond_measure(workflow: Workflow, kind: str) -> None:
    write_study(workflow, BOMBS[kind])
    assert "/mine.yaml " in told(workflow, "--dry-run")


@pytest.mark.parametrize("name", ["robot.csv", "force.csv"])
def test_a_pipe_in_place_of_a_file(workflow: Workflow, name: str) -> None:
    folder = workflow.folder / "rtde"
    (folder / "start.txt").write_text("0\n")
    write_study(workflow, f"recordings:\n{ENTRY}{SENSOR}")
    content = (folder / name).read_bytes()
    (folder / name).unlink()
    os.mkfifo(folder / name)
    target = "results/mine/recordings/run/robot.parquet"
    sentence = f"{Path('rtde', name)} is a named pipe, "
    try:
        if name == "robot.csv":
            assert sentence in told(workflow, target)
        else:  # a sensor's damage does not take the robot's data with it
            with time_limit(SECONDS):
                workflow.build("--configfile", "mine.yaml", "--", target)
            assert sentence in (workflow.folder / target).with_name("quality.json").read_text()
    finally:
        (folder / name).unlink()
        (folder / name).write_bytes(content)
