"""One run of a study at a time: a lock that ends with its processes, however they end."""

import contextlib
import fcntl
import getpass
import os
import socket
import sys
import time
from pathlib import Path
from typing import TextIO

from ur5lib.errors import InputError

LOCK_FILE = ".running"
TURN_VARIABLE = "UR5_TURN"  # environment variable by which a run's jobs on a cluster know their run


def take_turn(results: Path, wait: bool = False) -> TextIO:
    """Return the open lock of a study's results; it is released when its process ends.

    wait: until another run of the study has ended. Raises InputError that names the other run. On a
    shared folder, the lock holds between machines where its file system passes `flock` on.
    """
    results.mkdir(parents=True, exist_ok=True)
    lock = open_lock(results)
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        other = f"{results} is being made by {holder(lock) or 'another run'}"
        if not wait:
            raise InputError(
                f"{other}; run again when that has ended, or wait for it: "
                "ur5 run <study> -- --config wait=true"
            ) from None
        print(f"{other}; waiting until that has ended", file=sys.stderr, flush=True)
        fcntl.flock(lock, fcntl.LOCK_EX)
    since = time.strftime("%Y-%m-%d %H:%M:%S")
    name = f"process {os.getpid()} of {getpass.getuser()} on {socket.gethostname()} since {since}"
    lock.truncate(0)
    lock.write(f"{name}\n")
    lock.flush()
    os.environ[TURN_VARIABLE] = name
    fcntl.flock(lock, fcntl.LOCK_SH)  # its jobs on a cluster share it
    return lock


def share_turn(results: Path) -> TextIO:
    """Return the lock of the run that has submitted this process to a cluster, shared with it.

    If that run is killed, its jobs that have begun still keep others out. Raises InputError if
    another run has its turn by now.
    """
    lock = open_lock(results)
    with contextlib.suppress(BlockingIOError):
        fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        if holder(lock) == os.environ.get(TURN_VARIABLE, holder(lock)):
            return lock
    raise InputError(f"the run that submitted this job has ended; now {results} is made by another")


def open_lock(results: Path) -> TextIO:
    """Return the file to be locked."""
    return open(results / LOCK_FILE, "a+", encoding="utf-8")


def holder(lock: TextIO) -> str:
    """Return who has locked a file, by what is written there."""
    lock.seek(0)
    return lock.read().strip()


def running(results: Path) -> str:
    """Return who makes a study's results at the moment; empty if nobody does."""
    if not (results / LOCK_FILE).is_file():
        return ""
    with open_lock(results) as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return holder(lock)
    return ""
