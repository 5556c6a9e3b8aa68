"""A process that stays warm: it loads a step's packages once, and forks a process for each job.

A job begins with all packages loaded, and shares nothing else with the jobs before it.
"""

import contextlib
import multiprocessing
import signal
import sys
import time
from multiprocessing.connection import Connection

from ur5lib.steps.job import Job, load_step

FORK = multiprocessing.get_context("fork")


def serve(connection: Connection) -> None:
    """Run jobs until the other side closes; answer each with its error, empty if it succeeded."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the job is interrupted, the answer is not
    counted = 0.0
    with contextlib.suppress(EOFError):
        while True:
            job: Job = connection.recv()
            with contextlib.suppress(Exception):  # the job itself says what is wrong
                load_step(job.step)
            now = time.process_time()
            connection.send(run_in_fork(job, now - counted))
            counted = now


def run_in_fork(job: Job, start_up: float) -> str:
    """Run a job in a process of its own; return one sentence on why it failed, or nothing."""
    receiver, sender = FORK.Pipe(duplex=False)

    def run() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        sender.send(job.run(start_up))

    child = FORK.Process(target=run)
    child.start()
    child.join()
    if receiver.poll():
        return str(receiver.recv())
    return f"{job.step}: its process ended with status {child.exitcode} (see {job.log})"


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
