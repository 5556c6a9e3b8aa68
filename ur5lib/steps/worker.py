"""A warm process: it runs one job after the other, with the packages that it has loaded already."""

import contextlib
import os
import select
import signal
import sys
from multiprocessing.connection import Connection
from threading import Thread

from ur5lib.steps.chains import Chains
from ur5lib.steps.job import Job


def serve(connection: Connection) -> None:
    """Run jobs until the other side closes; answer each with its error, empty if it succeeded."""
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    Thread(target=end_with, args=[connection], daemon=True).start()
    with contextlib.suppress(EOFError, OSError):
        while True:
            job: Job | Chains = connection.recv()
            connection.send(job.run())


def end_with(connection: Connection) -> None:
    """End this process and its job with the other side: another run may write its files next."""
    closed = select.poll()
    closed.register(connection, 0)  # no event but the end
    closed.poll()
    os._exit(0)


if __name__ == "__main__":
    serve(Connection(int(sys.argv[1])))
