"""Recordings that cannot be read and are left out, so that the rest of a study goes on."""

import json
from collections.abc import Container, Iterable, Mapping
from dataclasses import replace
from pathlib import Path

from ur5lib.steps.job import Job, Names, paths
from ur5lib.steps.upkeep import record, write_whole

STAMPS = "batches"  # the folder of the stamps in that of the results


def write_stamp(stamp: str, checksum: str, absent: Mapping[str, str]) -> None:
    """Write that a batch has passed a level: the checksum of its results, and what was left out."""
    write_whole(json.dumps([checksum, absent], indent=1), Path(stamp))


def left_out(files: Iterable[str]) -> dict[str, str]:
    """Return the recordings that were left out, each with the reason, by the stamps among files."""
    stamps = (Path(file) for file in files)
    stamps = (path for path in stamps if path.parts[2:3] == (STAMPS,) and path.exists())
    found: dict[str, str] = {}
    for path in stamps:
        found |= json.loads(path.read_text(encoding="utf-8"))[1]
    return found


def without(job: Job, absent: Container[str]) -> Job:
    """Return a job without the files and settings of recordings that were left out.

    Settings that are lists as long as `recordings` have one value for each of these.
    """
    listed = job.params.get("recordings", [])
    kept = [k for k, name in enumerate(listed) if name not in absent]
    params = {
        name: [value[k] for k in kept]
        if isinstance(value, list) and len(value) == len(listed)
        else value
        for name, value in job.params.items()
    }
    read = {name: remaining(files, absent) for name, files in job.input.items()}
    return replace(job, input=Names(read), params=Names(params))


def remaining(files: str | list[str], absent: Container[str]) -> str | list[str]:
    """Return files without those of recordings that were left out; a single one as it is."""
    if isinstance(files, str):
        return files
    return [path for path in files if name_of(path, absent) is None]


def name_of(path: str, names: Container[str]) -> str | None:
    """Return the recording that a file of the results is of, if it is among some."""
    match Path(path).parts[2:]:
        case ["recordings" | "figures", name, _] if name in names:
            return name
        case ["logs" | "benchmarks", _, file] if (name := file.rpartition(".")[0]) in names:
            return name
    return None


def reason_to_skip(job: Job, absent: Mapping[str, str]) -> str:
    """Return why the recording that a job is of was left out; empty if it was not."""
    single = (str(path) for path in job.input.values() if isinstance(path, str))
    found = (name_of(path, absent) for path in single)
    return next((absent[name] for name in found if name), "")


def delete_results(chain: Iterable[Job]) -> None:
    """Delete what earlier runs made of a recording that is left out."""
    for job in chain:
        for path in [*map(Path, paths(job.output)), record(job)]:
            path.unlink(missing_ok=True)
