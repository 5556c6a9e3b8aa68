"""All estimators of the contact force on the same recordings, in one table.

Every estimator of ur5rivals/estimators learns its constants and its noise from the
contact-free recordings of the role `fit`, predicted by fits without their own path. It is then
scored against the force sensor, or, without one, by its (false) force on recordings of the role
`validate`.
"""

import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import pandas as pd
import torch

from ur5lib.errors import InputError
from ur5lib.tables import write_csv
from ur5rivals.estimator import Contender, Learned
from ur5rivals.estimators import all_estimators
from ur5rivals.estimators.ours import OURS
from ur5rivals.outside import ProtocolError, outside
from ur5rivals.run import Run
from ur5rivals.scores import EstimatesByName, free_rows, sensed_rows
from ur5rivals.study import StudyArm, read_arms
from ur5rivals.tables import tables

RESULTS_FOLDER = Path("results")
TABLE_FILE = RESULTS_FOLDER / "leaderboard.csv"


class LearnedContender(NamedTuple):
    """An estimator of the benchmark together with what it learnt from one arm's recordings."""

    estimator: Contender
    learned: Learned


def leaderboard(folders: Iterable[Path], place: str | None = None) -> str:
    """Return the tables of studies, in Markdown, and write them as one to TABLE_FILE.

    folders: results/<study>; place: of a further estimator, as in `outside`. Raises InputError if a
    study is not built, or the further estimator breaks the protocol.
    """
    chosen = contenders(place)
    table = scored([arm for folder in folders for arm in read_arms(folder)], chosen)
    write_csv(table, TABLE_FILE)
    return tables(table)


def contenders(place: str | None = None) -> list[Contender]:
    """Return all estimators, first the one from outside, if any."""
    rivals = all_estimators()
    return [*([outside(place, [rival.name for rival in rivals])] if place else []), *rivals]


def scored(arms: Sequence[StudyArm], chosen: Sequence[Contender]) -> pd.DataFrame:
    """Return the scores of estimators on the recordings of arms."""
    torch.set_num_threads(1)  # the same sums in the same order, and so the same numbers
    return pd.DataFrame([row for arm in arms for row in arm_rows(arm, chosen)])


def arm_rows(arm: StudyArm, chosen: Sequence[Contender]) -> Iterator[dict[str, Any]]:
    """Yield the rows of an arm's recordings, each with the estimator's learnt constants."""
    entries = {entry.estimator.name: entry for entry in learnt(arm, chosen)}
    for run in arm.sensed:
        for row in sensed_rows(run, estimates(entries, run), OURS):
            yield described(arm, entries[row["estimator"]]) | row
    for run in arm.free:
        for row in free_rows(run, estimates(entries, run)):
            yield described(arm, entries[row["estimator"]]) | row


def learnt(arm: StudyArm, chosen: Sequence[Contender]) -> Iterator[LearnedContender]:
    """Yield the estimators that can learn from this arm's recordings; print why others cannot."""
    for contender in chosen:
        print(f"{arm.study}, {arm.robot}: {contender.name}", file=sys.stderr, flush=True)
        try:
            yield LearnedContender(contender, contender.learn(arm.fit))
        except ProtocolError:
            raise
        except InputError as error:
            print(f"  left out: {error}", file=sys.stderr)


def estimates(entries: dict[str, LearnedContender], run: Run) -> EstimatesByName:
    """Return the estimates of a run by the estimators' names, without those for which the run lacks
    inputs.
    """
    by_name = {name: entry.learned.method(run) for name, entry in entries.items()}
    return {name: estimate for name, estimate in by_name.items() if estimate is not None}


def described(arm: StudyArm, entry: LearnedContender) -> dict[str, Any]:
    """Return the columns that identify a row: study, arm, source, and the estimator's properties
    and constants.
    """
    constants = entry.learned.constants.items()
    return {
        "study": arm.study,
        "robot": arm.robot,
        "source": entry.estimator.source,
        "causal": "yes" if entry.estimator.causal else "no",
        "latency_s": entry.learned.latency,
        "constants": ", ".join(f"{k} {v:g}" for k, v in constants if isinstance(v, float)),
    }
