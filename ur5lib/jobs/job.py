"""One job of a step, with its log, its benchmark and a sentence on its error."""

import gc
import importlib
import os
import re
import resource
import sys
import time
import traceback
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from ur5lib.errors import InputError, UnreadableError, printable
from ur5lib.jobs.code import module_of
from ur5lib.jobs.unreadable import Files, readable
from ur5lib.workspace.places import PACKAGE

BENCHMARK = "s\tmax_rss\tstart_up_time\tcpu_time\n{:.4f}\t{:.1f}\t{:.2f}\t{:.2f}\n"

Setting = str | float | bool | list["Setting"] | dict[str, "Setting"] | None  # or files


@dataclass
class Job:
    """One run of a step: the files that it reads and writes, and its settings.

    log: file of its output, and of the traceback of an unexpected error; benchmark: file with wall
    time [s], largest memory [MB], start-up time [s] (to load packages new to the process), and
    processor time [s] including start-up.
    """

    step: str
    input: Files
    output: Files
    params: dict[str, Any]
    log: str
    benchmark: str

    def run(self) -> str:
        """Run the step in this process; return its error as one sentence, empty on success.

        From now on, all output of the process goes to the log, also that of libraries. Temporary
        files that a killed process left are deleted.
        """
        for path in map(Path, paths(self.output)):
            for part in path.parent.glob(f".{path.name}.*.part"):
                part.unlink(missing_ok=True)
        Path(self.log).parent.mkdir(parents=True, exist_ok=True)
        with open(self.log, "w", encoding="utf-8") as log:
            os.dup2(log.fileno(), sys.stdout.fileno())
            os.dup2(log.fileno(), sys.stderr.fileno())
        with suppress(OSError):  # Linux then measures the largest memory of this process anew
            Path("/proc/self/clear_refs").write_text("5")
        began, before = time.perf_counter(), time.process_time()
        with suppress(Exception):  # the step reports the error
            load_step(self.step)
        loaded = time.process_time()
        if error := self._error():
            print(error)
        sys.stdout.flush()
        took, used = time.perf_counter() - began, time.process_time() - before
        measured = BENCHMARK.format(took, largest_memory(), loaded - before, used)
        Path(self.benchmark).parent.mkdir(parents=True, exist_ok=True)
        Path(self.benchmark).write_text(measured)
        return error

    def _error(self) -> str:
        try:
            self._run()
        except UnreadableError as absent:  # the rest of the study goes on without the recording
            print(absent)
            from ur5lib.jobs.files import leave  # slow to import

            leave(load_step(self.step), str(absent), self.output)
        except InputError as error:
            return printable(f"{self.step}: {error}")
        except Exception as error:
            traceback.print_exc()
            kind = type(error).__name__
            return printable(f"{self.step}: {kind}: {error} (traceback in {self.log})")
        return ""

    def _run(self) -> None:
        from ur5lib.jobs.files import arguments, write  # slow to import

        step = load_step(self.step)
        files, absent = readable(self.input)
        settings = self.params | {"unreadable": absent}
        write(step, step(**arguments(step, files, settings)), self.output)


def paths(files: Files) -> list[str]:
    """Return the paths of a rule's files as one list; files: by name, each a path or a list of
    paths.
    """
    return [path for one in files.values() for path in ([one] if isinstance(one, str) else one)]


def largest_memory() -> float:
    """Return the largest memory of this process [MB]; on Linux, since the job began."""
    status = Path("/proc/self/status")  # `getrusage` may return the parent's memory
    if not status.exists():
        return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    (kilobytes,) = re.findall(r"VmHWM:\s*(\d+)", status.read_text())
    return int(kilobytes) / 1024


@cache
def step_named(name: str) -> Callable[..., Any]:
    """Return the function of a step, which has the name of its module."""
    module = ".".join(module_of(name).relative_to(PACKAGE.parent).with_suffix("").parts)
    step: Callable[..., Any] = getattr(importlib.import_module(module), name)
    return step


@cache
def load_step(name: str) -> Callable[..., Any]:
    """Return the function of a step, and keep its packages in memory for later jobs."""
    step = step_named(name)
    gc.collect()
    gc.freeze()  # later collections skip the packages' objects
    return step
