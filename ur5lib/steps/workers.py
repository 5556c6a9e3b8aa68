"""The warm processes of a run: one for each simultaneous job."""

import atexit
import os
import queue
import subprocess
import sys
from collections.abc import Iterable, Mapping
from multiprocessing import Pipe
from typing import Any

from ur5lib.steps.job import Job, Names, Setting


class StepError(Exception):
    """A step failed; the message has its name and the reason."""


class Worker:
    """A process of `ur5lib.steps.worker`, and the connection to it.

    It uses a single core, since jobs run in parallel.
    """

    def __init__(self) -> None:
        self.connection, other = Pipe()
        command = [sys.executable, "-m", "ur5lib.steps.worker", str(other.fileno())]
        environment = os.environ | {"OMP_NUM_THREADS": "1"}
        self.process = subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL, pass_fds=[other.fileno()]
        )
        other.close()

    def run(self, job: Job) -> str:
        """Run a job; return its error as one sentence, empty on success."""
        self.connection.send(job)
        return str(self.connection.recv())


FOR_PAPER = "_for_paper"  # suffix of a rule that runs another rule's script, with other outputs
FAILED: list[str] = []  # the errors of this run's steps, a sentence each
IDLE: queue.LifoQueue[Worker] = queue.LifoQueue()


def run_step(
    step: str,
    input: Mapping[str, Setting],
    output: Mapping[str, Setting],
    params: Mapping[str, Setting],
    log: Mapping[str, str],
) -> None:
    """Run a step's script in a warm process; `<step>_for_paper` runs that of `<step>`.

    Raises StepError with one sentence if it fails. Threads may call it at the same time.
    """
    script = step.removesuffix(FOR_PAPER)
    job = Job(script, names(input), names(output), names(params), log["log"], log["benchmark"])
    try:
        worker = IDLE.get_nowait()
    except queue.Empty:
        worker = Worker()
    try:
        error = worker.run(job)
        IDLE.put(worker)
    except (EOFError, OSError):
        error = f"{step}: its process was killed; see {job.log}"
    if error:
        FAILED.append(error)
        raise StepError(error)


@atexit.register
def end_idle() -> None:
    """End idle processes, so that their processor time is added to that of this one."""
    while not IDLE.empty():
        worker = IDLE.get()
        worker.process.terminate()
        worker.process.wait()


def names(values: Mapping[str, Setting]) -> Names:
    """Return Snakemake's files or settings by name, as plain strings, numbers and lists."""
    return Names({name: plain(value) for name, value in values.items()})


def plain(value: Any) -> Any:
    """Return a value without Snakemake's types, which other processes would load slowly."""
    if isinstance(value, str):
        return str(value)
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, Iterable):
        return [plain(item) for item in value]
    return value
