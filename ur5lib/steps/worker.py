"""A warm process: it loads a step's packages once, and forks a process for each job.

A job starts with all packages loaded, and shares nothing else with earlier jobs. The chains of a
batch of recordings are one job here.
"""

import contextlib
import gc
import multiprocessing
import signal
import sys
import time
from multiprocessing.connection import Connection, wait

from ur5lib.steps.chains import Chains, End
from ur5lib.steps.job import Job, load_step

FORK = multiprocessing.get_context("fork")


def serve(connection: Connection) -> None:
    """Run jobs until the other side closes; answer each with its error, empty if it succeeded."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # interrupts the job, but not the answer
    before = 0.0
    with contextlib.suppress(EOFError, OSError):
        while True:
            job: Job | Chains = connection.recv()
            for step in job.steps():
                with contextlib.suppress(Exception):  # the job reports the error
                    load_step(step)
            gc.freeze()  # a job that collected garbage would copy the packages' memory
            now = time.process_time()
            connection.send(run_in_fork(job, now - before, connection))
            before = now


def run_in_fork(job: Job | Chains, start_up: float, connection: Connection) -> str | dict[str, End]:
    """Run a job in a forked process; return its error as one sentence, empty on success.

    Of chains, how those of each recording ended; or one sentence if their process ended itself.
    It is killed if the other side of the connection ends: another run may write its files next.
    """
    receiver, sender = FORK.Pipe(duplex=False)

    def run() -> None:
        signal.signal(signal.SIGINT, signal.SIG_DFL)
        sender.send(job.run(start_up))

    child = FORK.Process(target=run)
    child.start()
    sender.close()
    if connection in wait([receiver, connection]):
        child.kill()
    answer: str | dict[str, End] | None = None
    with contextlib.suppress(EOFError):
        answer = receiver.recv()  # before it ends: the answer may be more than a pipe holds
    child.join()
    if answer is None:
        last = job.next()
        answer = f"{last.step}: its process ended with status {child.exitcode} (see {last.log})"
    return answer


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
