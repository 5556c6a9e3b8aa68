"""One run of a study at a time: a lock that ends with its process, however that ends."""

import fcntl
import getpass
import os
import socket
import time
from pathlib import Path
from typing import TextIO

from ur5lib.errors import InputError

LOCK = ".running"


def take_turn(results: Path, wait: bool = False) -> TextIO:
    """Return the open lock of a study's results; it is released when its process ends.

    wait: until another run of the study has ended. Raises InputError that names the other run. On a
    shared folder, the lock holds between machines where its file system passes `flock` on.
    """
    results.mkdir(parents=True, exist_ok=True)
    lock = open(results / LOCK, "a+", encoding="utf-8")  # noqa: SIM115 held until the process ends
    try:
        fcntl.flock(lock, fcntl.LOCK_EX if wait else fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        lock.seek(0)
        raise InputError(
            f"{results} is being made by {lock.read().strip() or 'another run'}; run again when "
            "that has ended, or wait for it: snakemake --config wait=true"
        ) from None
    lock.truncate(0)
    since = time.strftime("%Y-%m-%d %H:%M")
    host = socket.gethostname()
    lock.write(f"process {os.getpid()} of {getpass.getuser()} on {host} since {since}\n")
    lock.flush()
    return lock
