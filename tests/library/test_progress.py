"""The line on a terminal that says which step runs."""

import io
import logging
import os
import select
from collections.abc import Iterator
from typing import TextIO

import pytest
from snakemake.logging import DefaultFilter
from snakemake.settings.enums import Quietness
from snakemake_interface_logger_plugins.common import LogEvent

from ur5lib.steps.progress import CLEARED, ProgressLine, described, show_progress

TERMINAL = {"TERM": "xterm"}
QUIET = 0.5  # s


class Terminal:
    """A terminal of a width, and what was written to it."""

    def __init__(self) -> None:
        self.master, slave = os.openpty()
        self.stream: TextIO = os.fdopen(slave, "w")

    def shown(self) -> str:
        """What its last line shows, once nothing more arrives: the kernel passes it on in parts."""
        self.stream.flush()
        read = b""
        while select.select([self.master], [], [], QUIET)[0]:
            read += os.read(self.master, 10_000)
        return read.decode().rsplit(CLEARED, 1)[-1]


@pytest.fixture
def terminal() -> Iterator[Terminal]:
    opened = Terminal()
    yield opened
    opened.stream.close()
    os.close(opened.master)


def snakemakes_logger(stream: TextIO) -> logging.Logger:
    """A logger as Snakemake sets it up."""
    logger = logging.Logger("snakemake")
    handler = logging.StreamHandler(stream)
    handler.name = "DefaultStreamHandler"
    handler.addFilter(DefaultFilter([Quietness.RULES], False, False, False, False))
    logger.addHandler(handler)
    return logger


def run_a_job(logger: logging.Logger) -> None:
    logger.info("Select jobs to execute...")
    logger.info("Execute 1 jobs...", extra={"event": LogEvent.JOB_STARTED})
    job = {"event": LogEvent.JOB_INFO, "rule_name": "fit_friction", "wildcards": {"robot": "ur5e"}}
    logger.info("Rule", extra=job)
    logger.info("Finished", extra={"event": LogEvent.JOB_FINISHED})
    logger.info("progress", extra={"event": LogEvent.PROGRESS, "done": 12, "total": 142})


def test_a_job_is_described_in_words() -> None:
    assert described("fit_friction", {"robot": "ur5e"}) == "fit friction of ur5e"
    assert described("make_tables", {}) == "make tables"


def test_a_terminal_shows_the_newest_job_in_one_line(terminal: Terminal) -> None:
    logger = snakemakes_logger(terminal.stream)
    show_progress(logger, TERMINAL)
    run_a_job(logger)
    assert terminal.shown() == "fit friction of ur5e, 12 of 142"
    logger.info("Complete log(s): here")
    assert terminal.shown() == "Complete log(s): here\r\n"


@pytest.mark.parametrize("environment", [{"TERM": "dumb"}, {}, {"TERM": "xterm", "CI": "true"}])
def test_another_terminal_gets_snakemakes_lines(
    terminal: Terminal, environment: dict[str, str]
) -> None:
    logger = snakemakes_logger(terminal.stream)
    show_progress(logger, environment)
    assert not any(isinstance(handler, ProgressLine) for handler in logger.handlers)
    run_a_job(logger)
    assert "Select jobs to execute..." in terminal.shown()


def test_a_log_gets_snakemakes_lines() -> None:
    log = io.StringIO()
    logger = snakemakes_logger(log)
    show_progress(logger, TERMINAL)
    run_a_job(logger)
    assert "Execute 1 jobs..." in log.getvalue()
    assert CLEARED not in log.getvalue()
