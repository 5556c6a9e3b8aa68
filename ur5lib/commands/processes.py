"""Work on many recordings in several processes at once, which end with their parent."""

import multiprocessing
import os
import signal
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from threading import Thread
from typing import TypeVar

from ur5lib.errors import InputError
from ur5lib.workspace.extensions import take_up_all

Item = TypeVar("Item")
Answer = TypeVar("Answer")

MAX_PROCESSES = 4  # limits memory, since each process loads a recording
GRACE = 2.0  # s; for a process to end by itself after its parent has ended
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


def end_with_parent() -> None:
    """End this process, which `multiprocessing` made, GRACE s after its parent has ended, even if
    that was killed before.
    """
    if (parent := multiprocessing.parent_process()) is None:
        return

    def end() -> None:
        parent.join()
        time.sleep(GRACE)
        os._exit(1)

    Thread(target=end, daemon=True).start()


def _start() -> None:
    end_with_parent()
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # the parent process handles Ctrl-C
    take_up_all()
