"""What changes of friction are found between dates, seed by seed, and how often falsely.

For each seed, an arm on the virtual test stand is recorded once on each of twenty dates, along
three paths in turn. The viscous friction of one joint grows slowly, the Coulomb friction of another
jumps on one date. Counted are the changes that are found with their kind, whether their intervals
hold the true size and date, and the changes of whatever did not change.
"""

import tempfile
from datetime import date, timedelta
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import torch

from benchmarks.harness.options import asked
from benchmarks.stand_seeds import CURRENTS, MOTION, Taken, fitted_map, taken
from ur5lib.identification.current_samples import Smoother
from ur5lib.identification.samples import passed
from ur5lib.records.arm_state import JointChange
from ur5lib.steps.judge_joints import checkup
from ur5lib.steps.track_health import health_of as tracked

SEEDS, DATES, SECONDS = 20, 20, 20.0
PATHS, APART = 3, 3  # days between dates
START = date(2026, 3, 3)
GROWTH, JUMP = 0.2, 0.15  # of the usual friction
DRIFTING, JUMPING = 2, 4  # joints
TRUTH = {("viscous", DRIFTING): ("drift", GROWTH), ("coulomb", JUMPING): ("jump", JUMP)}


def main() -> None:
    """Print what was found, and how much of it is false."""
    seeds, quick = asked(__doc__, SEEDS)
    dates, length = (6, 5.0) if quick else (DATES, SECONDS)
    torch.set_num_threads(1)
    found = [row | {"seed": seed} for seed in range(seeds) for row in judged(seed, dates, length)]
    print(f"{seeds} seeds, {dates} dates, a recording of {length:g} s on each")
    columns = ["seed", "quantity", "joint", "kind", "size", "true", "size holds", "date holds"]
    rows = pd.DataFrame(found, columns=columns)
    if len(rows):
        print(rows.to_string(index=False, float_format="%.3f", na_rep="–"))
    true = rows.dropna(subset="true")
    for kind, part in true.groupby("kind"):
        holds = part[["size holds", "date holds"]].eq("yes").sum()
        print(f"{kind}: found in {len(part)} of {seeds} seeds, {holds.to_dict()}")
    follows = (rows["quantity"] == "noise") & rows["joint"].isin([DRIFTING, JUMPING])
    false = rows[rows["true"].isna() & ~follows]  # noise follows friction, whose reversals are fast
    print(f"false changes: {len(false)} in {seeds} seeds")


def judged(seed: int, dates: int, seconds: float) -> list[dict[str, Any]]:
    """Return the changes that are found, as shares of the value before, beside the true ones."""
    days = [START + timedelta(APART * k) for k in range(dates)]
    with tempfile.TemporaryDirectory() as folder:
        recordings = [
            taken(plan, Path(folder, str(k))) for k, plan in enumerate(plans(seed, dates, seconds))
        ]
        changes = health_of(recordings, days)
    return [beside_truth(change, days[dates // 2]) for change in changes]


def plans(seed: int, dates: int, seconds: float) -> list[dict[str, Any]]:
    """Return a recording for each date: paths repeat, noise does not."""
    plans = []
    for k in range(dates):
        coulomb, viscous = np.ones(6), np.ones(6)
        viscous[DRIFTING - 1] += GROWTH * k / (dates - 1)
        coulomb[JUMPING - 1] += JUMP * (k >= dates // 2)
        factors = {"coulomb_factor": [*coulomb], "viscous_factor": [*viscous]}
        trajectory = MOTION | {"draw": 10 * seed + k % PATHS}
        plans.append(factors | {"trajectory": trajectory, "seed": 1000 * seed + k})
    return [plan | {"seconds": seconds} for plan in plans]


def health_of(recordings: list[Taken], days: list[date]) -> list[JointChange]:
    """Return the changes of an arm's health, with the arm's fit from the first of each path."""
    fit = fitted_map(recordings[:PATHS]).fit
    smooth = Smoother(*CURRENTS)
    checkups = [
        checkup(own.record, smooth, fit, day, own.intake.quality)
        for own, day in zip(recordings, days, strict=True)
    ]
    return tracked(checkups, [passed(own.record) for own in recordings]).changes


def beside_truth(change: JointChange, jumped: date) -> dict[str, Any]:
    """Return a change with what is true of it; nothing is where nothing changed."""
    kind, true = TRUTH.get((change.quantity, change.joint), ("", np.nan))
    relative = {name: getattr(change, name) / change.before for name in ("size", "low", "high")}
    row: dict[str, object] = {"quantity": change.quantity, "joint": change.joint}
    row |= {"kind": change.kind} | relative
    if change.kind != kind:
        return row | {"true": np.nan}
    first, last = map(date.fromisoformat, (change.first, change.last))
    dated = kind == "drift" or first < jumped <= last
    held = relative["low"] < true < relative["high"]
    told = {"size holds": held, "date holds": dated}
    return row | {"true": true} | {name: "yes" if holds else "no" for name, holds in told.items()}


if __name__ == "__main__":
    main()
