"""All estimators of the contact force on the same recordings, in one table.

    python -m benchmarks.leaderboard [<study> ...] [--page] [--quick] [--estimator <module:Class>]

Takes results/<study> as built; by default `thesis` and `ur10e`. Every estimator of
benchmarks/estimators learns its constants and its noise from the contact-free recordings of the
role `fit`, predicted by fits without their own path. It is then scored against the force sensor,
or, without one, by the force that it shows on recordings of the role `validate`. Prints the tables
and writes results/leaderboard.csv; `--page` writes docs/benchmark.md, too, with the tables of
`simulated_contacts`, `contact_link`, `current_prediction` and `learning_curve` as these left them
in results/, or as the page already has them.
`--estimator` adds one that is not among them, and the page is then results/benchmark.md.
`--quick` takes four estimators: it only shows that it runs.
"""

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import torch

from benchmarks.estimators import all_estimators
from benchmarks.estimators.ours import OURS
from benchmarks.harness import page
from benchmarks.harness.estimator import Estimator, Learned
from benchmarks.harness.options import built, study_options
from benchmarks.harness.outside import outside
from benchmarks.harness.run import Run
from benchmarks.harness.scores import Estimates, free_rows, sensed_rows
from benchmarks.harness.sections import detection_tables, sections
from benchmarks.harness.study import Arm, read_arms
from ur5lib.errors import InputError
from ur5lib.tables import write_csv, write_text

QUICK = (OURS, "zero", "least squares", "momentum observer")
RESULTS = Path("results")
PAGE = Path(__file__).parents[1] / "docs" / "benchmark.md"
BESIDE = RESULTS / "benchmark.md"  # with an estimator from outside


class Entry(NamedTuple):
    """An estimator with what it learnt from one arm's recordings."""

    estimator: Estimator
    learned: Learned


def main() -> None:
    """Learn, score, print and write."""
    options = study_options(__doc__)
    options.add_argument("--page", action="store_true", help="write docs/benchmark.md as well")
    options.add_argument("--estimator", help="package.module:Class, beside the rivals")
    given = options.parse_args()
    torch.set_num_threads(1)  # the same sums in the same order, and so the same numbers
    chosen = [own for own in all_estimators() if not given.quick or own.name in QUICK]
    if given.estimator:
        chosen.insert(0, outside(given.estimator, [own.name for own in all_estimators()]))
    folders = built(RESULTS / name for name in given.studies)
    arms = [arm for folder in folders for arm in read_arms(folder)]
    table = pd.DataFrame([row for arm in arms for row in arm_rows(arm, chosen)])
    write_csv(table, RESULTS / "leaderboard.csv")
    print(page.tables(table))
    if given.page:
        further = sections(RESULTS) | {"detections": detection_tables(folders)}
        text, names = page.page(table, arms, further), [*table["estimator"].unique()]
        text = page.with_kept(text, PAGE.read_text(), further, names)
        if given.estimator:
            write_text(text.replace("](methods.md", "](../docs/methods.md"), BESIDE)
        else:
            write_text(text, PAGE)


def arm_rows(arm: Arm, chosen: list[Estimator]) -> Iterator[dict[str, Any]]:
    """Yield the rows of an arm's recordings, each with what the estimator learnt."""
    entries = {entry.estimator.name: entry for entry in learnt(arm, chosen)}
    for run in arm.sensed:
        for row in sensed_rows(run, estimates(entries, run), OURS):
            yield described(arm, entries[row["estimator"]]) | row
    for run in arm.free:
        for row in free_rows(run, estimates(entries, run)):
            yield described(arm, entries[row["estimator"]]) | row


def learnt(arm: Arm, chosen: list[Estimator]) -> Iterator[Entry]:
    """Yield the estimators that this arm's recordings suffice for; print why another does not."""
    for own in chosen:
        print(f"{arm.study}, {arm.robot}: {own.name}", file=sys.stderr, flush=True)
        try:
            yield Entry(own, own.learn(arm.fit))
        except InputError as error:
            print(f"  left out: {error}", file=sys.stderr)


def estimates(entries: dict[str, Entry], run: Run) -> Estimates:
    """Return the estimates of a run by name, without those that it lacks the inputs of."""
    found = {name: entry.learned.method(run) for name, entry in entries.items()}
    return {name: own for name, own in found.items() if own is not None}


def described(arm: Arm, entry: Entry) -> dict[str, Any]:
    """Return the columns that say what a row is about."""
    constants = entry.learned.constants.items()
    return {
        "study": arm.study,
        "robot": arm.robot,
        "source": entry.estimator.source,
        "causal": "yes" if entry.estimator.causal else "no",
        "latency_s": entry.learned.latency,
        "constants": ", ".join(f"{k} {v:g}" for k, v in constants if isinstance(v, float)),
    }


if __name__ == "__main__":
    main()
