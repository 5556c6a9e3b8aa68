"""Work on many recordings in several processes."""

import os
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.conftest import PROJECT
from ur5lib.commands.processes import MIN_ITEMS, side_by_side
from ur5lib.errors import InputError


@pytest.fixture(autouse=True)
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 2)


def process_of(item: int) -> tuple[int, int]:
    return item, os.getpid()


def end(_: int) -> None:
    os._exit(1)


def sleep(item: int) -> None:
    os.write(1, b"%d\n" % os.getpid())  # by one call: processes share the pipe
    time.sleep(60)


def refuse(item: int) -> None:
    raise InputError(f"no {item}")


@pytest.mark.parametrize(("count", "apart"), [(2 * MIN_ITEMS - 1, False), (2 * MIN_ITEMS, True)])
def test_many_items_are_worked_on_in_processes_and_come_in_order(count: int, apart: bool) -> None:
    with side_by_side(process_of, range(count)) as answers:
        items, processes = zip(*answers, strict=True)
    assert items == tuple(range(count))
    assert (os.getpid() not in processes) == apart


@pytest.mark.parametrize(("fail", "words"), [(end, "ended early"), (refuse, "no 0")])
def test_a_failure_in_a_process_is_one_of_the_command(
    fail: Callable[[int], None], words: str
) -> None:
    with (
        pytest.raises(InputError, match=words),
        side_by_side(fail, range(2 * MIN_ITEMS)) as answers,
    ):
        list(answers)


KILLED = """
if __name__ == "__main__":
    from tests.commands.test_processes import sleep
    from ur5lib.commands.processes import side_by_side
    with side_by_side(sleep, range(2 * 4)) as answers:
        list(answers)
"""


def test_processes_end_with_a_killed_parent(tmp_path: Path) -> None:
    """By SIGKILL, while they work."""
    script, path = tmp_path / "work.py", {"PYTHONPATH": str(PROJECT)}
    script.write_text(KILLED)
    command = [sys.executable, str(script)]
    with subprocess.Popen(command, stdout=subprocess.PIPE, env=os.environ | path) as parent:
        assert parent.stdout is not None
        at_work = [int(parent.stdout.readline()) for _ in range(2)]
        parent.kill()
        end = time.monotonic() + 30
        while any(Path(f"/proc/{own}").exists() for own in at_work):
            assert time.monotonic() < end
            time.sleep(0.1)
