"""How long a whole study takes on two cores, its documents alone, and nothing to do.

It makes the study's results anew; by default those of config.yaml, which simulates. Processor time
hardly depends on what else runs on the machine. Of a step, start-up is the processor time in which
its jobs load Python and its packages.
"""

import argparse
import resource
import subprocess
import sys
import time
from pathlib import Path

import yaml

from ur5lib.tables import read_csv

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
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--quick", action="store_true", help="plan the runs, but do none")
    options.add_argument("study", nargs="?", default="config.yaml", help="its configuration")
    given = options.parse_args()
    plan = ["--dry-run"] if given.quick else []
    print(f"{'on two cores':<30}{'wall':>10}{'processor':>12}")
    for name, settings in RUNS.items():
        wall, processor = snakemake(given.study, *settings, *plan)
        print(f"{name:<30}{wall:>8.1f} s{processor:>10.1f} s", flush=True)
    name = yaml.safe_load(Path(given.study).read_text(encoding="utf-8"))["study"]
    times = Path("results") / name / "tables" / "run_times.csv"
    if given.quick and not times.exists():
        return
    steps = read_csv(times).sort_values("cpu_s", ascending=False)
    print("\n" + steps[["step", "jobs", "wall_s", "start_up_s", "cpu_s"]].to_string(index=False))


def snakemake(study: str, *options: str) -> tuple[float, float]:
    """Return wall and processor time of a run [s]."""
    start, before = time.perf_counter(), processor_time()
    command = ["snakemake", "--cores", "2", "--configfile", study, *options]
    pipe, both = subprocess.PIPE, subprocess.STDOUT
    done = subprocess.run(command, text=True, stdout=pipe, stderr=both, check=False)
    if done.returncode:
        sys.exit(f"{done.stdout}\nthis run failed (status {done.returncode})")
    return time.perf_counter() - start, processor_time() - before


def processor_time() -> float:
    """Return the processor time of all ended child processes [s]."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


if __name__ == "__main__":
    main()
