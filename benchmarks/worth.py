"""What each part of F̂ᵐᵃᵖ earns: its scores without the part, beside those with all of them.

    python -m benchmarks.worth [<study> [<robot>]] [--constants [--page] | --currents] [--quick]

Takes results/<study> as built; by default that of `make`, of a ur5. Each path of the recordings to
fit on is left out in turn, with its day if other days have enough paths, and judged; before, all
are fitted, and what shares neither path nor day with them is judged. In contact by the force
sensor, and in pushes that are drawn with a seed and put onto recordings without contact: RMSE of
the force, share of samples inside its 95 % band, contacts found. Without contact: false alarms.
PARTS says what stands in the place of a part. `--constants` halves and doubles each of CONSTANTS
instead, on the first fold of STUDIES, and writes with `--page` the table of docs/methods.md.
`--currents` prints what is left of the currents of paths and dates left out, beside plain least
squares. `--quick` does the first fold, or two constants, alone.
"""

import sys
import tempfile
from collections.abc import Iterator, Mapping
from concurrent.futures import ProcessPoolExecutor
from contextlib import ExitStack
from dataclasses import replace
from itertools import repeat
from pathlib import Path
from pkgutil import resolve_name
from typing import Any, NamedTuple
from unittest.mock import patch

import numpy as np
import pandas as pd
import torch

from benchmarks.harness.drawn_pushes import drawn_pushes
from benchmarks.harness.markdown import markdown, replaced
from benchmarks.harness.options import arm_options, built
from benchmarks.harness.plain_currents import currents_table
from benchmarks.leave_out import Fold, Recording, Study, read_study, refusal, unseen, without_each
from ur5lib.force import force_input, residual_model
from ur5lib.force.contact_prior import TYPICAL_LOAD_SHARE, ContactPrior
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
from ur5lib.tables import read_record, write_text
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.kalman import Gaussians
from ur5lib.timeseries.metrics import NORMAL95

COLUMNS = ["without", "RMSE [N]", "inside", "found", "RMSE of pushes [N]", "inside", "found",
           "false alarms a minute"]  # fmt: skip


class Part(NamedTuple):
    """A part left out: what stands in the place of functions and constants, by their names; factors
    on fields of the prior; whether currents of the fit change, too, as for all parts after it.
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

FACTORS = (0.5, 2.0)
STUDIES = {"home": ("thesis", "ur5"), "away": ("ur10e", "ur10e")}  # of which constants are judged
THESIS, MANY = "thesis", "thesis, UR10e, UR3, Baxter, stand"  # recordings with a score in sight


class Constant(NamedTuple):
    """A constant: a field of the prior, or its places; what it scales with; the recordings that it
    was chosen on.
    """

    where: str | tuple[str, ...]
    of: str
    chosen_on: str = THESIS


PRIOR, REST = "ur5lib.force.contact_prior", "ur5lib.force.residual_model"
CONSTANTS = {
    "typical contact": Constant("force", "rated payload's weight", MANY),
    "its lever, place unknown": Constant("lever", "m", MANY),
    "weight of the lever": Constant("lever_weight", "samples", MANY),
    "magnitudes of the gate": Constant((f"{PRIOR}.GATE_SIZES",), "typical contacts", MANY),
    "a force that is no contact": Constant((f"{GATE}.QUIET_SHARE",), "fast errors", MANY),
    "duration of contacts": Constant("duration", "s"),
    "of pauses": Constant("pause", "s"),
    "of contacts that may be missed": Constant("unseen_duration", "s", MANY),
    "load friction besides the fit's": Constant("load_friction", "load"),
    "friction of a run": Constant("friction_std", "friction"),
    "what dry friction absorbs at rest": Constant((f"{REST}.USUAL_STICTION",), "breakaway", MANY),
    "in motion": Constant((f"{REST}.RUBBING_SHARE",), "deviation in motion"),
    "deviation at rest": Constant((f"{REST}.USUAL_REST_STD",), "breakaway"),
    "fast error at rest": Constant((f"{REST}.USUAL_REST_CHANGE",), "breakaway"),
    "rest that counts as much": Constant((f"{REST}.SHOWN_DURATION",), "s"),
    "hunting": Constant("hunting", "breakaway"),
    "settling": Constant("settling", "s"),
    "mean of what stiction takes": Constant(
        ("ur5lib.force.force_input.MEAN_STICTION", f"{ESTIMATE}.MEAN_STICTION"), "stiction"
    ),
    "weight of the typical contact": Constant(
        ("ur5lib.force.contact_wrench.TYPICAL_SIZE_WEIGHT",), "samples"
    ),
    "probability at which the gate closes": Constant((f"{ESTIMATE}.CLOSING_PROBABILITY",), "1"),
    "margin": Constant((f"{ESTIMATE}.CONTACT_MARGIN",), "s"),
    "κ": Constant((f"{ESTIMATE}.MISSED_DEVIATIONS",), "deviations"),
    "smoothing at rest": Constant(
        (f"{ESTIMATE}.REST_SMOOTHING_PERIODS",), "periods of the low-pass", MANY
    ),
}
PAGE, TITLE = Path("docs/methods.md"), "Constants chosen with scores in sight"


def main() -> None:
    """Print a line for each part, or constant."""
    options = arm_options(__doc__)
    options.add_argument("--constants", action="store_true", help="half and twice each constant")
    options.add_argument("--page", action="store_true", help="write them into docs/methods.md")
    options.add_argument("--currents", action="store_true", help="currents by least squares, too")
    given = options.parse_args()
    torch.set_num_threads(1)
    if given.constants:
        found = effects(given.quick)
        print(found)
        if given.page:
            write_text(replaced(PAGE.read_text(encoding="utf-8"), TITLE, found), PAGE)
        return
    study = study_of(given.study, given.robot)
    if given.currents:
        print(currents_table(study, given.quick))
        return
    print(table(rows_of(study, PARTS, given.quick)))


def study_of(name: str, robot: str) -> Study:
    """Return an arm's recordings in a built study."""
    [folder] = built([Path("results") / name])
    return read_study(folder, robot, ("fit", "validate", "contact"))


def rows_of(study: Study, parts: Mapping[str, Part], quick: bool) -> pd.DataFrame:
    """Return what is counted in each fold, or the first, without each of the parts."""
    rows: list[dict[str, Any]] = []
    for fitted, tested in folds(study)[: 1 if quick else None]:
        with tempfile.TemporaryDirectory() as kept:
            rows += without_parts(Fold(study, fitted, Path(kept)), tested, parts)
    return pd.DataFrame(rows)


def value(name: str) -> Any:
    """Return what a constant is; of the typical contact, its share."""
    where = CONSTANTS[name].where
    if where == "force":
        return TYPICAL_LOAD_SHARE
    return getattr(ContactPrior(1.0), where) if isinstance(where, str) else resolve_name(where[0])


def of(name: str, factor: float) -> str:
    """Return the name of a constant times a factor."""
    return f"{name} × {factor:g}"


def scaled(name: str, factor: float) -> Part:
    """Return the part that has a constant times a factor in its place."""
    where = CONSTANTS[name].where
    if isinstance(where, str):
        return Part(prior={where: factor})
    own = value(name)
    other = tuple(factor * one for one in own) if isinstance(own, tuple) else factor * own
    return Part(dict.fromkeys(where, other))


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
            fields = {name: factor * getattr(usual, name) for name, factor in part.prior.items()}
            for counted in counts(fold, tested, replace(usual, **fields)):
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


def effects(quick: bool) -> str:
    """A line for each constant, or two: what it is, and what half and twice of it change, in real
    contacts at home and in pushes away.
    """
    names = [*CONSTANTS][: 2 if quick else None]
    parts = {WHOLE: Part()} | {of(name, k): scaled(name, k) for name in names for k in FACTORS}
    studies = [study_of(*own) for own in STUDIES.values()]
    with ProcessPoolExecutor(len(studies)) as pool:
        found = pool.map(rows_of, studies, repeat(parts), repeat(True))
    sums = [rows.groupby(["part", "by"]).sum() for rows in found]
    heads = [f"{place} × {factor:g}" for place in STUDIES for factor in FACTORS]
    lines = [
        [
            name,
            told(value(name)),
            CONSTANTS[name].of,
            CONSTANTS[name].chosen_on,
            *(changed(own, of(name, factor)) for own in sums for factor in FACTORS),
        ]
        for name in names
    ]
    return markdown(["constant", "value", "of", "chosen on", *heads], lines)


def told(number: Any) -> str:
    """Return a number, or several, as text."""
    return ", ".join(f"{one:.3g}" for one in np.atleast_1d(number))


def changed(sums: pd.DataFrame, part: str) -> str:
    """Return by how much a part changes: RMSE [%], share inside the band [points], contacts found
    and false alarms.
    """
    by = "sensor" if (WHOLE, "sensor") in sums.index else "pushes"
    own, whole = (sums.loc[name, by] for name in (part, WHOLE))
    error = 100 * (np.sqrt(own["square"] / whole["square"] * whole["samples"] / own["samples"]) - 1)
    inside = 100 * (own["inside"] / own["samples"] - whole["inside"] / whole["samples"])
    alarms = [sums.loc[name, "alarms"]["found"] for name in (part, WHOLE)]
    numbers = error, inside, own["found"] - whole["found"], alarms[0] - alarms[1]
    return " / ".join(f"{number:+.0f}".replace("+0", "0").replace("-0", "0") for number in numbers)


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
