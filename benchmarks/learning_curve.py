"""What a study knows after 0, 1, 2, 3, 5 and all recordings to fit on, and on days left out.

    python -m benchmarks.learning_curve [<study> ...] [--forces] [--page] [--quick]

Takes results/<study> as built, by default thesis and ur10e. Subsets of the recordings to fit on are
drawn with a seed; each fit is judged on the recordings without contact that share neither path nor
day with it (path alone where the study has one day). Of the motor currents below the study's
low-pass: the error, and the share inside the 95 % band, for the fit with typical friction as known
before it, for the same without, and for least squares. Then each day is left out, where
a study has several: currents inside the band of the fit to other days, and the torque constants of
the day's own fit beside those of the others. `--forces` does instead, by the workflow's own
steps, forces where a force sensor felt contacts, and alarms on recordings without contact. Writes
results/learning_curve.csv, days_left_out.csv and learning_curve_forces.csv, from which
`make leaderboard` takes its sections. `--page` draws docs/learning_curve.svg, too. `--quick` draws
one subset.
"""

import tempfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace
from itertools import chain, combinations
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.current_prediction import Known, read_arms
from benchmarks.few_recordings import in_contact_of, touched_of
from benchmarks.harness.curve import (
    MODELS,
    days_table,
    forces_table,
    learning_figure,
    learning_table,
)
from benchmarks.harness.options import built, study_options
from benchmarks.leave_out import Fold, read_study, refusal, unseen
from ur5lib.finished import FinishedStudy
from ur5lib.identification.current_regression import expected_fit, fit_currents
from ur5lib.identification.current_samples import prior_of
from ur5lib.identification.currents import CurrentFit, band, parameters, predict
from ur5lib.identification.samples import Record, record_days
from ur5lib.identification.validation import baseline_current, least_squares_coefficients
from ur5lib.tables import read_csv, write_csv
from ur5lib.timeseries.arrays import Array

RESULTS = Path("results")
FIGURE = Path(__file__).parents[1] / "docs" / "learning_curve.svg"
SIZES = (1, 2, 3, 5)
DRAWS = 8
DRAWS_OF_FORCES = 5
OURS, ALONE, LEAST_SQUARES = MODELS
Subset = tuple[int, ...]  # places among an arm's recordings


def main() -> None:
    """Write and print the tables."""
    options = study_options(__doc__)
    options.add_argument("--forces", action="store_true", help="forces and alarms instead")
    options.add_argument("--page", action="store_true", help=f"draw docs/{FIGURE.name}")
    given = options.parse_args()
    draws = (1, 1) if given.quick else (DRAWS, DRAWS_OF_FORCES)
    folders = built(RESULTS / name for name in given.studies)
    arms = [dated(arm) for folder in folders for arm in read_arms(folder)]
    if given.forces:
        finish("learning_curve_forces", forces_table, with_forces(arms, draws[1]))
        return
    judged_fits = (judged(arm, *own) for arm in arms for own in subsets(arm, draws[0]))
    finish("learning_curve", learning_table, chain.from_iterable(judged_fits))
    if given.page:
        figure = learning_figure(read_csv(RESULTS / "learning_curve.csv"))
        figure.savefig(FIGURE, metadata={"Date": None})
    finish("days_left_out", days_table, chain.from_iterable(map(days_left_out, arms)))


def with_forces(arms: Sequence[Known], draws: int) -> Iterator[dict[str, Any]]:
    """Yield what `forces_of` finds of each subset of each arm."""
    for arm in arms:
        for own in subsets(arm, draws):
            yield from forces_of(arm, *own)


def finish(name: str, table: Callable[[pd.DataFrame], str], rows: Iterable[dict[str, Any]]) -> None:
    """Write rows to a file of results, and print their table; nothing of no rows."""
    found = pd.DataFrame(rows)
    if len(found):
        write_csv(found, RESULTS / f"{name}.csv")
        print(table(found), flush=True)


def dated(arm: Known) -> Known:
    """Return an arm whose recordings have their dates."""
    study = FinishedStudy(arm.folder.parents[1])
    days = [str(study.recording(own.record.name).date or "") for own in arm.runs]
    pairs = zip(arm.runs, days, strict=True)
    return replace(
        arm, runs=[replace(own, record=replace(own.record, day=day)) for own, day in pairs]
    )


def records(arm: Known, places: Sequence[int]) -> list[Record]:
    """Return some recordings of an arm."""
    return [arm.runs[place].record for place in places]


def apart(arm: Known, chosen: Sequence[int]) -> list[int]:
    """Return the recordings that share neither path nor, of several days, day with some."""
    day, paths = record_days([own.record for own in arm.runs]), {arm.paths[n] for n in chosen}
    days = {day[n] for n in chosen} if len(np.unique(day)) > 1 else set()
    return [n for n in range(len(day)) if arm.paths[n] not in paths and day[n] not in days]


def subsets(arm: Known, draws: int) -> Iterator[tuple[str, Subset, list[int]]]:
    """Yield how many recordings are fitted, which, and those that judge the fit.

    Of all: what is left when each recording's path and day is left out.
    """
    fit = [n for n, own in enumerate(arm.runs) if own.fitted]
    yield "0", (), [*range(len(arm.runs))]
    for size in SIZES:
        every = [*combinations(fit, size)] if size < len(fit) else []
        order = np.random.default_rng(0).permutation(len(every))
        left = ((every[n], apart(arm, every[n])) for n in order)
        kept = [(chosen, tested) for chosen, tested in left if tested]
        yield from ((str(size), *own) for own in kept[:draws])
    whole: dict[Subset, list[int]] = {}
    for n in range(len(arm.runs)):
        others = {*apart(arm, [n])}
        whole.setdefault(tuple(m for m in fit if m in others), []).append(n)
    yield from (("all", chosen, tested) for chosen, tested in [*whole.items()][:draws])


def fits(arm: Known, chosen: Subset) -> dict[str, CurrentFit]:
    """Return the fit to some recordings with typical friction as known before, and without."""
    prior = prior_of(arm.robot, [arm.runs[n].ratio for n in chosen])
    if not chosen:
        return {OURS: expected_fit(prior)}
    seen = records(arm, chosen)
    return {
        OURS: fit_currents(seen, arm.smooth, prior),
        ALONE: fit_currents(seen, arm.smooth, replace(prior, typical={})),
    }


def judged(
    arm: Known, size: str, chosen: Subset, tested: Sequence[int]
) -> Iterator[dict[str, Any]]:
    """Yield squares [A²] and samples of each joint and recording, and how many the band holds."""
    found = fits(arm, chosen)
    plain = least_squares_coefficients(records(arm, chosen)) if chosen else None
    for own in records(arm, tested):
        errors = {name: own.current - predict(fit, own) for name, fit in found.items()}
        if plain is not None:
            errors[LEAST_SQUARES] = own.current - baseline_current(own, plain)
        for name, error in errors.items():
            slow, half = arm.smooth(error, own), np.full_like(error, np.nan)
            if name in found:
                half = band(found[name], own, arm.smooth)
            about = {"arm": arm.name, "fitted": size, "fit": str(chosen), "recording": own.name}
            yield from joint_rows(about | {"model": name}, slow, half)


def joint_rows(about: dict[str, Any], slow: Array, half: Array) -> Iterator[dict[str, Any]]:
    """Yield sums over the samples (N, 6) of low-passed errors and half bands [A], by joint."""
    for joint, (error, width) in enumerate(zip(slow.T, half.T, strict=True)):
        known = np.isfinite(error)
        banded = known & np.isfinite(width)
        yield about | {
            "joint": joint + 1,
            "square": float((error[known] ** 2).sum()),
            "samples": int(known.sum()),
            "banded": int(banded.sum()),
            "inside": int((np.abs(error) <= width)[banded].sum()),
        }


def days_left_out(arm: Known) -> Iterator[dict[str, Any]]:
    """Yield, for each day and joint, currents inside the band of the fit to the other days, and
    whether the day's own torque constant agrees with that of the others.
    """
    day = record_days([own.record for own in arm.runs])
    for one in np.unique(day) if len(np.unique(day)) > 1 else []:
        fitted = tuple(n for n in np.flatnonzero(day != one).tolist() if arm.runs[n].fitted)
        own = np.flatnonzero(day == one).tolist()
        others, alone = (fits(arm, chosen)[OURS] for chosen in (fitted, tuple(own)))
        pairs = [constants(fit) for fit in (others, alone)]
        about = {"arm": arm.name, "day": arm.runs[own[0]].record.day}
        for record in records(arm, own):
            slow = arm.smooth(record.current - predict(others, record), record)
            rows = joint_rows(about, slow, band(others, record, arm.smooth))
            for row, (value, half), (known, width) in zip(rows, *pairs, strict=True):
                yield row | {"agrees": bool(abs(value - known) <= np.hypot(half, width))}


def constants(fit: CurrentFit) -> list[tuple[float, float]]:
    """Return each joint's torque constant and half of its 95 % interval [Nm/A]."""
    rows = [row for row in parameters(fit) if row.name == "torque_constant"]
    return [(row.value, (row.interval[1] - row.interval[0]) / 2) for row in rows]


def forces_of(
    arm: Known, size: str, chosen: Subset, tested: Sequence[int]
) -> Iterator[dict[str, Any]]:
    """Yield error and coverage where a sensor felt contacts, and alarms without contact."""
    study = read_study(arm.folder.parents[1], arm.folder.name, ("fit", "validate", "contact"))
    names = {own.name for own in records(arm, chosen)}
    fitted = [own for own in study.recordings if own.name in names]
    free = {own.name for own in records(arm, tested)}
    untouched = [own for own in study.recordings if own.name in free]
    touched = [own for own in touched_of(study) if own in unseen(study, fitted)]
    with tempfile.TemporaryDirectory() as kept:
        fold = Fold(study, fitted, Path(kept))
        if why := refusal(fold, [*touched, *untouched]):
            print(f"{arm.name}, {size} recordings, no forces: {why}", flush=True)
            return
        fold.estimate([*touched, *untouched])
        about = {"arm": arm.name, "fitted": size}
        for own in touched:
            error, half, force = in_contact_of(fold, own)
            relative, inside = error.mean() / np.abs(force).mean(), (error <= half).mean()
            errors = {"error": float(relative), "inside": float(inside)}
            yield about | {"recording": own.name} | errors
        alarms = fold.alarms(untouched)
        alarms = alarms[alarms["estimate"] == "Fmap"]
        yield about | {"alarms": int(alarms["alarms"].sum()), "minutes": alarms["minutes"].sum()}


if __name__ == "__main__":
    main()
