"""How the job of a step is run: in a warm process, with a log, a benchmark and a sentence."""

import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.conftest import PROJECT
from ur5lib.jobs import workers
from ur5lib.jobs.job import Job, Setting
from ur5lib.jobs.unreadable import reason
from ur5lib.jobs.workers import StepError, run_step

STEPS = {
    "adds": """\
import os
def adds(numbers: list[int], more: int = 0) -> str:
    print('adding', numbers, flush=True)
    os.write(2, b'from a library')
    return str(sum(numbers) + more)
""",
    "reads": """\
from pathlib import Path
from ur5lib.errors import UnreadableError
def reads(raw: Path) -> str:
    if not raw.read_text():
        raise UnreadableError('it is empty')
    return raw.read_text()
""",
    "joins": """\
from pathlib import Path
def joins(parts: list[Path], unreadable: dict[str, str]) -> dict[str, str]:
    text = ' '.join(path.read_text() for path in parts)
    return {'joined': text, 'left_out': str(unreadable)}
""",
    "advises": """\
from ur5lib.errors import InputError
def advises(numbers: list[int]) -> None:
    raise InputError('mend this')
""",
    "breaks": "def breaks(numbers: list[int]) -> None:\n    print('so far so good')\n    {}['x']\n",
    "fills": "def fills(numbers: list[int]) -> None:\n    b'1' * 600_000_000\n",
    "garbled": "def garbled(numbers: list[int]) -> None:\n    return (\n",
    "dies": "import os\ndef dies(numbers: list[int]) -> None:\n    os.kill(os.getpid(), 9)\n",
    "uses": """\
import numpy, pandas, queue, secrets
import mine
def uses(numbers: list[int]) -> str:
    return mine.PLACE
""",
    "lasts": """\
import os, time
def lasts(pid: str) -> None:
    open(pid, 'w').write(str(os.getpid()))
    time.sleep(60)
""",
    "loads": """\
import time
began = time.process_time()
while time.process_time() < began + 0.1:
    pass
def loads(numbers: list[int]) -> None:
    pass
""",
}


def make_library(folder: Path) -> None:
    """Write a library whose steps are a few made-up ones."""
    library, steps = folder / "ur5lib", folder / "ur5lib" / "steps"
    steps.mkdir(parents=True)
    for path in (PROJECT / "ur5lib").iterdir():
        if path.name != "steps":
            (library / path.name).symlink_to(path)
    for name, text in STEPS.items():
        (steps / f"{name}.py").write_text(text)


def use(folder: Path, idle: workers.queue.LifoQueue, monkeypatch: pytest.MonkeyPatch) -> None:
    """Work in a folder with its library and idle workers."""
    monkeypatch.chdir(folder)
    monkeypatch.setattr(workers, "PACKAGE", folder / "ur5lib")
    monkeypatch.setattr(workers, "IDLE", idle)


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """A folder with a library and workers of its own."""
    make_library(tmp_path)
    use(tmp_path, workers.queue.LifoQueue(), monkeypatch)
    yield tmp_path
    workers.end_idle()


@pytest.fixture(scope="module")
def warm(
    tmp_path_factory: pytest.TempPathFactory,
) -> Iterator[tuple[Path, workers.queue.LifoQueue]]:
    folder, idle = tmp_path_factory.mktemp("warm"), workers.queue.LifoQueue[workers.Worker]()
    make_library(folder)
    yield folder, idle
    while not idle.empty():
        idle.get().end()


@pytest.fixture
def warm_folder(
    warm: tuple[Path, workers.queue.LifoQueue], monkeypatch: pytest.MonkeyPatch
) -> Path:
    """A folder with a library and workers that stay from test to test."""
    use(*warm, monkeypatch)
    return warm[0]


def run(step: str, input: dict[str, Setting] | None = None, **output: Setting) -> None:
    log = {"log": f"logs/{step}.log", "benchmark": f"benchmarks/{step}.tsv"}
    run_step(step, input or {}, output, {"numbers": [1, 2], "more": 4}, log)


def measured(folder: Path, step: str) -> dict[str, float]:
    """The benchmark of a step's last job."""
    header, values = (folder / "benchmarks" / f"{step}.tsv").read_text().splitlines()
    return dict(zip(header.split(), map(float, values.split()), strict=True))


def test_a_step_gets_its_settings_and_its_result_is_written(warm_folder: Path) -> None:
    run("adds", sum="sum.txt")
    assert (warm_folder / "sum.txt").read_text() == "7"
    assert (warm_folder / "logs" / "adds.log").read_text() == "adding [1, 2]\nfrom a library"
    job = measured(warm_folder, "adds")
    assert job.keys() == {"s", "max_rss", "start_up_time", "cpu_time"}
    assert 0 < job["s"] < 60
    assert 1 < job["max_rss"] < 10_000
    assert 0 <= job["start_up_time"] <= job["cpu_time"]


def test_a_file_of_the_user_s_hides_no_package(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    """Nor does it in the folder of a clone, where the library lies beside it."""
    workspace = tmp_path_factory.mktemp("workspace")
    for place in (folder, workspace):
        for name in ("numpy", "secrets", "queue", "pandas"):
            (place / f"{name}.py").write_text("raise SystemExit('the wrong one')\n")
        (place / "mine.py").write_text(f"PLACE = {str(place)!r}\n")
        monkeypatch.chdir(place)
        run("uses", sum="sum.txt")
        assert Path("sum.txt").read_text() == str(place)
        workers.end_idle()


def test_a_warm_process_loads_once(folder: Path) -> None:
    """The first job is said to have taken that time, no other."""
    times = []
    for _ in range(3):
        run("loads")
        times.append(measured(folder, "loads")["start_up_time"])
    assert workers.IDLE.qsize() == 1
    assert times[0] >= 0.1
    assert max(times[1:]) < 0.1


def test_each_job_is_said_to_take_its_own_memory(folder: Path) -> None:
    memory = []
    for step in ("adds", "fills", "adds"):
        run(step, sum="sum.txt")
        memory.append(measured(folder, step)["max_rss"])
    before, largest, after = memory
    assert largest > before + 500  # MB
    assert after < before + 50


def test_a_job_that_reads_much_has_a_process_of_its_own(
    folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(workers, "MUCH_READ", 10)
    for size, idle in ((11, 0), (10, 1)):
        (folder / "raw").write_text("1" * size)
        run("reads", {"raw": "raw"}, sum="sum.txt")
        assert (folder / "sum.txt").read_text() == "1" * size
        assert workers.IDLE.qsize() == idle


def test_jobs_run_at_the_same_time(warm_folder: Path) -> None:
    names = [f"sum{k}.txt" for k in range(4)]
    threads = [threading.Thread(target=run, args=("adds",), kwargs={"sum": n}) for n in names]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [(warm_folder / name).read_text() for name in names] == ["7"] * 4


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
def test_a_failed_step_says_why(warm_folder: Path, step: str, sentence: str, logged: str) -> None:
    """One sentence for the terminal, what it printed and the traceback for the log."""
    with pytest.raises(StepError) as stop:
        run(step)
    assert str(stop.value).startswith(sentence)
    log = (warm_folder / "logs" / f"{step}.log").read_text()
    assert logged in log
    assert ("so far so good\n" in log) == (step == "breaks")
    run("adds", sum="after.txt")
    assert (warm_folder / "after.txt").read_text() == "7"


def test_what_a_killed_process_wrote_aside_is_gone_when_its_step_has_run_again(
    warm_folder: Path,
) -> None:
    aside = warm_folder / ".sum.txt.123.part"
    aside.write_text("4")
    run("adds", sum="sum.txt")
    assert not aside.exists()


def test_a_job_ends_with_its_run(folder: Path) -> None:
    """It would write its files later, when another run makes them."""
    worker, pid = workers.Worker(), folder / "pid"
    job = Job("lasts", {}, {}, {"pid": "pid"}, "lasts.log", "lasts.tsv")
    worker.connection.send((Job.run, job))
    while not pid.exists() or not pid.read_text():
        time.sleep(0.05)
    worker.connection.close()
    assert worker.process.wait(timeout=30) == 0
    assert not Path(f"/proc/{pid.read_text()}").exists()


ENDED_WHILE_IT_CHOOSES = """
import os, signal, threading
from functools import partial
from types import SimpleNamespace
from snakemake.scheduling.job_scheduler import JobScheduler
from ur5lib.jobs.snakemake_inside import end_beside_the_schedule
scheduler = SimpleNamespace(_lock=threading.Lock(), _open_jobs=threading.Semaphore(0))
signal.signal(signal.SIGTERM, partial(JobScheduler.exit_gracefully, scheduler))
end_beside_the_schedule()
with scheduler._lock:  # as while jobs are chosen
    os.kill(os.getpid(), signal.SIGTERM)
scheduler._open_jobs.acquire()
print(scheduler._user_kill)
"""


def test_a_run_that_is_told_to_end_while_it_chooses_its_jobs_ends() -> None:
    command = [sys.executable, "-c", ENDED_WHILE_IT_CHOOSES]
    ended = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True)
    assert ended.stdout == "graceful\n"


def test_a_recording_that_cannot_be_read_fails_no_job_and_changes_no_other(
    warm_folder: Path,
) -> None:
    """Its files say why, the log of its first step too; what is made of all is made of the rest."""
    for name, text in (("a", "1"), ("b", ""), ("c", "3")):
        (warm_folder / f"{name}.raw").write_text(text)
        (warm_folder / name).mkdir()
        run("reads", {"raw": f"{name}.raw"}, made=f"{name}/read")
        assert ("it is empty" in (warm_folder / "logs" / "reads.log").read_text()) == (name == "b")
        run("reads", {"raw": f"{name}/read"}, made=f"{name}/again")
    assert reason("b/read") == reason("b/again") == "it is empty"
    for whole, names in (("all", "abc"), ("rest", "ac")):
        parts = [f"{name}/again" for name in names]
        run("joins", {"parts": parts}, joined=f"{whole}.txt", left_out=f"{whole}_left_out.txt")
    assert (warm_folder / "all.txt").read_text() == (warm_folder / "rest.txt").read_text() == "1 3"
    assert (warm_folder / "all_left_out.txt").read_text() == "{'b': 'it is empty'}"
    assert (warm_folder / "rest_left_out.txt").read_text() == "{}"
    run("joins", {"parts": ["b/again"]}, joined="none.txt", left_out="none_left_out.txt")
    assert (warm_folder / "none.txt").read_text() == ""
    assert (warm_folder / "none_left_out.txt").read_text() == "{'b': 'it is empty'}"
