"""How a step is run, and what each makes of one small recording."""

import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from tests.conftest import Workflow
from ur5lib.jobs.job import Job, Names, StepError
from ur5lib.jobs.workers import run_chains, run_step
from ur5lib.robots.description import Robot
from ur5lib.steps import job, workers
from ur5lib.tables import read_csv, read_json, read_table

STEPS = {
    "adds": "import os\ndef adds(input, output, params):\n"
    "    print('adding', input.numbers, flush=True)\n"
    "    os.write(2, b'from a library')\n"
    "    open(output.sum, 'w').write(str(sum(input['numbers']) + params.get('more', 0)))\n",
    "adds_up": "def adds_up(input, output, params):\n"
    "    open(output.sum, 'w').write(open(input.raw).read())\n",
    "advises": "from ur5lib.errors import InputError\n"
    "def advises(input, output, params):\n    raise InputError('mend this')\n",
    "breaks": "def breaks(input, output, params):\n    print('so far so good')\n    {}['x']\n",
    "fills": "def fills(input, output, params):\n    b'1' * 600_000_000\n",
    "garbled": "def garbled(input, output, params):\n    return (\n",
    "dies": "import os\ndef dies(input, output, params):\n    os.kill(os.getpid(), 9)\n",
    "lasts": "import os, time\n"
    "def lasts(input, output, params):\n"
    "    open(output.pid, 'w').write(str(os.getpid()))\n    time.sleep(60)\n",
    "loads": "import time\n"
    "began = time.process_time()\nwhile time.process_time() < began + 0.1:\n    pass\n"
    "def loads(input, output, params):\n    pass\n",
}


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A project of a few made-up steps, with workers of its own."""
    scripts = tmp_path / "workflow" / "scripts"
    scripts.mkdir(parents=True)
    for name, text in STEPS.items():
        (scripts / f"{name}.py").write_text(text)
    (tmp_path / "ur5lib").symlink_to(Path(job.__file__).parents[1])
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(workers, "IDLE", workers.queue.LifoQueue())
    yield tmp_path
    workers.end_idle()


def run(step: str, **output: str) -> None:
    log = {"log": f"logs/{step}.log", "benchmark": f"benchmarks/{step}.tsv"}
    run_step(step, {"numbers": [1, 2]}, output, {"more": 4}, log)


def test_a_step_gets_input_output_and_params(folder: Path) -> None:
    run("adds", sum="sum.txt")
    assert (folder / "sum.txt").read_text() == "7"
    assert (folder / "logs" / "adds.log").read_text() == "adding [1, 2]\nfrom a library"
    header, values = (folder / "benchmarks" / "adds.tsv").read_text().splitlines()
    assert header.split() == ["s", "max_rss", "start_up_time", "cpu_time"]
    wall, memory, start_up, processor = map(float, values.split())
    assert 0 < wall < 60
    assert 1 < memory < 10_000
    assert 0 <= start_up <= processor


def test_a_warm_process_loads_once(folder: Path) -> None:
    """The first job is said to have taken that time, no other."""
    times = []
    for _ in range(3):
        run("loads")
        times.append(float((folder / "benchmarks" / "loads.tsv").read_text().split()[6]))
    assert workers.IDLE.qsize() == 1
    assert times[0] >= 0.1
    assert max(times[1:]) < 0.1


def test_each_job_is_said_to_take_its_own_memory(folder: Path) -> None:
    memory = []
    for step in ("adds", "fills", "adds"):
        run(step, sum="sum.txt")
        memory.append(float((folder / "benchmarks" / f"{step}.tsv").read_text().split()[5]))
    before, largest, after = memory
    assert largest > before + 500  # MB
    assert after < before + 50


def test_a_job_that_reads_much_has_a_process_of_its_own(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "MUCH_READ", 10)
    for size, idle in ((11, 0), (10, 1)):
        (folder / "raw").write_text("1" * size)
        log = {"log": "logs/adds_up.log", "benchmark": "benchmarks/adds_up.tsv"}
        run_step("adds_up", {"raw": "raw"}, {"sum": "sum.txt"}, {}, log)
        assert (folder / "sum.txt").read_text() == "1" * size
        assert workers.IDLE.qsize() == idle


def test_jobs_run_at_the_same_time(folder: Path) -> None:
    names = [f"sum{k}.txt" for k in range(4)]
    threads = [threading.Thread(target=run, args=("adds",), kwargs={"sum": n}) for n in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [(folder / name).read_text() for name in names] == ["7"] * 4


@pytest.mark.parametrize(
    ("step", "sentence", "logged"),
    [
        ("advises", "advises: mend this", "advises: mend this\n"),
        ("breaks", "breaks: KeyError: 'x' (traceback in logs/breaks.log)", "Traceback"),
        ("garbled", "garbled: SyntaxError: '(' was never closed", "Traceback"),
        (
            "dies",
            "dies: its process ended early, perhaps for lack of memory; see logs/dies.log",
            "",
        ),
    ],
)
def test_a_failed_step_says_why(folder: Path, step: str, sentence: str, logged: str) -> None:
    """One sentence for the terminal, what it printed and the traceback for the log."""
    with pytest.raises(StepError) as stop:
        run(step)
    assert str(stop.value).startswith(sentence)
    log = (folder / "logs" / f"{step}.log").read_text()
    assert logged in log
    assert ("so far so good\n" in log) == (step == "breaks")
    run("adds", sum="after.txt")
    assert (folder / "after.txt").read_text() == "7"


def test_what_a_killed_process_wrote_aside_is_gone_when_its_step_has_run_again(
    folder: Path,
) -> None:
    aside = folder / ".sum.txt.123.part"
    aside.write_text("4")
    run("adds", sum="sum.txt")
    assert not aside.exists()


def test_a_job_ends_with_its_run(folder: Path) -> None:
    """It would write its files later, when another run makes them."""
    worker, pid = workers.Worker(), folder / "pid"
    files = Names(), Names(pid="pid"), Names()
    worker.connection.send((Job.run, Job("lasts", *files, "lasts.log", "lasts.tsv")))
    while not pid.exists() or not pid.read_text():
        time.sleep(0.05)
    worker.connection.close()
    assert worker.process.wait(timeout=30) == 0
    assert not Path(f"/proc/{pid.read_text()}").exists()


def test_a_recording_that_kills_the_process_of_its_batch_is_named_alone(folder: Path) -> None:
    """The others' steps run, each once; what has run is not run again."""
    (folder / "number").write_text("1")

    def step(name: str, of: str) -> Job:
        log = f"logs/{name}/{of}.log", f"benchmarks/{name}/{of}.tsv"
        files = Names(raw="number"), Names(sum=f"sum_{of}.txt")
        return Job(name, *files, Names(), *log)

    chains = {"a": ["adds_up"], "b": ["adds_up", "dies"], "c": ["adds_up"]}
    jobs = {of: [step(name, of) for name in steps] for of, steps in chains.items()}
    ends = run_chains(jobs)
    assert {of: end.error for of, end in ends.items() if end.error} == {
        "b": "dies: its process ended early, perhaps for lack of memory; see logs/dies/b.log"
    }
    assert all((folder / f"sum_{of}.txt").read_text() == "1" for of in chains)
    del jobs["b"]
    assert all(end.ran == [] and end.written for end in run_chains(jobs).values())


# The small study's steps


@pytest.fixture(scope="module")
def results(built_workflow: Workflow) -> Path:
    return built_workflow.folder / "results" / "small"


def test_signals_are_on_the_robots_clock(results: Path) -> None:
    signals = read_table(results / "recordings" / "pushed" / "signals.parquet")
    np.testing.assert_allclose(np.diff(signals["time"]), 0.008)
    push = signals["time"].between(2.4, 3.2)
    assert signals.loc[push, "ft_fx"].mean() == pytest.approx(15, abs=0.1)
    clock = read_json(results / "recordings" / "pushed" / "clocks.json")["force"]
    assert clock["offset"] == pytest.approx(0.005, abs=1e-6)
    assert clock["drift"] is None
    # absent devices have no columns
    still = read_table(results / "recordings" / "still" / "signals.parquet")
    assert not still.filter(regex="ft_|imu_").columns.any()
    assert read_json(results / "recordings" / "still" / "quality.json")["devices"] == ["robot"]


def test_tables_have_a_row_for_each_value(results: Path, ur5: Robot) -> None:
    torque = read_csv(results / "tables" / "torque_mae.csv")
    looped = ur5.models.keys() & ur5.closed_loop_gains.keys()
    models = {*ur5.models, "identified"}
    assert len(torque) == 2 * (2 * len(models) + len(looped)) * 6  # recordings, ..., joints
    assert torque["printed"].isna().all()
    force = read_csv(results / "tables" / "force_mae.csv")
    assert set(force["recording"]) == {"pushed"}
    estimates = force.groupby("kind")["estimate"].unique().map(set)
    assert estimates["printed"] == {"Fu", "F", "F*"}
    assert estimates["corrected"] == estimates["compensated"] >= {"Fu", "F", "F*", "Fmap"}
    parts = force.groupby(["kind", "estimate", "during"]).size()
    assert (parts == 6).all()  # components
    assert len(parts) == sum(map(len, estimates)) * force["during"].nunique()
    assert {"all", "contact"} <= {*force["during"]}
    errors = read_csv(results / "tables" / "contact_errors.csv")
    assert errors.groupby("estimate")["contact"].nunique().eq(1).all()
    assert {*errors["estimate"]} == estimates["compensated"]
