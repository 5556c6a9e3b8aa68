"""How long a study takes on two cores: whole, changed a little, finished, and as it grows.

It makes the study's results anew; by default those of config.yaml, which simulates. Processor time
hardly depends on what else runs on the machine. Of a step, start-up is the processor time in which
its jobs load Python and its packages. `--growth 50 100` adds so many copies of the last recording,
under other names, and prints the time for each of them.
"""

import atexit
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any, NamedTuple

import yaml

from benchmarks.harness.options import options_of
from ur5lib.tables import read_csv

COPY, FILES = "copy_{}", Path("raw/benchmark")  # a copy's name, and the folder of its files
RUNS: dict[str, tuple[int, list[str]]] = {  # copies of the last recording, options of Snakemake
    "whole study, from raw files": (0, ["--forceall"]),
    "one more recording": (1, []),
    "without it again": (0, []),
    "a changed caption": (0, ["--forcerun", "write_report"]),
    "nothing to do": (0, []),
}


def main() -> None:
    """Print wall and processor time of each run, then of each step, then by copies."""
    atexit.register(shutil.rmtree, FILES, ignore_errors=True)
    options = options_of(__doc__)
    options.add_argument("--growth", type=int, nargs="*", default=[], help="numbers of copies")
    options.add_argument("study", nargs="?", default="config.yaml", help="its configuration")
    given = options.parse_args()
    plan = ["--dry-run"] if given.quick else []
    study = yaml.safe_load(Path(given.study).read_text(encoding="utf-8"))
    print(f"{'on two cores':<30}{'wall':>10}{'processor':>12}")
    for name, (copies, settings) in RUNS.items():
        wall, processor, _ = snakemake(with_copies(study, copies), *settings, *plan)
        print(f"{name:<30}{wall:>8.1f} s{processor:>10.1f} s", flush=True)
    show_steps(Path("results") / study["study"] / "tables" / "run_times.csv")
    for copies in given.growth:
        grown = with_copies(study, copies) | {"study": f"{study['study']}_and_{copies}"}
        wall = snakemake(grown, *plan).wall
        print(f"{copies} copies: {wall:.0f} s, {wall / copies:.2f} s each", flush=True)


def with_copies(study: dict[str, Any], count: int) -> dict[str, Any]:
    """Return a study with copies of its last recording, as recordings with a contact."""
    last = study["recordings"][-1]
    copies = [last | {"name": COPY.format(k), "role": "contact"} for k in range(count)]
    for copy in copies:
        if "folder" in copy:
            copy["folder"] = str(FILES / copy["name"])
            shutil.copytree(last["folder"], copy["folder"], dirs_exist_ok=True)
    return study | {"recordings": [*study["recordings"], *copies]}


def show_steps(times: Path) -> None:
    """Print the time and the largest memory of each step."""
    if times.exists():
        steps = read_csv(times).sort_values("cpu_s", ascending=False)
        shown = ["step", "jobs", "wall_s", "start_up_s", "cpu_s", "max_rss_mb"]
        print("\n" + steps[shown].to_string(index=False), flush=True)


class Used(NamedTuple):
    """A run's wall time [s], processor time [s] and memory of the largest process [GB]."""

    wall: float
    processor: float
    memory: float


def snakemake(study: dict[str, Any], *options: str) -> Used:
    """Run a study; return time and memory, including the processes that it starts."""
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file, tempfile.TemporaryFile() as log:
        yaml.safe_dump(study, file, sort_keys=False)
        file.flush()
        start = time.perf_counter()
        command = ["snakemake", "--cores", "2", "--configfile", file.name, *options]
        run = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT)
        _, status, used = os.wait4(run.pid, 0)
        run.returncode = os.waitstatus_to_exitcode(status)
        wall = time.perf_counter() - start
        if run.returncode:
            log.seek(0)
            sys.exit(f"{log.read().decode()}\nthis run failed (status {run.returncode})")
    return Used(wall, used.ru_utime + used.ru_stime, used.ru_maxrss / 1e6)


if __name__ == "__main__":
    main()
