"""One run of a study, or one writer of a file, at a time.

By locks that end with their processes, however these end.
"""

import atexit
import contextlib
import fcntl
import getpass
import os
import socket
import sys
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import IO, Any, TextIO, TypeVar, cast

from ur5lib.errors import InputError

Lock = TypeVar("Lock", bound=IO[Any])
LOCK_FILE = ".running"
TURN_VARIABLE = "UR5_TURN"  # environment variable by which jobs on a cluster recognise their run


def take_turn(results: Path, wait: bool = False) -> TextIO:
    """Return the open lock of a study's results; it is released when its process ends.

    Its file, which names the user, is removed then, too. wait: whether to wait until another run of
    the study has ended; otherwise raises InputError that names the other run. On a shared folder,
    the lock works between machines if its file system supports `flock`.
    """
    results.mkdir(parents=True, exist_ok=True)
    lock = _lasting(partial(_locked, results, wait), results / LOCK_FILE)
    since = time.strftime("%Y-%m-%d %H:%M:%S")
    name = f"process {os.getpid()} of {getpass.getuser()} on {socket.gethostname()} since {since}"
    lock.truncate(0)
    lock.write(f"{name}\n")
    lock.flush()
    os.environ[TURN_VARIABLE] = name
    fcntl.flock(lock, fcntl.LOCK_SH)  # its jobs on a cluster share it
    atexit.register(_remove, lock, results.absolute(), os.getpid())
    return lock


def _locked(results: Path, wait: bool) -> TextIO:
    """Return the lock's file, locked for this process alone; raises as `take_turn` does."""
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
    return lock


def _lasting(locked: Callable[[], Lock], path: Path) -> Lock:
    """Return a lock as `locked` does, again where its previous owner has removed its file."""
    while not _in_place(lock := locked(), path):
        lock.close()
    return lock


def _in_place(lock: IO[Any], path: Path) -> bool:
    """Return whether an open lock file is still the file at its path."""
    with contextlib.suppress(FileNotFoundError):
        return os.path.samestat(os.fstat(lock.fileno()), os.stat(path))
    return False


def _remove(lock: TextIO, results: Path, owner: int) -> None:
    """Remove the lock's file at the end of its process, unless others have the lock, too."""
    if lock.closed or os.getpid() != owner:
        return
    with contextlib.suppress(OSError):  # its jobs on a cluster continue, or another run has begun
        fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        if _in_place(lock, results / LOCK_FILE):
            (results / LOCK_FILE).unlink()


def share_turn(results: Path) -> TextIO:
    """Return the lock of the run that submitted this process to a cluster, shared with that run.

    If that run is killed, its jobs that have begun still keep other runs out. Raises InputError if
    the run has ended, or another run has begun.
    """
    with contextlib.suppress(BlockingIOError, FileNotFoundError):
        lock = open_lock(results, "r+")
        fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
        if holder(lock) == os.environ.get(TURN_VARIABLE, holder(lock)):
            return lock
    raise InputError(
        f"the run that submitted this job has ended; another makes {results}, or is to be started"
    )


def open_lock(results: Path, mode: str = "a+") -> TextIO:
    """Return the open lock file of a study's results, not yet locked."""
    return cast("TextIO", open(results / LOCK_FILE, mode, encoding="utf-8"))


def holder(lock: TextIO) -> str:
    """Return the name of the lock's owner, which the file contains."""
    lock.seek(0)
    return lock.read().strip()


def running(results: Path) -> str:
    """Return the owner of a study's present run; empty if there is none."""
    if not (results / LOCK_FILE).is_file():
        return ""
    with open_lock(results) as lock:
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            return holder(lock)
    return ""


@contextlib.contextmanager
def reserved(path: Path, wait: bool = False) -> Iterator[None]:
    """Keep other processes from a file or folder that a `with` block writes or replaces.

    The lock is `.<name>.lock` next to it; one that a killed process left keeps nobody out. wait:
    whether to wait while another process has it. Raises InputError otherwise, and where it cannot
    be written. Folders that it makes and that stay empty are gone at the end.
    """
    place = path.with_name(f".{path.name}.lock")
    made = [own for own in path.parents if not own.exists()]
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        lock = _lasting(partial(_reservation, place, wait), place)
    except BlockingIOError as error:
        raise InputError(
            f"another process is writing {path}; wait until it has ended, or name another"
        ) from error
    except OSError as error:
        raise InputError(
            f"{path} cannot be written ({error.strerror}); check its name and the permissions"
        ) from error
    with lock:
        try:
            yield
        finally:
            place.unlink(missing_ok=True)
            with contextlib.suppress(OSError):  # what was written there stays
                for own in made:
                    own.rmdir()


def _reservation(path: Path, wait: bool) -> IO[bytes]:
    """Return an open lock file. Raises BlockingIOError where another process has it."""
    lock = path.open("ab")
    try:
        fcntl.flock(lock, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BaseException:
        lock.close()
        raise
    return lock
