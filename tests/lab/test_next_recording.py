"""What to record next: designed beside what was recorded, it tells what that left undetermined."""

import re
from collections import defaultdict
from pathlib import Path

import numpy as np
import pytest

from benchmarks.excitation_loop import QUICK
from tests.conftest import PROJECT, Workflow, copy_project
from tests.house.test_benchmarks import run_benchmark
from ur5lab.excitation.design import design
from ur5lab.excite import ExciteOptions, earlier, known_load, task_of
from ur5lib.tables import read_csv

ERRORS = re.compile(r"^ *load friction of joint \d +(\S+) -> (\S+) +(\S+) -> (\S+)", re.MULTILINE)


@pytest.mark.thorough
@pytest.mark.slow
def test_designed_motions_are_measured() -> None:
    printed = run_benchmark("excitation", PROJECT)
    texts = ["ur5e", "log det", "best of 3 random", "lower in torque"]
    assert all(text in printed for text in texts), printed


@pytest.mark.thorough
@pytest.mark.slow
def test_the_second_recording_tells_what_it_was_designed_for(tmp_path: Path) -> None:
    """On the virtual stand, load friction: at least as much as predicted, and of the worst half."""
    workflow = Workflow(copy_project(tmp_path / "project"))
    printed = run_benchmark("excitation_loop", workflow.folder)
    rows = ERRORS.findall(printed.partition("recording 2:")[2])
    before, after, stated_before, stated_after = np.array(rows, float).T
    assert len(rows) >= 3, printed
    assert (after < before).all(), printed
    assert (stated_after <= after).all(), printed
    assert stated_after[0] <= stated_before[0] / 2, printed


def test_a_load_would_tell_what_five_paths_of_a_real_arm_did_not(
    thesis_results: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of the thesis's UR5, without moving it, by the report's command: above the base."""
    monkeypatch.chdir(thesis_results.parents[1])
    load = known_load(2.0, 0.06, 0.0, 0.05)
    options = ExciteOptions("ur5", 10.0, "undetermined", thesis_results, 0.0, None, 0, load)
    task = task_of(options, *earlier(options))
    found = design(task, 0, QUICK)
    assert found.margins.broken() == []
    alone, before, after = (
        dict(zip(task.problem.names(), task.problem.standard_errors(known), strict=True))
        for known in (task.problem.prior, task.earlier, task.information(found.path))
    )
    stated = read_csv(thesis_results / "tables" / "friction.csv")
    open_ones = stated[stated["determined"] == "no"]
    assert {*open_ones["parameter"]} == {"torque_constant", "load"}
    names = {"torque_constant": "torque constant", "load": "load friction"}
    shares = defaultdict(list)
    for row in open_ones.itertuples():
        name = f"{names[row.parameter]} of joint {row.joint}"
        assert 0.7 < before[name] / row.std_error < 1.4
        assert after[name] < before[name]
        shares[row.parameter].append(after[name] / alone[name])
    assert max(shares["torque_constant"]) < 0.5  # of what the maker tells
    ratio = np.array([after[name] / before[name] for name in before])
    assert (ratio < 1 + 1e-9).all()
