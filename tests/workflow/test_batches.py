"""A study of many recordings, whose steps run in batches: the same results, and as few runs."""

from pathlib import Path

import pytest

from tests.conftest import Workflow
from tests.workflow.test_workflow import append, killed_runs_go_on, results, run_in_batches_above


def steps_run(folder: Path) -> list[str]:
    """The steps that the last run of each batch repeated, as its log lists them."""
    logs = sorted(folder.glob("logs/process_batch_*/*.log"))
    return sorted(line for log in logs for line in log.read_text().splitlines())


@pytest.fixture(scope="module")
def in_batches(built_workflow: Workflow, tmp_path_factory: pytest.TempPathFactory) -> Workflow:
    """The small study, built step by step and then again in batches, to the same results."""
    workflow = built_workflow.copied(tmp_path_factory.mktemp("batches") / "project")
    before = results(workflow)
    run_in_batches_above(1, workflow)
    planned = workflow.plan()
    assert {f"process_batch_{level}" for level in range(6)} <= planned.keys()
    assert "repair_frames" not in planned
    workflow.build()
    after = results(workflow)
    assert {name: after[name] for name in before} == before
    assert workflow.plan() == {}
    return workflow


@pytest.mark.thorough
@pytest.mark.slow
def test_killed_batches_go_on_to_the_same_results(in_batches: Workflow, tmp_path: Path) -> None:
    killed_runs_go_on(in_batches.copied(tmp_path / "project"), seed=1)


def test_batches_repeat_what_changed(in_batches: Workflow, tmp_path: Path) -> None:
    """All at once, as each run takes its time; a batch repeats steps, not recordings."""
    workflow = in_batches.copied(tmp_path / "project")
    folder = workflow.folder / "results" / "small"
    assert {"repair_frames still", "detect_contacts pushed"} <= {*steps_run(folder)}
    before = results(workflow)
    append(workflow.folder / "ur5lib" / "identification" / "closed_loop.py", "\n# edited\n")
    (folder / "recordings" / "pushed" / "torques.parquet").unlink()
    workflow.build()
    assert steps_run(folder) == [
        "compute_torques pushed",
        "estimate_gains pushed",
        "estimate_gains still",
        "tabulate_recording pushed",
        "tabulate_recording still",
    ]
    after = results(workflow)
    assert {name: after[name] for name in before} == before
    assert workflow.plan() == {}
