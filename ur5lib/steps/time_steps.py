"""The duration of each step: wall and processor time of all its jobs, including start-up."""

import os
from datetime import UTC, datetime
from pathlib import Path

import pandas as pd

SUMMED_COLUMNS = ["wall_s", "start_up_s", "cpu_s"]


def time_steps(benchmarks: list[Path]) -> pd.DataFrame:
    """Return the rows of run_times.csv, one for each step; benchmarks: of all jobs."""
    jobs = pd.DataFrame(
        map(job, benchmarks), columns=["step", *SUMMED_COLUMNS, "max_rss_mb", "end"]
    )
    steps = jobs.groupby("step", sort=False)
    times = steps[SUMMED_COLUMNS].sum()
    times.insert(0, "jobs", steps.size())
    times["max_rss_mb"] = steps["max_rss_mb"].max()
    times["first_end"] = steps["end"].min().map(written)
    times["last_end"] = steps["end"].max().map(written)
    return times.reset_index()


def job(benchmark: Path) -> tuple[str, float, float, float, float, float]:
    """Return of a job its step, the values of SUMMED_COLUMNS [s], its largest memory [MB], and its
    end [s since 1970].
    """
    with open(benchmark) as file:
        names, values = (line.split("\t") for line in file.read().splitlines())
        end = os.fstat(file.fileno()).st_mtime
    of = dict(zip(names, map(float, values), strict=True))
    step = str(benchmark).partition("/benchmarks/")[2].split("/")[0].removesuffix(".tsv")
    return step, of["s"], of["start_up_time"], of["cpu_time"], of["max_rss"], end


def written(end: float) -> str:
    """Return a time [s since 1970] as UTC, ISO 8601."""
    return datetime.fromtimestamp(end, UTC).isoformat(timespec="seconds").removesuffix("+00:00")
