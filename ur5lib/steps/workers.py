"""The warm processes of a run: one for each simultaneous job, with the packages that it has loaded.

`python -m ur5lib.steps.workers` is such a process.
"""

import atexit
import contextlib
import hashlib
import os
import queue
import select
import signal
import subprocess
import sys
from collections.abc import Callable, Container, Iterable, Mapping
from multiprocessing import Pipe
from multiprocessing.connection import Connection
from pathlib import Path
from threading import Thread
from typing import Any, TypeVar

from ur5lib.steps.absent import delete_results, left_out, reason_to_skip, without, write_stamp
from ur5lib.steps.job import BadInput, Job, Names, Setting, StepError, paths
from ur5lib.steps.upkeep import End, known, run_here, run_or_restore

Work = TypeVar("Work")
Answer = TypeVar("Answer")


class Worker:
    """A warm process, and the connection to it.

    It uses a single core, since jobs run in parallel.
    """

    def __init__(self) -> None:
        self.connection, other = Pipe()
        command = [sys.executable, "-m", "ur5lib.steps.workers", str(other.fileno())]
        environment = os.environ | {"OMP_NUM_THREADS": "1"}
        self.process = subprocess.Popen(
            command, env=environment, stdin=subprocess.DEVNULL, pass_fds=[other.fileno()]
        )
        other.close()

    def end(self) -> None:
        """End the process, so that its processor time is added to that of this one."""
        self.process.terminate()
        self.process.wait()


FOR_PAPER = "_for_paper"  # suffix of a rule that runs another rule's script, with other outputs
MUCH_READ = 500e6  # B: half an hour of an arm at 500 Hz
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

    In a study of batches, `files` of the settings are the inputs, for whose stamps Snakemake waits:
    what was left out is left out of them, too, and what is fitted to an arm or drawn of a recording
    is restored if nothing that it depends on has changed.
    Raises StepError with one sentence if it fails. Threads may call it at the same time.
    """
    script, settings = step.removesuffix(FOR_PAPER), names(params)
    read, is_kept = settings.pop("files", None), settings.pop("is_kept", False)
    job = Job(script, names(input), names(output), settings, log["log"], log["benchmark"])
    try:
        if read is None:
            run_job(job)
        else:
            job.input = Names(read)
            run_without(left_out(plain(input)), job, is_kept)
    except StepError as error:
        FAILED.append(str(error))
        raise


def run_without(absent: Mapping[str, str], job: Job, is_kept: bool) -> None:
    """Run a job that waited for batches, without recordings that were left out."""
    needed = job.params.get("recordings")
    if needed and all(name in absent for name in needed):
        reason = absent[needed[0]]
        raise StepError(f"{job.step}: none of {len(needed)} recordings can be read; {reason}")
    if reason := reason_to_skip(job, absent):
        Path(job.log).write_text(f"{reason}\n", encoding="utf-8")
        for path in paths(job.output):
            Path(path).touch()
    elif is_kept:
        run_or_restore(without(job, absent), run_job)
    else:
        run_job(without(job, absent))


def run_job(job: Job) -> None:
    """Run a job in a warm process. Raises StepError with one sentence if it fails.

    A large job has a process of its own: what others have left in memory would be added to its own.
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
    """Return what a function answers in a warm process, or one of its own; None if that ended."""
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
    """Return the error of a job whose process was killed."""
    return f"{job.step}: its process ended early, perhaps for lack of memory; see {job.log}"


def run_batch(
    chains: Iterable[tuple[str, list[Job]]],
    stamps: Iterable[str],
    stamp: str,
    log: str,
    may_be_left_out: Container[str],
) -> None:
    """Run the steps of a batch of recordings whose code, settings or files changed.

    chains: the jobs of each recording, in turn. stamps: of the batches that it waited for; stamp:
    written when all are done, with a checksum of their results and what was left out; log: which
    steps ran. may_be_left_out: recordings that are left out if they cannot be read. Raises
    StepError if a step of another failed, after all others.
    """
    absent = left_out(stamps)
    jobs = {
        name: [without(job, absent) for job in own] for name, own in chains if name not in absent
    }
    ran, failed, written = [], [], hashlib.sha256()
    for recording, end in run_chains(jobs).items():
        ran += [f"{step} {recording}" for step in end.ran]
        written.update("".join(end.written).encode())
        if isinstance(end.error, BadInput) and recording in may_be_left_out:
            absent[recording] = str(end.error)
            delete_results(jobs[recording])
        elif end.error:
            failed.append(str(end.error))
    FAILED.extend(failed)
    Path(log).write_text("".join(f"{line}\n" for line in ran + failed), encoding="utf-8")
    if failed:
        raise StepError(f"{len(failed)} recordings failed; see {log}")
    write_stamp(stamp, written.hexdigest(), absent)


def run_chains(jobs: dict[str, list[Job]]) -> dict[str, End]:
    """Run the steps of recordings in one process, or if that is killed, of each in its own."""
    ends = in_warm_process(run_here, jobs) if jobs else {}
    if ends is not None:
        return ends
    if len(jobs) == 1:
        ((name, chain),) = jobs.items()
        last = next((job for job in chain if known(job) is None), chain[-1])
        return {name: End(error=ended_early(last))}
    alone = (run_chains({name: chain}) for name, chain in jobs.items())
    return {name: end for ended in alone for name, end in ended.items()}


@atexit.register
def end_idle() -> None:
    """End idle processes."""
    while not IDLE.empty():
        IDLE.get().end()


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


def serve(connection: Connection) -> None:
    """Answer calls of functions, one after the other, until the other side closes."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    Thread(target=end_with, args=[connection], daemon=True).start()
    with contextlib.suppress(EOFError, OSError):
        while True:
            run, work = connection.recv()
            connection.send(run(work))


def end_with(connection: Connection) -> None:
    """End this process and its job with the other side: another run may write its files next."""
    closed = select.poll()
    closed.register(connection, 0)  # no event but the end
    closed.poll()
    os._exit(0)


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
