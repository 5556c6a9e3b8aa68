"""A warm process: it loads a step's packages once, and forks a process for each job.

A job starts with all packages loaded, and shares nothing else with earlier jobs.
"""

import contextlib
import multiprocessing
import signal
import sys
import time
from multiprocessing.connection import Connection, wait

from ur5lib.steps.job import Job, load_step

FORK = multiprocessing.get_context("fork")


def serve(connection: Connection) -> None:
    """Run jobs until the other side closes; answer each with its error, empty if it succeeded."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # interrupts the job, but not the answer
    before = 0.0
    with contextlib.suppress(EOFError, OSError):
        while True:
            job: Job = connection.recv()
            with contextlib.suppress(Exception):  # the job reports the error
                load_step(job.step)
            now = time.process_time()
            connection.send(run_in_fork(job, now - before, connection))
            before = now


def run_in_fork(job: Job, start_up: float, connection: Connection) -> str:
    """Run a job in a forked process; return its error as one sentence, empty on success.

    It is killed if the other side of the connection ends: another run may write its files next.
    """
    receiver, sender = FORK.Pipe(duplex=False)

    def run() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        sender.send(job.run(start_up))

    child = FORK.Process(target=run)
    child.start()
    if connection in wait([child.sentinel, connection]):
        child.kill()
    child.join()
    if receiver.poll():
        error: str = receiver.recv()
        return error
    return f"{job.step}: its process ended with status {child.exitcode} (see {job.log})"


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
