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

from ur5lib.errors import InputError, printable

Step = Callable[[Any, Any, Any], None]
START_UP, WHOLE = "start-up took {:.2f} s", "with it, the step took {:.2f} s of processor time"


def run_step(step: Step, snakemake: Any) -> None:
    """Run `step(input, output, params)` for a Snakemake job.

    What it prints goes to the job's log, the traceback of an unexpected error too, between the
    processor time that Python and its packages took to start and that of the whole step; the
    terminal gets one sentence on what went wrong. Ends the process, with status 1 if the step
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
    # All files are closed. That Python takes torch and scipy apart again would take up to 0.4 s.
    os._exit(0)


def processor_times(log: str | Path) -> tuple[float, float]:
    """What a job's log tells of start-up and of the whole step [s]; NaN where it tells nothing."""
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
