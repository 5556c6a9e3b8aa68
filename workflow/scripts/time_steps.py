"""How long each step took: wall and processor time of all its jobs, and start-up in the latter."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pandas as pd

from ur5lib.tables import write_csv

SUMS = ["wall_s", "start_up_s", "cpu_s"]


def time_steps(input: Any, output: Any, params: Any) -> None:
    jobs = pd.DataFrame(map(job, input.benchmarks))
    steps = jobs.groupby("step", sort=False)
    times = steps[SUMS].sum()
    times.insert(0, "jobs", steps.size())
    times["max_rss_mb"] = steps["max_rss_mb"].max()
    times["first_end"], times["last_end"] = steps["end"].min(), steps["end"].max()
    write_csv(times.reset_index(), output.run_times, digits=6)


def job(benchmark: str) -> dict[str, object]:
    """Return one job: its step, times [s], largest memory [MB] and when it ended."""
    names, values = (line.split("\t") for line in Path(benchmark).read_text().splitlines())
    measured = dict(zip(names, map(float, values), strict=True))
    end = datetime.fromtimestamp(Path(benchmark).stat().st_mtime, UTC)
    return {
        "step": benchmark.partition("/benchmarks/")[2].split("/")[0].removesuffix(".tsv"),
        "wall_s": measured["s"],
        "start_up_s": measured["start_up_time"],
        "cpu_s": measured["cpu_time"],
        "max_rss_mb": measured["max_rss"],
        "end": end.isoformat(timespec="seconds").removesuffix("+00:00"),
    }
