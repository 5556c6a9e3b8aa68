"""Work on many recordings in several processes at once."""

import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import TypeVar

from ur5lib.errors import InputError
from ur5lib.workspace.extensions import take_up_all

Item = TypeVar("Item")
Answer = TypeVar("Answer")

MAX_PROCESSES = 4  # limits memory, since each process loads a recording
MIN_ITEMS = 4  # for each process, since its start takes a while


@contextmanager
def side_by_side(
    function: Callable[[Item], Answer], items: Sequence[Item]
) -> Iterator[Iterable[Answer]]:
    """Yield a function's results for items, in their order; many items are split among processes.

    Raises InputError where a process ends early.
    """
    count = min(MAX_PROCESSES, os.cpu_count() or 1, len(items) // MIN_ITEMS)
    if count < 2:
        yield map(function, items)
        return
    processes = ProcessPoolExecutor(count, initializer=_start)
    try:
        yield processes.map(function, items)
    except BrokenProcessPool as error:
        raise InputError(
            "a process that read recordings ended early, perhaps for lack of memory; "
            "end other programs, or check a study of fewer recordings"
        ) from error
    finally:
        processes.shutdown(cancel_futures=True)


def _start() -> None:
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent process handles Ctrl-C
    take_up_all()
