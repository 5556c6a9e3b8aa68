"""All estimators of the contact force on simulated arms, seed by seed.

    python -m benchmarks.simulated_contacts [<seeds>] [--first <seed>] [--quick]

Each seed is an arm with friction of its own: two excitations and one motion along way-points with
pauses, without contact, and one recording along another path that is pushed in turn at the flange,
at a tool 15 cm beyond it and at the elbow. The workflow identifies links and friction from the
contact-free recordings and estimates the forces; nothing is taken from the truth but what the
estimates are compared with. Arms take turns; motion, forces, directions and noise are drawn by the
seed.

Each seed is written to results/simulated_contacts/<seed>.csv once it is done. A run that was
stopped, even by force, goes on with the seeds that lack, and so does one after an estimator was
added. Two runs may share the seeds: one up to 100, the other up to 200 with `--first 100`. At the
end, all seeds together are results/simulated_contacts.csv, the table of the page.
"""

import shutil
import sys
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from benchmarks.harness.drawn_studies import ARMS, FIT_SECONDS, motion_of, planned
from benchmarks.harness.options import options_of
from benchmarks.harness.pushes import EACH, PLACES, pushes
from benchmarks.harness.simulated import simulated_table
from benchmarks.harness.timing import timed
from benchmarks.leaderboard import QUICK
from benchmarks.study import snakemake
from ur5lib.finished import StudyFiles
from ur5lib.force.sensed_contact import CONTACT_FORCE, is_free
from ur5lib.records.friction import Friction
from ur5lib.records.signals import Signals
from ur5lib.study.reading import parse_study
from ur5lib.tables import read_csv, write_csv
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import interval_scores
from ur5rivals.board import RESULTS_FOLDER, estimates, learnt
from ur5rivals.estimators import all_estimators
from ur5rivals.estimators.published import ESTIMATORS as PUBLISHED
from ur5rivals.run import Estimate, Run
from ur5rivals.scores import known_to_all, masked
from ur5rivals.study import StudyArm, label_paths, read_run

SEEDS = 30
QUICK_SECONDS = 8.0
NEEDED = ("forces.parquet", "sensor.parquet")
LEFT_OUT = {own.name for own in PUBLISHED}  # the stand only imitates the controller
NORMAL = 1.96  # standard deviations of a 95 % band


def main() -> None:
    """Simulate and estimate the seeds that are missing; write and print the table of all."""
    options = options_of(__doc__)
    options.add_argument("seeds", nargs="?", type=int, help=f"up to which; by default {SEEDS}")
    options.add_argument("--first", type=int, default=0, help="the first of them, 0 by default")
    given = options.parse_args()
    torch.set_num_threads(1)  # the same sums in the same order, and so the same numbers
    names = [own.name for own in all_estimators() if own.name not in LEFT_OUT]
    folder, seeds, size = (
        RESULTS_FOLDER / "simulated_contacts",
        given.seeds or SEEDS,
        (EACH, FIT_SECONDS),
    )
    if given.quick:
        folder, seeds = folder.with_name("simulated_contacts_quick"), given.seeds or 1
        size = (1, QUICK_SECONDS)
        names = [own for own in names if own in QUICK]
    missing = [seed for seed in range(given.first, seeds) if not has(folder, seed, names)]
    for done, seed in enumerate(missing, start=1):
        spent, rows = timed(lambda: pd.DataFrame(seed_rows(seed, *size, names)))  # noqa: B023
        write_csv(rows, folder / f"{seed}.csv")
        left = len(missing) - done
        print(f"seed {seed}: {spent:.0f} s, {left} left", file=sys.stderr, flush=True)
    table = gathered(folder)
    write_csv(table, folder.with_suffix(".csv"))
    print(simulated_table(table))


def has(folder: Path, seed: int, names: Collection[str]) -> bool:
    """Return whether a seed's file exists with a row for each estimator."""
    path = folder / f"{seed}.csv"
    return path.exists() and {*names} <= {*read_csv(path)["estimator"]}


def gathered(folder: Path) -> pd.DataFrame:
    """Return the rows of all written seeds, in the order of the seeds."""
    paths = sorted(folder.glob("*.csv"), key=lambda path: int(path.stem))
    return pd.concat([read_csv(path) for path in paths], ignore_index=True)


def seed_rows(
    seed: int, each: int, seconds: float, names: Collection[str]
) -> Iterator[dict[str, Any]]:
    """Yield the figures of the estimators on a seed's pushed recording, without those that lack an
    input; seconds: of each fit recording.
    """
    contacts = pushes(seed, each)
    study = planned(seed, contacts, seconds)
    arm = ARMS[seed % len(ARMS)]
    clear(study)  # files of a killed run
    try:
        built(study)
        results = StudyFiles(RESULTS_FOLDER / study["study"])
        robot, friction = results.arm(arm), results.parameters(Friction, arm, "friction")
        plan = parse_study(study, study["study"])
        given = robot, friction, plan.settings.lowpass.currents.cutoff_hz
        each_run = [read_run(results, own, *given) for own in plan.recordings]
        time = results.record(Signals, results.recordings[-1]).time
    finally:
        clear(study)
    *free, pushed = label_paths([run for run in each_run if run is not None])
    known = StudyArm(study["study"], arm, free, [pushed], [])
    chosen = [own for own in all_estimators() if own.name in names]
    entries = {entry.estimator.name: entry for entry in learnt(known, chosen)}
    about = {"seed": seed, "arm": arm, "motion": motion_of(seed)["kind"]}
    found = estimates(entries, pushed)
    for row in figures(pushed, found, time, contacts):
        own = entries[row["estimator"]]
        causal = "yes" if own.estimator.causal else "no"
        yield about | {"causal": causal, "latency_s": own.learned.latency} | row
    yield from (about | {"estimator": name} for name in names if name not in found)


def clear(study: dict[str, Any]) -> None:
    """Remove a seed's recordings and results."""
    for folder in (RESULTS_FOLDER / study["study"], Path("raw", study["study"])):
        shutil.rmtree(folder, ignore_errors=True)


def built(study: dict[str, Any]) -> None:
    """Simulate, identify, and estimate forces, by the workflow."""
    names = [own["name"] for own in study["recordings"]]
    targets = [f"results/{study['study']}/recordings/{own}/{f}" for own in names for f in NEEDED]
    snakemake(study, "--cores", "1", "--", *targets)


def figures(
    run: Run, found: Mapping[str, Estimate], time: Array, contacts: list[dict[str, Any]]
) -> Iterator[dict[str, Any]]:
    """Yield errors in contact, by place, and the force shown while free; time: (N,) [s].

    Sums over samples, so that seeds can be pooled: square [N²], of the force's error vector; score
    [N] and inside: mean over the axes.
    """
    true = {place: force_at(place, time, contacts) for place in PLACES}
    common = known_to_all(found)
    touched = {
        place: common & (np.linalg.norm(own, axis=1) > CONTACT_FORCE) for place, own in true.items()
    }
    whole = np.hstack([sum(true.values()), np.zeros_like(time)[:, None].repeat(3, axis=1)])
    free = common & is_free(np.linalg.norm(whole[:, :3], axis=1), run.period)
    for name, estimate in found.items():
        own = masked(estimate, common)
        square = ((own.wrench - whole)[:, :3] ** 2).sum(axis=1)
        row: dict[str, Any] = {"estimator": name}
        for place, rows in touched.items():
            row |= {f"{place}_samples": rows.sum(), f"{place}_square": square[rows].sum()}
            row |= {f"{place}_force": (whole[rows, :3] ** 2).sum()}
            if own.std is not None:
                score = interval_scores(own.wrench, own.std, whole)[rows, :3].mean(axis=1)
                inside = (np.abs(own.wrench - whole) <= NORMAL * own.std)[rows, :3]
                row |= {f"{place}_score": score.sum(), f"{place}_inside": inside.mean(axis=1).sum()}
        yield row | {"free": float(np.median(np.linalg.norm(own.wrench[free, :3], axis=1)))}


def force_at(place: str, time: Array, contacts: list[dict[str, Any]]) -> Array:
    """Return the force (N, 3) [N] on a place: pushes rise and fall like the square of a sine."""
    force = np.zeros((len(time), 3))
    for contact in contacts:
        if (contact["link"], contact["point"]) == PLACES[place]:
            since = (time - contact["start_s"]) / contact["seconds"]
            swell = np.where((since > 0) & (since < 1), np.sin(np.pi * since) ** 2, 0.0)
            force += swell[:, None] * contact["force"]
    return force


if __name__ == "__main__":
    main()
