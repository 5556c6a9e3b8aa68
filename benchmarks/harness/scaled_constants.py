"""Constants of F̂ᵐᵃᵖ and its gate: their units, and the effect of half and twice their value."""

from collections.abc import Iterator, Mapping
from pkgutil import resolve_name
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from benchmarks.harness.markdown import markdown
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.timeseries.arrays import Array


class Constant(NamedTuple):
    """A constant.

    of: its unit; chosen: the data for its choice, and the commit; where: a field of the prior, or
    the modules with its name.
    """

    of: str
    chosen: str
    where: tuple[str, ...]


FACTORS = (0.5, 2.0)
FORCE = "ur5lib.force"
ESTIMATE, GATE, RESIDUAL, SHUT = (
    f"{FORCE}.{name}" for name in ("wrench_estimate", "gate", "residual_model", "while_shut")
)
STATES, REFIT = f"{FORCE}.external_torque", "ur5lib.steps.fit_residuals"
CONSTANTS = {
    "typical contact": Constant(
        "rated payload's weight",
        "thesis, b95bfb8c",
        (f"{FORCE}.contact_prior.TYPICAL_LOAD_SHARE",),
    ),
    "its lever": Constant("metres", "thesis, b95bfb8c", ("lever",)),
    "weight of the lever": Constant("samples", "thesis, b95bfb8c", ("lever_weight",)),
    "weight of the typical contact": Constant(
        "samples", "thesis, 03767290", (f"{FORCE}.contact_wrench.TYPICAL_SIZE_WEIGHT",)
    ),
    "magnitudes of the gate": Constant(
        "typical force", "thesis, b95bfb8c", (f"{FORCE}.contact_prior.GATE_SIZES",)
    ),
    "a force that is no contact": Constant(
        "fast error", "thesis, b95bfb8c", (f"{GATE}.QUIET_SHARE",)
    ),
    "duration of contacts": Constant("seconds", "thesis, 080f9da5", ("duration",)),
    "of pauses": Constant("seconds", "thesis, 2235795e", ("pause",)),
    "of contacts that may be missed": Constant("seconds", "thesis, b95bfb8c", ("unseen_duration",)),
    "κ": Constant(
        "deviations of what hides a contact", "thesis, c4688d3e", (f"{SHUT}.MISSED_DEVIATIONS",)
    ),
    "gate closes": Constant(
        "probability", "thesis, 2235795e", (f"{ESTIMATE}.CLOSING_PROBABILITY",)
    ),
    "margin of contacts": Constant("seconds", "thesis, 2235795e", (f"{ESTIMATE}.CONTACT_MARGIN",)),
    "an alarm ends below its threshold": Constant(
        "log-odds", "thesis, 080f9da5", (f"{FORCE}.thresholds.ALARM_HYSTERESIS",)
    ),
    "confidence in the background, by round": Constant(
        "its covariance", "thesis, 91e9e43c", (f"{GATE}.BACKGROUND_COVARIANCE_FACTORS",)
    ),
    "no measurement of the background above": Constant(
        "probability", "thesis, 2235795e", (f"{GATE}.EXCLUSION_PROBABILITY",)
    ),
    "its weight then": Constant("samples", "thesis, 2235795e", (f"{GATE}.CONTACT_SAMPLE_WEIGHT",)),
    "load friction besides the fit's": Constant(
        "contact's torque", "thesis, 2235795e", ("load_friction",)
    ),
    "friction of a run": Constant("friction of the fit", "thesis, f64413a8", ("friction_std",)),
    "what friction takes in motion": Constant(
        "deviation in motion", "thesis, c557c59e", (f"{RESIDUAL}.RUBBING_SHARE",)
    ),
    "at rest that is hardly shown": Constant(
        "breakaway torque", "thesis, b95bfb8c", (f"{RESIDUAL}.USUAL_STICTION",)
    ),
    "mean of what it takes at rest": Constant(
        "the most that it takes",
        "thesis, f64413a8",
        (f"{FORCE}.force_input.MEAN_STICTION", f"{ESTIMATE}.MEAN_STICTION"),
    ),
    "deviation at such rest": Constant(
        "breakaway torque", "thesis, b95bfb8c", (f"{RESIDUAL}.USUAL_REST_STD",)
    ),
    "fast error at such rest": Constant(
        "breakaway torque", "thesis, c557c59e", (f"{RESIDUAL}.USUAL_REST_CHANGE",)
    ),
    "rest that counts as much": Constant(
        "seconds", "thesis, b95bfb8c", (f"{RESIDUAL}.SHOWN_DURATION",)
    ),
    "least deviation": Constant(
        "breakaway torque", "thesis, b95bfb8c", (f"{RESIDUAL}.MIN_STD_SHARE",)
    ),
    "hunting": Constant("breakaway torque", "thesis, b95bfb8c", ("hunting",)),
    "settling": Constant("seconds", "thesis, 2235795e", ("settling",)),
    "smoothing at rest": Constant(
        "periods of the low-pass", "thesis", (f"{ESTIMATE}.REST_SMOOTHING_PERIODS",)
    ),
    "deviation that the prior leaves": Constant(
        "computed one", "thesis, pushes", (f"{FORCE}.contact_wrench.PRIOR_SHARE",)
    ),
    "background of a rest's start": Constant(
        "seconds", "thesis, pushes", (f"{SHUT}.REFERENCE_DURATION",)
    ),
    "of a press, counts as force": Constant(
        "press", "thesis, pushes", (f"{ESTIMATE}.PRESS_AS_FORCE",)
    ),
    "of a press, is in the band": Constant(
        "press", "thesis, pushes", (f"{ESTIMATE}.PRESS_AS_DOUBT",)
    ),
    "a slow press": Constant(
        "typical force", "thesis, 46137208", (f"{FORCE}.contact_wrench.STATIC_FORCE",)
    ),
    "its lever, likewise": Constant(
        "metres", "thesis, 46137208", (f"{FORCE}.contact_wrench.STATIC_LEVER",)
    ),
    "a stop lasts": Constant("seconds", "thesis, 2235795e", (f"{STATES}.MIN_STOP_DURATION",)),
    "friction relaxes": Constant(
        "seconds",
        "thesis, 2235795e",
        tuple(f"{place}.RELAXATION_TIME" for place in (STATES, RESIDUAL, REFIT)),
    ),
    "reach of a reversal": Constant(
        "periods of the low-pass", "thesis, b5c9e5fe", (f"{STATES}.REACH_IN_PERIODS",)
    ),
    "a fast error changes within": Constant(
        "seconds", "thesis, 080f9da5", (f"{RESIDUAL}.SHORT_LAG",)
    ),
    "the background within": Constant("seconds", "thesis, 080f9da5", (f"{RESIDUAL}.LONG_LAG",)),
    "least renewal of the background": Constant(
        "per second",
        "thesis, 080f9da5",
        tuple(f"{place}.MIN_RENEWAL_RATE" for place in (RESIDUAL, REFIT)),
    ),
    "joints that decide a force": Constant(
        "joints a path", "thesis, b95bfb8c", (f"{RESIDUAL}.JOINTS_OF_A_FORCE",)
    ),
    "as unsure as bands from": Constant("paths", "thesis, 804eb846", (f"{RESIDUAL}.GATE_PATHS",)),
}
Counts = Mapping[tuple[str, str], pd.DataFrame]  # rows by part, and by kind of contacts counted
HEADS = ["constant", "value", "of what", "chosen on"]
COUNTED = {"sensor": "contacts", "pushes": "pushes"}
SCORED = {"score": "score", "whole": "score of the run"}


def value(constant: Constant) -> Any:
    """Return the value of a constant."""
    first = constant.where[0]
    return resolve_name(first) if "." in first else getattr(ContactPrior(1.0), first)


def of(name: str, factor: float) -> str:
    """Return the name of a constant times a factor."""
    return f"{name} × {factor:g}"


def scaled() -> Iterator[tuple[str, Mapping[str, Any], Mapping[str, Any]]]:
    """Yield the name of each constant times each factor, with the new values: of names by their
    places, and of fields of the prior.
    """
    for name, own in CONSTANTS.items():
        for factor in FACTORS:
            is_field, other = "." not in own.where[0], factor * np.array(value(own))
            changed = dict.fromkeys(own.where, other if other.ndim else other.item())
            yield of(name, factor), {} if is_field else changed, changed if is_field else {}


def changes(found: Mapping[str, pd.DataFrame]) -> str:
    """Return a line for each constant: the changes in studies' counts by half and twice its value.

    found: rows of `part`, `by` and counts, by study; the first part is the whole estimate. Each
    study has a column for contacts at the sensor and one for pushes.
    """
    whole = next(iter(found.values()))["part"].iloc[0]
    columns = {
        f"{study}, {counts[whole, by]['contacts'].sum():.0f} {what}": (counts, by)
        for study, rows in found.items()
        for counts in [dict(iter(rows.groupby(["part", "by"])))]
        for by, what in COUNTED.items()
        if (whole, by) in counts
    }
    first = ["as they are", "", "", "", *(scores(*column, whole) for column in columns.values())]
    lines = [
        [
            name,
            told(value(own)),
            own.of,
            own.chosen,
            *(
                " / ".join(change(*column, whole, of(name, factor)) for factor in FACTORS)
                for column in columns.values()
            ),
        ]
        for name, own in CONSTANTS.items()
    ]
    return markdown([*HEADS, *columns], [first, *lines])


def told(number: Any) -> str:
    """Return a number, or several, as text."""
    return ", ".join(f"{one:.3g}" for one in np.atleast_1d(number))


def scores(counts: Counts, by: str, part: str) -> str:
    """Return a part's RMSE, interval score in contact and in the whole run, found contacts, share
    inside the band, and false alarms.
    """
    own = counts[part, by].sum(numeric_only=True)
    words = [f"{np.sqrt(own['square'] / own['samples']):.1f} N"]
    words += [f"score {own['score'] / own['samples']:.0f} / {own['whole'] / own['known']:.0f}"]
    words += [f"{own['found']:.0f} found"]
    words += [f"{100 * own['inside'] / own['samples']:.0f} % inside"]
    return ", ".join(words + [f"{false(counts, part):.0f} false"] * (by == "pushes"))


def change(counts: Counts, by: str, whole: str, part: str) -> str:
    """Return the differences of a part's counts from the whole's in words, "0" if none."""
    own, other = (counts[one, by] for one in (part, whole))
    sums = own.sum(numeric_only=True) - other.sum(numeric_only=True)
    rmse, error = rmse_change(own["square"].to_numpy(), other["square"].to_numpy())
    words = (
        [f"{rmse:+.0f}" + (f" ± {error:.0f} %" if round(error) else " %")] if round(rmse) else []
    )
    further = {f"% {name}": 100 * sums[key] / other[key].sum() for key, name in SCORED.items()}
    further |= {"found": sums["found"], "% inside": 100 * sums["inside"] / other["samples"].sum()}
    further |= {"false": false(counts, part) - false(counts, whole)} if by == "pushes" else {}
    words += [f"{by_much:+.0f} {what}" for what, by_much in further.items() if round(by_much)]
    return ", ".join(words).replace("-", "−") or "0"


def rmse_change(own: Array, other: Array) -> tuple[float, float]:
    """Return the relative difference of two RMSEs [%], and its standard error by jackknife.

    own, other: sums of squares (R,) over the same samples of each recording, or draw of pushes.
    """
    ratio = 100 * (np.sqrt(own.sum() / other.sum()) - 1)
    without = 100 * np.sqrt((own.sum() - own) / (other.sum() - other))
    return float(ratio), float(np.sqrt(len(own) - 1) * without.std())


def false(counts: Counts, part: str) -> float:
    """Return the number of false alarms on the recordings to which pushes are added."""
    return float(counts[part, "alarms"]["found"].sum())
