"""What each part of F̂ᵐᵃᵖ earns: its scores without the part, beside those with all of them.

    python -m benchmarks.worth [<study>[:<robot>] ...] [--constants [--page] | --currents] [--quick]

Takes results/<study> as built; by default that of `make`, of a ur5. Each path of the recordings to
fit on is left out in turn, with its day if other days have enough paths, and judged; before, all
are fitted, and what shares neither path nor day with them is judged. In contact by the force
sensor, and in pushes that are drawn with a seed and put onto recordings without contact: RMSE of
the force, share of samples inside its 95 % band, the band's interval score (its width and 40 times
what lies outside it, mean of the axes), in contact and in the whole recording, and its width;
contacts found, and how late; the error of the largest force of those found, and the share in which
it is more than a quarter too small. While nothing is found: share of samples within the band U of
an untouched arm, where the force is below H, which may be hidden; and of missed contacts below H.
Without contact: false alarms. PARTS says what stands in the place of a part.

`--constants` takes half and twice of each constant of `benchmarks/harness/scaled_constants.py`
instead, and prints what this changes in all studies; `--page` writes it into docs/methods.md.
`--currents` prints what is left of the currents of paths and dates left out, beside plain least
squares. `--quick` does the first fold alone.
"""

import os
import sys
import tempfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
import pandas as pd
import torch

from benchmarks.harness.drawn_pushes import drawn_pushes
from benchmarks.harness.markdown import markdown, read_page, replaced, write_page
from benchmarks.harness.options import built, study_options
from benchmarks.harness.plain_currents import currents_table
from benchmarks.harness.scaled_constants import changes, scaled
from benchmarks.leave_out import Fold, Recording, Study, read_study, refusal, unseen, without_each
from ur5lib.force import force_input, residual_model
from ur5lib.force.alarms import largest_force
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.force_input import Gears
from ur5lib.force.gate import diagonal
from ur5lib.force.matching import compare, match
from ur5lib.force.problem import fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.force.sensed_contact import contacts, in_contact
from ur5lib.force.thresholds import alarm_threshold, alarms
from ur5lib.force.wrench_estimate import OPENING_PROBABILITY, WrenchEstimate
from ur5lib.records.contact_place import ContactPlace
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Motion
from ur5lib.tables import read_record
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.kalman import Gaussians
from ur5lib.timeseries.metrics import NORMAL95, interval_scores

PAGE, TITLE = Path(__file__).parents[1] / "docs/methods.md", "Constants chosen with scores in sight"
FIGURES = [
    "RMSE [N]",
    "inside",
    "score in contact / whole run [N]",
    "width [N]",
    "found",
    "late [s]",
    "peaks [%], low",
    "in U, H",
]
TOO_LOW = 0.75  # of the true largest force
COLUMNS = ["without", *FIGURES, *(f"pushes: {name}" for name in FIGURES), "false alarms a minute"]


class Part(NamedTuple):
    """A part left out.

    instead: replacements of functions and constants, by name; prior: changed fields of the prior;
    refits: whether the fit's currents change, too, also for all parts after this one.
    """

    instead: Mapping[str, Any] = {}
    prior: Mapping[str, Any] = {}
    refits: bool = False


def without_gears(field: str) -> Mapping[str, Any]:
    """Return the replacement of `gears` with one field set to zero."""
    original = force_input.gears

    def gears(currents: Currents) -> Gears | None:
        own = original(currents)
        return own and replace(own, **{field: 0 * getattr(own, field)})

    return {"ur5lib.force.force_input.gears": gears}


def pooled(stretches: Any, joints: int, moments: Any = residual_model._moments) -> Array:
    """Return moments (S, n) with each observed state replaced by the mean over these states."""
    found = moments(stretches, joints)
    return np.where(np.isnan(found), np.nan, np.nanmean(found, axis=0))


def unknown_background(torque: Array, _: Array, spread: Array, *__: Any) -> Gaussians:
    """Return a background with zero mean and its spread at all samples."""
    return Gaussians(np.zeros_like(torque), diagonal(spread))


def of_a_free_arm(_: Array, missed: Array, free: Array) -> Array:
    """Return the standard deviation (N, 6) of a free arm's force, as if no contact was missed."""
    return np.broadcast_to(np.sqrt(free), missed.shape)


WHOLE = "nothing"
ESTIMATE, GATE = "ur5lib.force.wrench_estimate", "ur5lib.force.gate"
SHUT = "ur5lib.force.while_shut"
PARTS = {
    WHOLE: Part(),
    "friction of the run": Part(without_gears("friction")),
    "joint states": Part({"ur5lib.force.residual_model._moments": pooled}),
    "load friction of gears": Part(without_gears("loss")),
    "background": Part({f"{GATE}.smooth": unknown_background}),
    "hunting": Part(prior={"hunting": 0.0}),
    "stiction given back": Part(
        {f"{ESTIMATE}.mean_stiction_torque": lambda torque, *_: 0 * torque}
    ),
    "smoothing at rest": Part({f"{ESTIMATE}.smoothed": lambda wrench, *_: wrench}),
    "margin and hysteresis": Part(
        {f"{ESTIMATE}.CONTACT_MARGIN": 0.0, f"{ESTIMATE}.CLOSING_PROBABILITY": OPENING_PROBABILITY}
    ),
    "usual rest": Part({"ur5lib.force.residual_model.SHOWN_DURATION": 1e-3}),
    "mixture band": Part({f"{SHUT}.mixture_std": of_a_free_arm}),
    "cross-fitting": Part(
        {"ur5lib.records.friction.Friction.fit_for": lambda own, _: own.fit}, refits=True
    ),
}


def main() -> None:
    """Print a line for each part, or constant."""
    options = study_options(__doc__)
    options.set_defaults(studies=["demo"])
    options.add_argument("--constants", action="store_true", help="half and twice of each constant")
    options.add_argument("--currents", action="store_true", help="currents by least squares, too")
    options.add_argument("--page", action="store_true", help="write constants to docs/methods.md")
    given = options.parse_args()
    torch.set_num_threads(1)
    if given.currents:
        for name in given.studies:
            print(currents_table(arm_of(name), given.quick))
        return
    many = len(given.studies)
    with ProcessPoolExecutor(min(many, os.cpu_count() or 1)) as pool:
        asked = given.studies, [given.constants] * many, [given.quick] * many
        found = dict(zip(given.studies, pool.map(judged, *asked), strict=True))
    tables = [changes(found)] if given.constants else [table(rows) for rows in found.values()]
    print(*tables, sep="\n\n")
    if given.constants and given.page:
        write_page(replaced(read_page(PAGE), TITLE, tables[0]), PAGE)


def arm_of(name: str) -> Study:
    """Return the recordings of an arm of a built study, <study>:<robot>, by default its UR5."""
    study, _, robot = name.partition(":")
    [folder] = built([Path("results") / study])
    return read_study(folder, robot or "ur5", ("fit", "validate", "contact"))


def judged(name: str, constants: bool, quick: bool) -> pd.DataFrame:
    """Return the counts of an arm without each of the parts, over all folds or the first."""
    study, parts = arm_of(name), PARTS
    if constants:
        parts = {WHOLE: Part()} | {part: Part(instead, prior) for part, instead, prior in scaled()}
    rows: list[dict[str, Any]] = []
    for fitted, tested in folds(study)[: 1 if quick else None]:
        with tempfile.TemporaryDirectory() as kept:
            rows += without_parts(Fold(study, fitted, Path(kept)), tested, parts)
    return pd.DataFrame(rows)


def folds(study: Study) -> list[tuple[list[Recording], list[Recording]]]:
    """Return pairs of fitted recordings, and judged recordings that this fit has not seen."""
    found = [(study.fit, unseen(study, study.fit)), *(own[1:] for own in without_each(study))]
    judged = [(fitted, [*filter(is_judged, tested)]) for fitted, tested in found]
    return [own for own in judged if own[1]]


def is_judged(own: Recording) -> bool:
    """Return whether a recording has no contact, or a force sensor."""
    return own.entry["role"] != "contact" or len(own.sensed()) > 0


def without_parts(
    fold: Fold, tested: list[Recording], parts: Mapping[str, Part]
) -> Iterator[dict[str, Any]]:
    """Yield the counts of recordings without each of the parts."""
    if why := refusal(fold, tested):
        print(f"{', '.join(own.name for own in tested)}: {why}", file=sys.stderr)
        return
    for name, part in parts.items():
        with ExitStack() as changed:
            for place, other in part.instead.items():
                changed.enter_context(patch(place, other))
            for own in fold.fitted if part.refits else ():
                fold.currents(own, "fit")
            fold.residuals()
            force = fold.study.settings.contact.force_n
            usual = ContactPrior.of(fold.arm, force, ContactPlace())
            for counted in counts(fold, tested, replace(usual, **part.prior)):
                yield {"part": name} | counted


def counts(fold: Fold, tested: list[Recording], prior: ContactPrior) -> Iterator[dict[str, Any]]:
    """Yield the counts of recordings, with the threshold from the fitted recordings."""
    periods = [Motion.read(own.file("motion.parquet")).period for own in fold.fitted]
    odds = [estimate(fold, own, prior).log_odds for own in fold.fitted]
    least = alarm_threshold(odds, periods, fold.study.settings.alarms.false_per_min)
    for own in tested:
        motion, found = Motion.read(own.file("motion.parquet")), estimate(fold, own, prior)
        if own.entry["role"] == "contact":
            yield {"by": "sensor"} | in_contacts(found, own.sensed(), least, motion.period)
            continue
        minutes = len(motion.time) * motion.period / 60
        yield {"by": "alarms", "found": len(alarms(found.log_odds, least)), "minutes": minutes}
        for pushes in drawn_pushes(motion.time, fold.study.settings.lowpass.currents):
            found = estimate(fold, own, prior, pushes)
            yield {"by": "pushes"} | in_contacts(found, pushes, least, motion.period)


def estimate(
    fold: Fold, own: Recording, prior: ContactPrior, pushes: Array | None = None
) -> WrenchEstimate:
    """F̂ᵐᵃᵖ of a recording, with pushes (N, 6) [N, Nm] on its flange."""
    motion = Motion.read(own.file("motion.parquet"))
    currents = Currents.read(fold.own(own, "currents.parquet"))
    residuals = read_record(Residuals, fold.shared("residuals.json"))
    problem = fmap_problem(motion, currents, residuals)
    assert problem is not None
    jacobian = Kinematics.read(own.file("kinematics.parquet")).jacobian
    if pushes is not None:
        torque = problem.input.torque + (jacobian.mT @ pushes[..., None])[..., 0]
        problem = problem._replace(input=replace(problem.input, torque=torque))
    return problem.solve(jacobian[problem.rows], prior)


def in_contacts(
    found: WrenchEstimate, true: Array, least: float, period: float
) -> dict[str, float]:
    """Sums over the samples in contact, and the contacts, of a true wrench (N, 6) [N, Nm]."""
    size, error = np.linalg.norm(true[:, :3], axis=1), (found.wrench - true)[:, :3]
    during = in_contact(size) & np.isfinite(error).all(axis=1)
    inside = np.abs(error) <= NORMAL95 * found.std[:, :3]
    score = interval_scores(found.wrench, found.std, true)[:, :3].mean(axis=1)
    matched = compare(alarms(found.log_odds, least), contacts(size), period)
    sums = {"square": (error[during] ** 2).sum(), "inside": inside[during].mean(axis=1).sum()}
    sums |= {"score": score[during].sum(), "whole": np.nansum(score)}
    sums |= {"width": 2 * NORMAL95 * found.std[during, :3].mean(axis=1).sum()}
    sums |= {"samples": during.sum(), "known": np.isfinite(score).sum()}
    sums |= {"contacts": matched.contacts, "found": matched.found, "late": matched.delays.sum()}
    return sums | peaks(found, size, least) | while_nothing_is_found(found, true[:, :3], during)


def peaks(found: WrenchEstimate, size: Array, least: float) -> dict[str, float]:
    """Sums over the contacts that are found, by the largest force, true one (N,) [N]."""
    touched, std = contacts(size), found.std[:, :3]
    spans = [slice(*touched[j]) for _, j in match(alarms(found.log_odds, least), touched)]
    true = np.array([size[own].max() for own in spans])
    stated = np.array([largest_force(found.unsmoothed[own], std[own])[0] for own in spans])
    return {
        "peak": true.sum(),
        "off": (stated - true).sum(),
        "low": (stated < TOO_LOW * true).sum(),
    }


def while_nothing_is_found(found: WrenchEstimate, true: Array, during: Mask) -> dict[str, float]:
    """Sums over the samples at which nothing is found, of a force (N, 3) [N] along each axis."""
    shut = (found.hidden > 0).all(axis=1) & np.isfinite(true).all(axis=1)
    below = shut & (np.abs(true) <= found.hidden).all(axis=1)
    missed = shut & during
    in_u = (np.abs(true - found.wrench[:, :3]) <= found.untouched)[below].mean(axis=1)
    in_h = (np.abs(true) <= found.hidden)[missed].mean(axis=1)
    sums = {"in U": in_u.sum(), "below": below.sum(), "in H": in_h.sum(), "missed": missed.sum()}
    return {name: float(value) for name, value in sums.items()}


def table(rows: pd.DataFrame) -> str:
    """A line for each part, over all recordings."""
    sums = rows.groupby(["part", "by"], sort=False).sum()
    lines = [
        [part, *figures(sums, part, "sensor"), *figures(sums, part, "pushes"), alarmed(sums, part)]
        for part in rows["part"].unique()
    ]
    return markdown(COLUMNS, lines)


def figures(sums: pd.DataFrame, without: str, by: str) -> list[str]:
    """Return the cells of FIGURES; empty where there are no contacts."""
    if (without, by) not in sums.index:
        return [""] * len(FIGURES)
    own = sums.loc[without, by]

    def share(part: str, whole: str) -> float:
        return own[part] / own[whole] if own[whole] else np.nan

    return [
        f"{np.sqrt(share('square', 'samples')):.2f}",
        f"{share('inside', 'samples'):.3f}",
        f"{share('score', 'samples'):.1f} / {share('whole', 'known'):.1f}",
        f"{share('width', 'samples'):.1f}",
        f"{own['found']:.0f} of {own['contacts']:.0f}",
        f"{share('late', 'found'):.3f}",
        f"{share('off', 'peak'):+.1%}, {share('low', 'found'):.2f}",
        f"{share('in U', 'below'):.3f}, {share('in H', 'missed'):.3f}",
    ]


def alarmed(sums: pd.DataFrame, part: str) -> str:
    """False alarms a minute, empty where every recording is in contact."""
    if (part, "alarms") not in sums.index:
        return ""
    return f"{sums.loc[part, 'alarms']['found'] / sums.loc[part, 'alarms']['minutes']:.2f}"


if __name__ == "__main__":
    main()
