"""What every workflow script has in common: its log, and how it fails."""

import contextlib
import os
import re
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

import psutil

from ur5lib.errors import InputError

Step = Callable[[Any, Any, Any], None]
START_UP = "start-up took {:.2f} s"


def run_step(step: Step, snakemake: Any) -> None:
    """Run `step(input, output, params)` for a Snakemake job.

    What it prints goes to the job's log, after the time that Python and its packages took to
    start, the traceback of an unexpected error too; the terminal gets one sentence on what went
    wrong. Ends the process, with status 1 where the step failed.
    """
    log = Path(snakemake.log[0])
    with (
        log.open("w", encoding="utf-8") as stream,
        contextlib.redirect_stdout(stream),
        contextlib.redirect_stderr(stream),
    ):
        print(START_UP.format(time.time() - psutil.Process().create_time()))
        try:
            step(snakemake.input, snakemake.output, snakemake.params)
        except InputError as error:
            _fail(f"{snakemake.rule}: {error}")
        except Exception as error:
            traceback.print_exc()
            _fail(f"{snakemake.rule}: {type(error).__name__}: {error} (traceback in {log})")
    # All files are closed. That Python takes torch and scipy apart again would take up to 0.4 s.
    os._exit(0)


def start_up_of(log: str | Path) -> float:
    """The start-up time that a job's log tells [s], NaN where it tells none."""
    pattern = START_UP.replace("{:.2f}", r"([\d.]+)")
    found = re.match(pattern, Path(log).read_text(encoding="utf-8"))
    return float(found[1]) if found else float("nan")


def _fail(sentence: str) -> NoReturn:
    print(sentence)
    print(sentence, file=sys.__stderr__)
    sys.exit(1)
