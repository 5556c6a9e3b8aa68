"""What thousands of recordings cost: runs of one arm over two years, taken by patterns.

The arm repeats its programs by day; in some runs, something pushes it. Its motors are warmer in
summer and warm up in each run, and in one month the Coulomb friction of one joint rises. It is
simulated fresh and worn, cold and warm; each run is a mixture of these four, since a stiff
controller makes torques nearly linear in friction, and has noise of its own. Printed are the time,
the processor time and the memory of the largest process of a study on two cores, by the number of
runs; making them does not count. Results remain in results/benchmark_many_runs_<number>.
"""

import shutil
from collections.abc import Iterator, Sequence
from concurrent.futures import Executor, ProcessPoolExecutor
from dataclasses import replace
from datetime import date, timedelta
from functools import cache
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.harness.options import options_of
from benchmarks.study import show_steps, snakemake
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.stand.controller_channels import frames
from ur5lib.stand.device_files import write_files
from ur5lib.stand.faults import apply_faults, draw_faulty_frames
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import Experiment, as_rows, perform, step_times
from ur5lib.stand.sensors import wrist_channels
from ur5lib.stand.simulate import WRITERS
from ur5lib.tables import read_csv

ARM, SECONDS, CYCLE = "ur10e", 20.0, 0.01  # s
START, DAYS = date(2024, 1, 1), 730
WORN_JOINT, WEAR = 3, 0.25  # share by which its Coulomb friction rises
WORN_FROM, WORN_AFTER = 13 / 24, 14 / 24  # of the time: within the 14th of 24 months
EXTREMES = 10.0, 50.0  # °C; range of the motors' temperature
REFERENCES, PUSHED_EVERY = 4, 20  # fit runs at the start; every twentieth run has a contact
WAY_POINTS = [
    [[0.5, -1.6, 1.6, -1.5, 1.5, 0.3], [-0.6, -1.1, 1.2, -1.9, 2.2, -0.8]],
    [[1.3, -2.0, 2.0, -0.9, 0.9, 1.2], [0.2, -1.3, 0.9, -1.0, 1.2, -0.4]],
]
FOURIER = {"kind": "fourier", "period_s": 10, "harmonics": 5}
PROGRAMS = [*({"kind": "movej", "way_points": points} for points in WAY_POINTS), FOURIER]
PUSH = {"kind": "push", "seconds": 3, "force": [40, -30, 20]}
ROLES = {"reference": "fit", "daily": "validate", "pushed": "contact"}  # by the files' names


def main() -> None:
    """Print time and memory of each run of the study, for each number of recordings."""
    options = options_of(__doc__)
    options.add_argument("--damaged", type=float, default=0.0, help="share of files, e.g. 0.01")
    options.add_argument("numbers", type=int, nargs="*", help="of runs; default: 60 240")
    given = options.parse_args()
    plan = ["--dry-run"] if given.quick else []
    seconds = 2.0 if given.quick else SECONDS
    numbers = [REFERENCES + 2] if given.quick else given.numbers or [60, 240]
    print(f"{'on two cores':<28}{'runs':>6}{'wall':>10}{'processor':>12}{'memory':>10}")
    with ProcessPoolExecutor(1) as maker:
        for number in numbers:
            measure(number, seconds, given.damaged, plan, maker)


def measure(
    number: int, seconds: float, damaged: float, plan: Sequence[str], maker: Executor
) -> None:
    """Print time and memory of each run of a study with this number of recordings.

    seconds: of a recording; plan: further options of Snakemake; maker: another process that makes
    the recordings, since a process's memory also counts for the processes that it starts.
    """
    name = f"benchmark_many_runs_{number}"
    folder = Path("raw", name)
    shutil.rmtree(folder, ignore_errors=True)
    shutil.rmtree(Path("results", name), ignore_errors=True)
    maker.submit(write_runs, folder, number, damaged, seconds).result()
    changes: dict[str, tuple[str, list[str]]] = {
        "planned": ("", ["--dry-run"]),
        "whole study": ("", []),
        "nothing to do": ("", []),
        "a changed caption": ("", ["--forcerun", "write_report"]),
        "one more run": ("daily", []),
        "one more run to fit": ("reference", []),
    }
    for what, (kind, chosen) in changes.items():
        if kind:
            maker.submit(write_run, folder, kind, number, DAYS - 1, seconds).result()
        used = snakemake(study(name, folder), *chosen, *plan)
        times = f"{used.wall:>8.1f} s{used.processor:>10.1f} s{used.memory:>7.2f} GB"
        print(f"{what:<28}{number:>6}{times}", flush=True)
    tables = Path("results", name, "tables")
    show_steps(tables / "run_times.csv")
    show_changes(tables / "health_changes.csv")


def show_changes(file: Path) -> None:
    """Print the changes that the study found, and the simulated wear."""
    first, last = (START + timedelta(DAYS * share) for share in (WORN_FROM, WORN_AFTER))
    print(f"\nput in: Coulomb friction of joint {WORN_JOINT} +{WEAR:.0%}, {first} to {last}")
    if file.exists():
        changes = read_csv(file)
        changes["share"] = changes["size"] / changes["before"]
        shown = ["joint", "quantity", "kind", "first", "last", "share", "chance"]
        print(changes[shown].to_string(index=False, float_format="%.3f"), flush=True)


def study(name: str, folder: Path) -> dict[str, Any]:
    """Return the configuration of a study: a pattern for each role."""
    entry = {"robot": ARM, "format": "rtde-csv", "folder": str(folder)}
    recordings = [
        entry | {"name": "run", "file": f"*/{kind}_*.csv", "role": role}
        for kind, role in ROLES.items()
    ]
    return {"study": name, "title": "Runs of one arm over two years", "recordings": recordings}


def write_runs(folder: Path, number: int, damaged: float, seconds: float) -> list[Path]:
    """Write runs into a folder for each month; return the damaged files, a share of all."""
    files = [write_run(folder, *one, seconds) for one in runs(number)]
    torn = files[REFERENCES + 1 :: round(1 / damaged)] if damaged else []
    for file in torn:
        file.write_text("This is a letter, not a recording.\n", encoding="utf-8")
    return torn


def runs(number: int) -> Iterator[tuple[str, int, int]]:
    """Yield the kind, number and day of each run."""
    for k in range(number):
        kind = "pushed" if k % PUSHED_EVERY == REFERENCES else "daily"
        yield "reference" if k < REFERENCES else kind, k, k * DAYS // number


def write_run(folder: Path, kind: str, number: int, day: int, seconds: float) -> Path:
    """Write a run; return its file. The same arguments give the same bytes."""
    random = np.random.default_rng(number)
    season = 30.0 - 4.0 * np.cos(2 * np.pi * day / 365) + random.normal()
    warm = season, season + random.uniform(0.0, 6.0)
    worn = float(np.interp(day / DAYS, [WORN_FROM, WORN_AFTER], [0.0, 1.0]))
    program = number % (REFERENCES if kind == "reference" else len(PROGRAMS))
    run = mixture(kind, program, worn, warm, seconds)
    sent = frames(run, CYCLE, random)
    sent = sent.assign(**wrist_channels(run, sent, random))
    whole = draw_faulty_frames(run.plan.faults, len(sent), random)
    (text,) = WRITERS["rtde-csv"](apply_faults(sent, whole, random), {}, run.plan).values()
    on = START + timedelta(day)
    file = Path(f"{on:%Y-%m}", f"{kind}_{on}_{number:04d}.csv")
    write_files({str(file): text}, folder, torn=False)
    return folder / file


def mixture(
    kind: str, program: int, worn: float, warm: tuple[float, float], seconds: float
) -> Experiment:
    """Return a run; worn: 0 to 1; warm: the motors' temperature at its start and end [°C]."""
    first = extreme(kind, program, seconds, worn=False, hot=False)
    plan = first.plan.model_copy(update={"temperature_c": warm})
    share = np.interp(plan.temperature(step_times(len(first.motion))), EXTREMES, [0.0, 1.0])
    mixed = np.zeros_like(as_rows(first.motion))
    wears, heats = (1 - worn, worn), (1 - share, share)
    for is_worn, is_hot in product((False, True), repeat=2):
        if wears[is_worn]:
            states = extreme(kind, program, seconds, is_worn, is_hot).motion
            mixed += wears[is_worn] * heats[is_hot][:, None] * as_rows(states)
    return replace(first, plan=plan, motion=mixed.view(first.motion.dtype)[:, 0])


@cache
def extreme(kind: str, program: int, seconds: float, worn: bool, hot: bool) -> Experiment:
    """Return a run of a fresh or worn arm, with cold or hot motors of constant temperature."""
    motion = FOURIER | {"draw": program} if kind == "reference" else PROGRAMS[program]
    coulomb = np.ones(6)
    coulomb[WORN_JOINT - 1] += WEAR * worn
    plan = SimulatedRecording.model_validate(
        {
            "trajectory": motion,
            "seconds": seconds,
            "temperature_c": [EXTREMES[hot]] * 2,
            "coulomb_factor": [*coulomb],
            "contacts": [PUSH | {"start_s": 0.4 * seconds}] if kind == "pushed" else [],
            "wrist_sensor": {},
        }
    )
    return perform(load_robot(robot_path(ARM)), plan, np.random.default_rng(program))


if __name__ == "__main__":
    main()
