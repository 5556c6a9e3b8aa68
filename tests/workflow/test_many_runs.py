"""Runs taken by a pattern: those that cannot be read are named and left out, the others go on."""

from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Workflow, copy_project
from tests.synthetic import write_recording
from tests.workflow.test_workflow import results
from ur5lib.channels import THESIS_FILES
from ur5lib.study.reading import parse_study
from ur5lib.study.selection import (
    MAX_DRAWN,
    MAX_EXAMINED_WHOLE,
    MAX_ILLUSTRATED,
    Selection,
)
from ur5lib.tables import read_csv

RUNS = 3
DAMAGED = {"2026-01-01": "This is a letter, not a recording.\n", "2026-03-13": ""}
STUDY = """\
study: small
title: Runs of one arm
recordings:
  - {name: run, robot: ur5, format: rtde-csv, folder: logs, file: "*/*.csv", role: validate}
"""
FILES = ["q_actual", "q_target", "qd_actual", "qd_target", "qdd_target"]
FILES += ["i_actual", "i_target", "m_target"]


def write_runs(folder: Path) -> None:
    """A run of 2 s of each of some days, in a folder of each month; their currents differ."""
    frames = write_recording(folder / "raw", seconds=2, seed=3)
    tables = [np.loadtxt(frames / f"log_{name}.csv", delimiter=",") for name in FILES]
    names = ["timestamp", *(f"{THESIS_FILES[name]}_{k}" for name in FILES for k in range(6))]
    whole = np.column_stack([tables[0][:, 0], *(table[:, 1:] for table in tables)])
    noisy = names.index("actual_current_1")
    for k in range(RUNS):
        run = whole.copy()
        run[:, noisy] += 0.1 * np.random.default_rng(k).normal(size=len(run))
        day = f"2026-{1 + k % 4:02d}-{1 + k:02d}"
        file = folder / "logs" / day[:7] / f"{day}.csv"
        file.parent.mkdir(parents=True, exist_ok=True)
        np.savetxt(file, run, fmt="%.6f", header=" ".join(names), comments="")


@pytest.mark.slow
def test_damaged_files_change_no_result_of_the_others(tmp_path: Path) -> None:
    workflow = Workflow(copy_project(tmp_path / "project"))
    (workflow.folder / "config.yaml").write_text(STUDY)
    write_runs(workflow.folder)
    workflow.build()
    before = results(workflow)
    tables = workflow.folder / "results" / "small" / "tables"

    name = "run_2026-03-2026-03-03"  # the report draws the first four
    pages = workflow.folder / "results" / "small" / "runs"
    assert not pages.exists()
    assert workflow.run("--cores", "1", f"results/small/runs/{name}.html").returncode == 0
    assert [f"{name}," in page.read_text() for page in pages.iterdir()] == [True]

    for day, text in DAMAGED.items():
        (workflow.folder / "logs" / day[:7] / f"{day}.extra.csv").write_text(text)
    done = workflow.run("--cores", "1")
    assert done.returncode == 0, done.stdout
    absent = {f"run_{day[:7]}-{day}.extra": f"{day}.extra.csv" for day in DAMAGED}
    [*_, end] = done.stdout.split(
        f"{len(absent)} of {RUNS + len(absent)} recordings cannot be read:"
    )
    assert all(f"  {name}: logs/" in end and file in end for name, file in absent.items())
    rows = read_csv(tables / "quality.csv").query("recording in @absent")
    assert [*rows["recording"]] == [*absent]
    assert {*rows["severity"]} == {"stop"}
    after = results(workflow)
    kept = [name for name in before if name.startswith(("recordings", "parameters"))]
    assert [name for name in kept if after[name] != before[name]] == []
    assert workflow.plan() == {}


def test_of_many_runs_those_that_are_drawn_are_examined(tmp_path: Path) -> None:
    """Another run seldom changes which; no result of the others depends on it."""
    before, after = (examined(tmp_path, count) for count in (300, 301))
    assert MAX_DRAWN <= len(before) <= MAX_DRAWN + 2 * MAX_ILLUSTRATED
    assert len(before ^ after) <= 2
    assert len(examined(tmp_path, MAX_EXAMINED_WHOLE)) == MAX_EXAMINED_WHOLE


def examined(folder: Path, count: int) -> frozenset[str]:
    """The runs of a study of so many that are examined."""
    entry = {"robot": "ur5", "format": "rtde-csv", "folder": str(folder), "role": "validate"}
    names = [f"run_{k}" for k in range(count)]
    for name in names:
        (folder / f"{name}.csv").touch()
    entries = [entry | {"name": name, "file": f"{name}.csv"} for name in names]
    study = parse_study({"study": "many", "title": "Many", "recordings": entries}, "")
    return Selection(study).examined
