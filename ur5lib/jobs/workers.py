"""The warm processes of a run: one for each simultaneous job, with the packages that it has loaded.

Such a process loads this package from the same place as its parent, and searches the working folder
last, so that a user's `numpy.py` there does not replace the package.
"""

import atexit
import contextlib
import gc
import os
import queue
import select
import signal
import subprocess
import sys
from collections.abc import Callable, Iterable, Mapping
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from threading import Thread
from typing import Any, TypeVar

from ur5lib.jobs.job import Job, Setting, paths
from ur5lib.workspace.places import PACKAGE

START = """\
import sys
sys.path.insert(0, sys.argv[1])
import ur5lib
del sys.path[0]
sys.path.append("")
from ur5lib.jobs.workers import Connection, serve
serve(Connection(int(sys.argv[2])))
"""
Work = TypeVar("Work")
Answer = TypeVar("Answer")


class Worker:
    """A warm process, and the connection to it.

    It uses a single core, since jobs run in parallel.
    """

    def __init__(self) -> None:
        self.connection, other = Pipe()
        given = str(PACKAGE.parent), str(other.fileno())
        command = [sys.executable, "-P", "-c", START, *given]
        environment = os.environ | {"OMP_NUM_THREADS": "1"}
        self.process = subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL, pass_fds=[other.fileno()]
        )
        other.close()

    def end(self) -> None:
        """End the process and wait for it, which adds its processor time to this process's."""
        self.process.terminate()
        self.process.wait()


MUCH_READ = 500e6  # B; half an hour of an arm at 500 Hz
# Objects made before the search for cycles; by Python's own, 700, it takes a sixth of drawing.
NEW_OBJECTS = 10_000
FAILED: list[str] = []  # the errors of this run's steps, a sentence each
IDLE: queue.LifoQueue[Worker] = queue.LifoQueue()


class StepError(Exception):
    """A step failed; the message has its name and the reason."""


def run_step(
    step: str,
    input: Mapping[str, Setting],
    output: Mapping[str, Setting],
    params: Mapping[str, Setting],
    log: Mapping[str, str],
) -> None:
    """Run a step in a warm process.

    Raises StepError with one sentence if it fails. Threads may call it at the same time.
    """
    try:
        run_job(Job(step, names(input), names(output), names(params), log["log"], log["benchmark"]))
    except StepError as error:
        FAILED.append(str(error))
        raise


def run_job(job: Job) -> None:
    """Run a job in a warm process. Raises StepError with one sentence if it fails.

    A large job gets a new process, without the memory that earlier jobs have left.
    """
    read = sum(os.path.getsize(path) for path in paths(job.input) if os.path.exists(path))
    error = in_warm_process(Job.run, job, alone=read > MUCH_READ)
    if error is None:
        error = ended_early(job)
    if error:
        raise StepError(error)


def in_warm_process(
    run: Callable[[Work], Answer], work: Work, alone: bool = False
) -> Answer | None:
    """Return a function's answer from a warm process, or from a new one if `alone`; None if the
    process ended.
    """
    try:
        worker = Worker() if alone else IDLE.get_nowait()
    except queue.Empty:
        worker = Worker()
    try:
        worker.connection.send((run, work))
        answer: Answer = worker.connection.recv()
    except (EOFError, OSError):
        return None
    if alone:
        worker.end()
    else:
        IDLE.put(worker)
    return answer


def ended_early(job: Job) -> str:
    """Return the error of a job after its process was killed."""
    return f"{job.step}: its process ended early, perhaps for lack of memory; see {job.log}"


@atexit.register
def end_idle() -> None:
    """End idle processes."""
    while not IDLE.empty():
        IDLE.get().end()


def names(values: Mapping[str, Any]) -> dict[str, Any]:
    """Return Snakemake's files or settings by name, as plain strings, numbers and lists."""
    return {name: plain(value) for name, value in values.items()}


def plain(value: Any) -> Any:
    """Return a value without Snakemake's types, which other processes would load slowly."""
    if isinstance(value, str):
        return str(value)
    if isinstance(value, Mapping):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, Iterable):
        return [plain(item) for item in value]
    return value


def serve(connection: Connection) -> None:
    """Answer calls of functions, one after the other, until the other side closes."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    gc.set_threshold(NEW_OBJECTS)
    Thread(target=end_with, args=[connection], daemon=True).start()
    with contextlib.suppress(EOFError, OSError):
        while True:
            run, work = connection.recv()
            connection.send(run(work))


def end_with(connection: Connection) -> None:
    """End this process and its job as soon as the process at the other end of the connection has
    ended: another run may write the job's files next.
    """
    closed = select.poll()
    closed.register(connection, 0)  # only the end of the connection
    closed.poll()
    os._exit(0)
