"""A line on a terminal that says which step runs, in place of Snakemake's lines on each job.

Only a terminal that can overwrite a line gets it. Logs and Snakemake's own log file are as always.
"""

import logging
import os
from collections.abc import Mapping
from typing import Any, TextIO

from snakemake.logging import DefaultFilter, get_event
from snakemake.settings.enums import Quietness
from snakemake_interface_logger_plugins.common import LogEvent

SELECTS = "Select jobs to execute..."
UNSEEN = {LogEvent.JOB_STARTED, LogEvent.JOB_FINISHED, LogEvent.SHELLCMD}
CLEARED = "\r\x1b[2K"  # the cursor at the beginning of an empty line


class ProgressLine(logging.Handler):
    """Shows the newest job and the number of those that ended; other messages clear the line."""

    def __init__(self, stream: TextIO) -> None:
        super().__init__(logging.INFO)
        self.stream, self.step, self.ended = stream, "", ""

    def emit(self, record: logging.LogRecord) -> None:
        """Update the line by a record of Snakemake's logger, before others print the record."""
        fields: Any = record
        event = get_event(record)
        if event == LogEvent.JOB_INFO:
            self.step = described(fields.rule_name, fields.wildcards or {})
        elif event == LogEvent.PROGRESS:
            self.ended = f", {fields.done} of {fields.total}"
        elif event in UNSEEN or record.msg == SELECTS:
            return
        else:
            self.step = ""
        width = os.get_terminal_size(self.stream.fileno()).columns or 80
        self.stream.write(CLEARED + (self.step and self.step + self.ended)[: width - 1])
        self.stream.flush()


def described(rule: str, wildcards: Mapping[str, str]) -> str:
    """Return what a job does, e.g. "fit friction of ur5e"."""
    step = rule.replace("_", " ")
    return " ".join([step, *(f"of {name}" for name in wildcards.values())])


def show_progress(logger: logging.Logger, environment: Mapping[str, str]) -> None:
    """Put the line below Snakemake's messages, if they go to a terminal that can overwrite it."""
    for handler in logger.handlers:
        if isinstance(handler, logging.StreamHandler) and handler.name == "DefaultStreamHandler":
            if environment.get("CI") or environment.get("TERM", "dumb") == "dumb":
                return
            if handler.stream.isatty():
                for chosen in handler.filters:
                    if isinstance(chosen, DefaultFilter):
                        chosen.quiet = {*chosen.quiet, Quietness.PROGRESS}
                handler.addFilter(
                    lambda record: get_event(record) not in UNSEEN and record.msg != SELECTS
                )
                logger.handlers.insert(0, ProgressLine(handler.stream))
                return
