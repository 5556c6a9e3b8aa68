"""The common frame of all workflow scripts: log, error messages, exit status."""

import contextlib
import os
import re
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, NoReturn

from ur5lib.errors import InputError, printable

Step = Callable[[Any, Any, Any], None]
START_UP, WHOLE = "start-up took {:.2f} s", "with it, the step took {:.2f} s of processor time"


def run_step(step: Step, snakemake: Any) -> None:
    """Run `step(input, output, params)` for a Snakemake job.

    Its output and the traceback of an unexpected error go to the job's log, between the
    processor time that Python and its packages took to start and that of the whole step; the
    terminal shows one sentence on the error. Ends the process, with status 1 if the step
    failed.
    """
    log = Path(snakemake.log[0])
    with (
        log.open("w", encoding="utf-8") as stream,
        contextlib.redirect_stdout(stream),
        contextlib.redirect_stderr(stream),
    ):
        print(START_UP.format(time.process_time()))
        try:
            step(snakemake.input, snakemake.output, snakemake.params)
        except InputError as error:
            _fail(f"{snakemake.rule}: {error}")
        except Exception as error:
            traceback.print_exc()
            _fail(f"{snakemake.rule}: {type(error).__name__}: {error} (traceback in {log})")
        print(WHOLE.format(time.process_time()))
    # all files are closed; unloading torch and scipy would take up to 0.4 s
    os._exit(0)


def processor_times(log: str | Path) -> tuple[float, float]:
    """Return the processor times of start-up and the whole step [s] from a log; NaN if missing."""
    text = Path(log).read_text(encoding="utf-8")
    patterns = (line.replace("{:.2f}", r"([\d.]+)") for line in (START_UP, WHOLE))
    start_up, whole = (re.search(pattern, text) for pattern in patterns)
    return (
        float(start_up[1]) if start_up else float("nan"),
        float(whole[1]) if whole else float("nan"),
    )


def _fail(sentence: str) -> NoReturn:
    sentence = printable(sentence)
    print(sentence)
    print(sentence, file=sys.__stderr__)
    sys.exit(1)
