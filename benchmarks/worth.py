"""What each part of F̂ᵐᵃᵖ earns: its scores without the part, beside those with all of them.

    python -m benchmarks.worth [<study> [<robot>]] [--constants | --currents] [--quick]

Takes results/<study> as built; by default that of `make`, of a ur5. Each path of the recordings to
fit on is left out in turn, with its day if other days have enough paths, and judged; before, all
are fitted, and what shares neither path nor day with them is judged. In contact by the force
sensor, and in pushes that are drawn with a seed and put onto recordings without contact: RMSE of
the force, share of samples inside its 95 % band, contacts found. Without contact: false alarms.
PARTS says what stands in the place of a part. `--constants` multiplies each of CONSTANTS by FACTORS
instead, and prints the range within which no score differs by more than SAME. `--currents` prints
what is left of the currents of paths and dates left out, beside plain least squares. `--quick` does
the first fold alone.
"""

import sys
import tempfile
from collections.abc import Iterator, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
import pandas as pd
import torch

from benchmarks.harness.drawn_pushes import drawn_pushes
from benchmarks.harness.markdown import markdown
from benchmarks.harness.options import arm_options, built
from benchmarks.harness.plain_currents import currents_table
from benchmarks.leave_out import Fold, Recording, Study, read_study, refusal, unseen, without_each
from ur5lib.force import force_input, residual_model
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.force_input import Gears
from ur5lib.force.gate import diagonal
from ur5lib.force.matching import compare
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
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.kalman import Gaussians
from ur5lib.timeseries.metrics import NORMAL95

COLUMNS = ["without", "RMSE [N]", "inside", "found", "RMSE of pushes [N]", "inside", "found",
           "false alarms a minute"]  # fmt: skip


class Part(NamedTuple):
    """A part left out: what stands in the place of functions and constants, by their names; fields
    of the prior; whether currents of the fit change, too, as for all parts after this one.
    """

    instead: Mapping[str, Any] = {}
    prior: Mapping[str, Any] = {}
    refits: bool = False


def without_gears(field: str) -> Mapping[str, Any]:
    """What gives the gears with zero in one field."""
    original = force_input.gears

    def gears(currents: Currents) -> Gears | None:
        own = original(currents)
        return own and replace(own, **{field: 0 * getattr(own, field)})

    return {"ur5lib.force.force_input.gears": gears}


def pooled(stretches: Any, joints: int, moments: Any = residual_model._moments) -> Array:
    """Moments (S, n) of the states that were met, each the mean of these."""
    found = moments(stretches, joints)
    return np.where(np.isnan(found), np.nan, np.nanmean(found, axis=0))


def unknown_background(torque: Array, _: Array, spread: Array, *__: Any) -> Gaussians:
    """A background of which nothing is known but its spread."""
    return Gaussians(np.zeros_like(torque), diagonal(spread))


def of_a_free_arm(_: Array, missed: Array, free: Array) -> Array:
    """The deviation (N, 6) of a free arm's force, no contact being missed."""
    return np.broadcast_to(np.sqrt(free), missed.shape)


WHOLE = "nothing"
ESTIMATE, GATE = "ur5lib.force.wrench_estimate", "ur5lib.force.gate"
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
    "mixture band": Part({f"{ESTIMATE}.mixture_std": of_a_free_arm}),
    "cross-fitting": Part(
        {"ur5lib.records.friction.Friction.fit_for": lambda own, _: own.fit}, refits=True
    ),
}

FACTORS = (0.25, 0.5, 2.0, 4.0)
SAME = {"rmse": 0.2, "inside": 0.02, "found": 0.05, "alarms": 0.25}  # N, shares, 1/min
CONSTANTS = {  # a field of the prior, or the places of a constant
    "typical contact [N]": "force",
    "its lever [m]": "lever",
    "weight of the lever": "lever_weight",
    "magnitudes of the gate": ["ur5lib.force.contact_prior.GATE_SIZES"],
    "a force that is no contact": [f"{GATE}.QUIET_SHARE"],
    "duration of contacts [s]": "duration",
    "of pauses [s]": "pause",
    "load friction besides the fit's": "load_friction",
    "friction of a run": "friction_std",
    "duration of those that may be missed [s]": "unseen_duration",
    "what dry friction absorbs at rest": ["ur5lib.force.residual_model.USUAL_STICTION"],
    "in motion": ["ur5lib.force.residual_model.RUBBING_SHARE"],
    "deviation at rest": ["ur5lib.force.residual_model.USUAL_REST_STD"],
    "fast error at rest": ["ur5lib.force.residual_model.USUAL_REST_CHANGE"],
    "rest that counts as much [s]": ["ur5lib.force.residual_model.SHOWN_DURATION"],
    "hunting": "hunting",
    "settling [s]": "settling",
    "mean of what stiction takes": [
        "ur5lib.force.force_input.MEAN_STICTION",
        f"{ESTIMATE}.MEAN_STICTION",
    ],
    "weight of the typical contact": ["ur5lib.force.contact_wrench.TYPICAL_SIZE_WEIGHT"],
    "gate closes": [f"{ESTIMATE}.CLOSING_PROBABILITY"],
    "margin [s]": [f"{ESTIMATE}.CONTACT_MARGIN"],
    "κ": [f"{ESTIMATE}.MISSED_DEVIATIONS"],
    "smoothing at rest [periods]": [f"{ESTIMATE}.REST_SMOOTHING_PERIODS"],
}


def main() -> None:
    """Print a line for each part, or constant."""
    options = arm_options(__doc__)
    options.add_argument("--constants", action="store_true", help="the range of each constant")
    options.add_argument("--currents", action="store_true", help="currents by least squares, too")
    given = options.parse_args()
    parts = {WHOLE: Part()} | all_scaled() if given.constants else PARTS
    [folder] = built([Path("results") / given.study])
    torch.set_num_threads(1)
    study = read_study(folder, given.robot, ("fit", "validate", "contact"))
    if given.currents:
        print(currents_table(study, given.quick))
        return
    rows: list[dict[str, Any]] = []
    for fitted, tested in folds(study)[: 1 if given.quick else None]:
        with tempfile.TemporaryDirectory() as kept:
            rows += without_parts(Fold(study, fitted, Path(kept)), tested, parts)
    found = pd.DataFrame(rows)
    print(ranges(found) if given.constants else table(found))


def value(name: str) -> Any:
    """Return what a constant is."""
    where = CONSTANTS[name]
    return getattr(ContactPrior(15.0), where) if isinstance(where, str) else resolve_name(where[0])


def all_scaled() -> dict[str, Part]:
    """Return all constants times all factors."""
    return {of(name, factor): scaled(name, factor) for name in CONSTANTS for factor in FACTORS}


def of(name: str, factor: float) -> str:
    """Return the name of a constant times a factor."""
    return f"{name} × {factor:g}"


def scaled(name: str, factor: float) -> Part:
    """Return the part that has a constant times a factor in its place."""
    where, own = CONSTANTS[name], value(name)
    other = tuple(factor * one for one in own) if isinstance(own, tuple) else factor * own
    return (
        Part(prior={where: other}) if isinstance(where, str) else Part(dict.fromkeys(where, other))
    )


def folds(study: Study) -> list[tuple[list[Recording], list[Recording]]]:
    """What to fit on, and what this has not seen of the recordings that can be judged."""
    found = [(study.fit, unseen(study, study.fit)), *(own[1:] for own in without_each(study))]
    judged = [(fitted, [*filter(is_judged, tested)]) for fitted, tested in found]
    return [own for own in judged if own[1]]


def is_judged(own: Recording) -> bool:
    """Whether nothing touches the arm, or a sensor feels what does."""
    return own.entry["role"] != "contact" or len(own.sensed()) > 0


def without_parts(
    fold: Fold, tested: list[Recording], parts: Mapping[str, Part]
) -> Iterator[dict[str, Any]]:
    """Yield what is counted in recordings without each of the parts."""
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
    """Yield what is counted in recordings, with the threshold of those that are fitted on."""
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
        problem = problem.pushed((jacobian.mT @ pushes[..., None])[..., 0])
    return problem.solve(jacobian[problem.rows], prior)


def in_contacts(
    found: WrenchEstimate, true: Array, least: float, period: float
) -> dict[str, float]:
    """Sums over the samples in contact, and the contacts, of a true wrench (N, 6) [N, Nm]."""
    size, error = np.linalg.norm(true[:, :3], axis=1), (found.wrench - true)[:, :3]
    during = in_contact(size) & np.isfinite(error).all(axis=1)
    inside = np.abs(error) <= NORMAL95 * found.std[:, :3]
    matched = compare(alarms(found.log_odds, least), contacts(size), period)
    sums = {"square": (error[during] ** 2).sum(), "inside": inside[during].mean(axis=1).sum()}
    return sums | {"samples": during.sum(), "contacts": matched.contacts, "found": matched.found}


def table(rows: pd.DataFrame) -> str:
    """A line for each part, over all recordings."""
    sums = rows.groupby(["part", "by"], sort=False).sum()
    lines = [
        [part, *figures(sums, part, "sensor"), *figures(sums, part, "pushes"), alarmed(sums, part)]
        for part in rows["part"].unique()
    ]
    return markdown(COLUMNS, lines)


def ranges(rows: pd.DataFrame) -> str:
    """A line for each constant: what it is, and the range in which the scores are the same."""
    sums = rows.groupby(["part", "by"]).sum()
    return markdown(
        ["constant", "value", "scores are the same"],
        [
            [
                name,
                told(value(name)),
                ranged(name, {factor for factor in FACTORS if same(sums, of(name, factor))}),
            ]
            for name in CONSTANTS
        ],
    )


def told(number: Any) -> str:
    """Return a number, or several, as text."""
    return ", ".join(f"{one:g}" for one in np.atleast_1d(number))


def ranged(name: str, held: set[float]) -> str:
    """Return the range of a constant by the factors about one that change nothing."""
    low, high = 1.0, 1.0
    for factor in FACTORS[1::-1]:
        low = factor if factor in held and low == 2 * factor else low
    for factor in FACTORS[2:]:
        high = factor if factor in held and factor == 2 * high else high
    return f"× {low:g} to × {high:g}" if low < high else "none"


def same(sums: pd.DataFrame, part: str) -> bool:
    """Return whether no score of a part differs from that of the whole by more than SAME."""
    return all(
        np.abs(scores(sums.loc[part, by]) - scores(sums.loc[WHOLE, by])).le(pd.Series(SAME)).all()
        for by in sums.loc[WHOLE].index
    )


def scores(own: pd.Series) -> pd.Series:
    """Return what SAME limits, of sums; zero what they do not tell."""
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = {
            "rmse": np.sqrt(own["square"] / own["samples"]),
            "inside": own["inside"] / own["samples"],
            "found": own["found"] / own["contacts"],
            "alarms": own["found"] / own["minutes"],
        }
    return pd.Series(ratios).where(np.isfinite, 0.0)


def figures(sums: pd.DataFrame, part: str, by: str) -> list[str]:
    """RMSE, share inside the band, and contacts found; empty where there are none."""
    if (part, by) not in sums.index:
        return [""] * 3
    own = sums.loc[part, by]
    rmse, inside = np.sqrt(own["square"] / own["samples"]), own["inside"] / own["samples"]
    return [f"{rmse:.2f}", f"{inside:.3f}", f"{own['found']:.0f} of {own['contacts']:.0f}"]


def alarmed(sums: pd.DataFrame, part: str) -> str:
    """False alarms a minute, empty where every recording is in contact."""
    if (part, "alarms") not in sums.index:
        return ""
    return f"{sums.loc[part, 'alarms']['found'] / sums.loc[part, 'alarms']['minutes']:.2f}"


if __name__ == "__main__":
    main()
