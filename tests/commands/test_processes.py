"""Work on many recordings in several processes."""

import os
from collections.abc import Callable

import pytest

from ur5lib.commands.processes import MIN_ITEMS, side_by_side
from ur5lib.errors import InputError


@pytest.fixture(autouse=True)
def two_cores(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("os.cpu_count", lambda: 2)


def process_of(item: int) -> tuple[int, int]:
    return item, os.getpid()


def end(_: int) -> None:
    os._exit(1)


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
