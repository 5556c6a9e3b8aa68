"""How long the whole thesis study takes on two cores, its documents alone, and nothing to do.

It makes results/thesis anew from raw/thesis. Processor time hardly depends on what else runs on the
machine. Of a step, start-up is the processor time in which its jobs load Python and its packages.
"""

import resource
import subprocess
import sys
import time
from pathlib import Path

from ur5lib.tables import read_csv

STUDY = "workflow/studies/thesis.yaml"
RUN_TIMES = "results/thesis/tables/run_times.csv"
DOCUMENTS = [
    "draw_figures",
    "draw_filters",
    "draw_friction",
    "draw_models",
    "draw_calibration",
    "make_tables",
    "write_report",
]
RUNS = {
    "whole study, from raw files": ["--forceall"],
    "figures and documents": ["--forcerun", *DOCUMENTS],
    "nothing to do": [],
}


def main() -> None:
    """Print wall and processor time of each run, then of each step."""
    if not Path("raw/thesis").exists():
        sys.exit("raw/thesis is missing: fetch it by `ur5 fetch thesis`")
    print(f"{'on two cores':<30}{'wall':>10}{'processor':>12}")
    for name, options in RUNS.items():
        wall, processor = snakemake(*options)
        print(f"{name:<30}{wall:>8.1f} s{processor:>10.1f} s", flush=True)
    steps = read_csv(RUN_TIMES).sort_values("cpu_s", ascending=False)
    print("\n" + steps[["step", "jobs", "wall_s", "start_up_s", "cpu_s"]].to_string(index=False))


def snakemake(*options: str) -> tuple[float, float]:
    """Wall and processor time of a run [s]."""
    start, before = time.perf_counter(), processor_time()
    command = ["snakemake", "--quiet", "all", "--cores", "2", "--configfile", STUDY, *options]
    subprocess.run(command, check=True)
    return time.perf_counter() - start, processor_time() - before


def processor_time() -> float:
    """Of all processes that were started here and have ended [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
