"""A study of many recordings, whose steps run in batches: the same results, and as few runs."""

from pathlib import Path

from tests.conftest import Workflow
from tests.workflow.test_workflow import append, results, run_in_batches_above


def steps_run(folder: Path) -> list[str]:
    """The steps that the last run of each batch repeated, as its log lists them."""
    logs = sorted(folder.glob("logs/process_batch_*/*.log"))
    return sorted(line for log in logs for line in log.read_text().splitlines())


def test_batches_give_the_same_results_and_repeat_what_changed(workflow: Workflow) -> None:
    """All at once, as each run takes its time; a batch repeats steps, not recordings."""
    folder = workflow.folder / "results" / "small"
    before = results(workflow)
    run_in_batches_above(1, workflow)
    planned = workflow.plan()
    assert {f"process_batch_{level}" for level in range(6)} <= planned.keys()
    assert "repair_frames" not in planned
    workflow.build()
    assert {"repair_frames still", "locate_contacts pushed"} <= {*steps_run(folder)}
    after = results(workflow)
    assert {name: after[name] for name in before} == before
    assert workflow.plan() == {}
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
