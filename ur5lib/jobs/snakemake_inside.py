"""The inside of Snakemake: what is needed of it that it does not document, a function each.

Nothing else touches it, so that a new version of Snakemake is tried here. `workflow` is the object
of this name that rules have.
"""

import signal
from collections.abc import Callable, Iterator
from pathlib import Path
from threading import Thread
from typing import TYPE_CHECKING, Any

from snakemake.common import configfile, get_appdirs

if TYPE_CHECKING:
    from snakemake.workflow import Workflow


def cache_folder() -> Path:
    """Return the folder in which Snakemake keeps its cache."""
    return Path(get_appdirs().user_cache_dir)


def replace_reader(read: Callable[[str | Path], Any]) -> bool:
    """Let a function read the files of `--configfile` and `configfile:`; return whether another one
    did so before.
    """
    before, configfile._load_configfile = configfile._load_configfile, read
    return before is not read


def include_whole(workflow: "Workflow", snakefile: str | Path) -> None:
    """Include a workflow with its default target, which `include:` would leave out."""
    workflow.include(str(snakefile), overwrite_default_target=True)


def given_studies(workflow: "Workflow") -> list[Path]:
    """Return the files of `--configfile`."""
    return list(workflow.overwrite_configfiles)


def study_file(workflow: "Workflow") -> str:
    """Return the file of the study: the last one of `--configfile`, else of `configfile:`."""
    return str((workflow.overwrite_configfiles or workflow.configfiles)[-1])


def plans_jobs(workflow: "Workflow") -> bool:
    """Return whether this process plans the run, and is not started by it for a job."""
    return bool(workflow.is_main_process)


def is_job_of_cluster(workflow: "Workflow") -> bool:
    """Return whether this process is a cluster's job."""
    return bool(workflow.remote_exec)


def files_of_rules(workflow: "Workflow", kind: str) -> Iterator[tuple[str, list[str]]]:
    """Yield the name of each rule so far with its files of a kind: output, log."""
    for rule in workflow.rules:
        yield rule.name, [*map(str, getattr(rule, kind) or [])]


def run_all_here(workflow: "Workflow") -> None:
    """Make all rules so far local ones."""
    workflow.localrules(*(rule.name for rule in workflow.rules))


def stop_rescheduling(workflow: "Workflow") -> None:
    """Stop the timer, started by each job's end, that reschedules all jobs every second.

    It takes a tenth of a study's time, and no option stops it:
    https://github.com/snakemake/snakemake/pull/3744
    """
    if workflow.local_exec:
        workflow.scheduler.job_rate_limiter = None


def end_beside_the_schedule() -> None:
    """Handle the signal to end (SIGTERM) in a separate thread.

    Snakemake's handler takes the lock of its scheduler. If the interrupted thread has this lock,
    while it chooses jobs, the handler would wait for it for ever.
    """
    handler = signal.getsignal(signal.SIGTERM)
    if callable(handler):
        signal.signal(
            signal.SIGTERM, lambda *given: Thread(target=handler, args=given, daemon=True).start()
        )
