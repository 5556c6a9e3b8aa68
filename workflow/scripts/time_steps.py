"""How long each step took: wall and processor time of all its jobs, and start-up in the latter."""

from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import pandas as pd

from ur5lib.steps import processor_times, run_step
from ur5lib.tables import write_csv


def time_steps(input: Any, output: Any, params: Any) -> None:
    jobs = pd.DataFrame(map(job, input.benchmarks, input.logs))
    steps = jobs.groupby("step", sort=False)
    times = steps[["wall_s", "start_up_s", "cpu_s"]].sum()
    times.insert(0, "jobs", steps.size())
    times["first_end"], times["last_end"] = steps["end"].min(), steps["end"].max()
    write_csv(times.reset_index(), output.run_times, digits=6)


def job(benchmark: str, log: str) -> dict[str, object]:
    """Return one job: its step, times [s] and when it ended."""
    names, values = (line.split("\t") for line in Path(benchmark).read_text().splitlines())
    measured = dict(zip(names, values, strict=True))
    start_up, whole = processor_times(log)
    end = datetime.fromtimestamp(Path(benchmark).stat().st_mtime, UTC)
    return {
        "step": log.partition("/logs/")[2].split("/")[0].removesuffix(".log"),
        "wall_s": float(measured["s"]),
        "start_up_s": start_up,
        "cpu_s": whole,
        "end": end.isoformat(timespec="seconds").removesuffix("+00:00"),
    }


if __name__ == "__main__":
    run_step(time_steps, snakemake)  # type: ignore[name-defined]  # noqa: F821
