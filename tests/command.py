"""Commands run as a user runs them, in limited time, and the words of what they answer."""

import re
import signal
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import FrameType
from typing import NamedTuple

import pytest

from ur5lib import cli

SECONDS = 10  # of the processor, in which every command of a test answers
WAITS = 10


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise TimeoutError in a run that does not end: in processor time, which a busy machine
    leaves as it is; one that waits for something has WAITS times as long.
    """

    def stop(signum: int, frame: FrameType | None) -> None:
        raise TimeoutError(f"took more than {seconds} s")

    timers = {signal.SIGPROF: signal.ITIMER_PROF, signal.SIGALRM: signal.ITIMER_REAL}
    before = {number: signal.signal(number, stop) for number in timers}
    signal.setitimer(signal.ITIMER_PROF, seconds)
    signal.setitimer(signal.ITIMER_REAL, WAITS * seconds)
    try:
        yield
    finally:
        for number, timer in timers.items():
            signal.setitimer(timer, 0)
            signal.signal(number, before[number])


class Answer(NamedTuple):
    """How a command ended, and what it printed; one line without the breaks of a narrow table."""

    status: int
    out: str
    err: str

    @property
    def line(self) -> str:
        return " ".join((self.out + self.err).split())


class Command:
    """`ur5`, called with arguments."""

    def __init__(self, patch: pytest.MonkeyPatch, captured: pytest.CaptureFixture) -> None:
        self.patch, self.captured = patch, captured

    def __call__(self, *arguments: object) -> Answer:
        self.patch.setattr("sys.argv", ["ur5", *map(str, arguments)])
        with pytest.raises(SystemExit) as stop, time_limit(SECONDS):
            cli.main()
        return Answer(int(stop.value.code or 0), *self.captured.readouterr())


def printed(command: Sequence[str | Path], folder: Path, variables: Mapping[str, str]) -> str:
    """What a program prints that ends well, in a folder and with these variables alone."""
    done = subprocess.run(
        command,
        cwd=folder,
        env=dict(variables),
        text=True,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    return done.stdout


def words(text: str) -> set[str]:
    """The words of a text without its punctuation: keys, values, numbers, names of files."""
    return {*re.findall(r"[^\s;:,?()]+", text)}
