"""What every workflow script has in common: its log, and how it fails."""

import sys
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

from ur5lib.errors import InputError

Step = Callable[[Any, Any, Any], None]


def run_step(step: Step, snakemake: Any) -> None:
    """Run `step(input, output, params)` for a Snakemake job.

    What it prints goes to the job's log. A wrong input is told there in its own sentence, any
    other failure with its traceback; both end the process with status 1.
    """
    log = Path(snakemake.log[0])
    log.parent.mkdir(parents=True, exist_ok=True)
    with log.open("w", encoding="utf-8") as stream:
        sys.stdout = sys.stderr = stream
        try:
            step(snakemake.input, snakemake.output, snakemake.params)
        except InputError as error:
            print(error, file=stream)
            sys.exit(1)
        except Exception:
            traceback.print_exc(file=stream)
            sys.exit(1)
