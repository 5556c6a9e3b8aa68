"""Which steps must run again: by their code, their settings and the contents of their files.

Snakemake decides this for its jobs. Where one of its jobs is many steps, this decides for each.
"""

import hashlib
import json
import os
import shutil
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

from ur5lib.steps.job import Job, StepError, paths

Seen = tuple[int, int, str]  # when a file was changed [ns], its size [B] and its checksum


@dataclass
class End:
    """How the steps of a recording ended.

    ran: those that ran; written: checksums of what each wrote; error: of the one that failed, one
    sentence, empty if none did.
    """

    ran: list[str] = field(default_factory=list)
    written: list[str] = field(default_factory=list)
    error: str = ""


def run_here(jobs: dict[str, list[Job]]) -> dict[str, End]:
    """Run the steps of recordings that must run in this process; return how those of each ended.

    What a process has loaded, parsed or compiled for one recording serves all others: of recordings
    of seconds, that takes longer than the computation.
    """
    return {name: _end_of(chain) for name, chain in jobs.items()}


def _end_of(chain: list[Job]) -> End:
    end = End()

    def run(job: Job) -> None:
        if error := job.run():
            end.error = error
            raise StepError

    for job in chain:
        try:
            ran, written = run_if_changed(job, run)
        except StepError:
            break
        end.ran += [job.step] if ran else []
        end.written += written
    return end


def run_if_changed(job: Job, run: Callable[[Job], None]) -> tuple[bool, list[str]]:
    """Run a step unless its files are those of its last run.

    Return whether it ran, and the checksums of what it wrote, now or then.
    """
    if (checksums := known(job)) is not None:
        return False, checksums
    record(job).unlink(missing_ok=True)
    read = {path: seen(path) for path in paths(job.input)}
    run(job)
    written = {path: seen(path) for path in paths(job.output)}
    write_whole(json.dumps([declaration(job), read, written]), record(job))
    return True, [checksum for _, _, checksum in written.values()]


def run_or_restore(job: Job, run: Callable[[Job], None]) -> None:
    """Run a step unless nothing that it depends on has changed; restore then what it wrote.

    Snakemake deletes the files of a step before it runs, and empties its log and benchmark. Copies
    are kept beside its record, those of its outputs last: if these are right, the others are, too.
    """
    folder = record(job).with_suffix(".kept")
    files = [job.log, job.benchmark, *paths(job.output)]
    kept = {path: folder / Path(path).name for path in files}
    for path, copy in kept.items():
        if copy.exists():
            shutil.copyfile(copy, path)
    ran, _ = run_if_changed(job, run)
    if ran:
        folder.mkdir(exist_ok=True)
        for path, copy in kept.items():
            shutil.copyfile(path, copy)


def known(job: Job) -> list[str] | None:
    """Return the checksums of what a step's last run wrote; None if it must run again.

    It need not where its files are those of its last run, by the present code and settings.
    """
    try:
        declared, read, written = json.loads(record(job).read_bytes())
    except FileNotFoundError:
        return None
    same = declared == declaration(job) and all(
        is_same(path, *then) for path, then in (read | written).items()
    )
    return [checksum for _, _, checksum in written.values()] if same else None


def write_whole(text: str, path: Path) -> None:
    """Write a text file, which is whole or not there, however this process ends."""
    part = path.with_suffix(".part")
    part.write_text(text, encoding="utf-8")
    part.replace(path)


def record(job: Job) -> Path:
    """Return the file that holds what a step's last run read and wrote."""
    return Path(job.log).with_suffix(".json")


def declaration(job: Job) -> str:
    """Return a checksum of a job's settings, among them that of its code, and of its file names."""
    declared = json.dumps([job.step, job.input, job.output, job.params], sort_keys=True)
    return hashlib.sha256(declared.encode()).hexdigest()


def is_same(path: str, changed_ns: int, size: int, checksum: str) -> bool:
    """Return whether a file is as it was seen; its contents count, not when they were written."""
    try:
        now = os.stat(path)
    except OSError:
        return False
    if (now.st_mtime_ns, now.st_size) == (changed_ns, size):
        return True
    return now.st_size == size and seen(path)[2] == checksum


def seen(path: str) -> Seen:
    """Return when a file was changed, its size and its checksum."""
    now = os.stat(path)
    return now.st_mtime_ns, now.st_size, checksum_of(path, now.st_mtime_ns)


@cache
def checksum_of(path: str, changed_ns: int) -> str:
    """Return the checksum of a file that was changed at a time [ns]."""
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
