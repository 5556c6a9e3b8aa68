"""Whether the estimated force can be used in contact."""

from collections.abc import Iterator
from typing import NamedTuple

import pandas as pd

from ur5lib.pipeline.estimates import ESTIMATES, SPOKEN
from ur5lib.report.cells import fixed, interval, sentence
from ur5lib.report.document import Number, State, Verdict
from ur5lib.report.results import Results
from ur5lib.report.verdicts.drawings import error_bar
from ur5lib.report.verdicts.errors import ZERO
from ur5lib.report.verdicts.states import state
from ur5lib.report.views.contacts import found_without_sensor, quiet
from ur5lib.report.views.forces import leading, searched
from ur5lib.report.views.sensed import readings

TOPIC = "Force in contact"
UNCALIBRATED = "static"  # the estimate without any fit


def errors_in_contact(results: Results) -> pd.DataFrame:
    """Return the leading estimate's errors along x, y, z on recordings that no fit has seen."""
    rows = results.rows("force_mae", kind="compensated", during="contact")
    rows = rows[rows["component"].str.startswith("F")]
    rows = leading(rows[~rows["recording"].isin(results.with_role("fit"))])
    return rows.assign(axis=rows["component"].str[1:])


class Worst(NamedTuple):
    """Where the force is worst: axis and recording of the largest error; sums over x, y, z by
    recording of the largest share of the sensor's force; axis and recording that the band holds
    least, None where no band is stated.
    """

    error: pd.Series
    share: pd.Series
    held: pd.Series | None

    def state(self) -> State:
        """Judge by the larger share of the sensor's force, of the axis and of the recording."""
        known = not pd.isna(self.error["mae_low"]) and self.error["estimate"] != UNCALIBRATED
        shares = [row["mae"] / row["mean_force"] for row in (self.error, self.share)]
        held = 1.0 if self.held is None else self.held["coverage95"]
        return state(max(shares), 1.0, held, known)


def worst_of(rows: pd.DataFrame) -> Worst:
    """Return where errors in contact are worst."""
    means = rows.groupby("recording", sort=False)[["mae", "mean_force"]].mean()
    stated = rows.dropna(subset="coverage95")
    return Worst(
        error=rows.loc[rows["mae"].idxmax()],
        share=means.loc[(means["mae"] / means["mean_force"]).idxmax()],
        held=stated.loc[stated["coverage95"].idxmin()] if len(stated) else None,
    )


def verdict(results: Results) -> Verdict:
    """Judge the force by the axis and the recording on which it is worst."""
    if results.stopped():
        return Verdict(TOPIC, "do not use", "A stop sign stands: recordings contradict the study.")
    judged = errors_in_contact(results)
    if judged.empty:
        return _unjudged(results)
    worst = worst_of(judged)
    row, known = worst.error, not pd.isna(worst.error["mae_low"])
    dot = "Dot: error with its 95 % interval" if known else "Dot: error"
    return Verdict(
        topic=TOPIC,
        state=worst.state(),
        sentence=f"In contact, {_named(row['estimate'])} is off by {fixed(row['mae'], 1)} N along "
        f"{row['axis']}, the largest error, where the sensor reads "
        f"{fixed(row['mean_force'], 1)} N.",
        evidence=" ".join(_evidence(worst)),
        drawing=error_bar(row["mae"], row["mae_low"], row["mae_high"], row["mean_force"]),
        caption=f"{dot}; line: error of zero force.",
        numbers=tuple(_numbers(worst)),
    )


def _named(estimate: str) -> str:
    """Return an estimate's name as used in sentences."""
    if estimate == UNCALIBRATED:
        return f"{SPOKEN[estimate]} of the force"
    own = "the controller's own force" if estimate == "Fu" else "the force"
    return f"{own} {ESTIMATES[estimate]}"


def _evidence(worst: Worst) -> Iterator[str]:
    """Yield the error with its interval and baseline, the recording that is worst beside zero, the
    band's coverage, and what is missing.
    """
    row, share, held = worst
    known = not pd.isna(row["mae_low"])
    ends = f" (95 %: {interval(row['mae_low'], row['mae_high'], 1)})" if known else ""
    yield (
        f"{row['recording']}, along {row['axis']}: {fixed(row['mae'], 1)} N{ends}; {ZERO}: "
        f"{fixed(row['mean_force'], 1)} N."
    )
    yield (
        f"Largest share of the force, mean over x, y, z: {fixed(share['mae'], 1)} of "
        f"{fixed(share['mean_force'], 1)} N on {share.name}."
    )
    if held is not None:
        yield (
            f"The 95 % band holds least along {held['axis']} on {held['recording']}: "
            f"{100 * held['coverage95']:.0f} %."
        )
    if not known:
        yield "Fewer than three contacts: no interval."
    if row["estimate"] == UNCALIBRATED:
        yield "No friction was fitted, so that this estimate is not calibrated."


def _numbers(worst: Worst) -> Iterator[Number]:
    """Yield the numbers of the evidence."""
    row, share, held = worst
    known = not pd.isna(row["mae_low"])
    name = f"mean absolute error of {ESTIMATES[row['estimate']]}"
    yield Number(
        name=name,
        value=float(row["mae"]),
        unit="N",
        place=f"{row['recording']}, along {row['axis']}, in contact",
        low=float(row["mae_low"]) if known else None,
        high=float(row["mae_high"]) if known else None,
        interval="95 %" if known else "",
        baseline=float(row["mean_force"]),
        baseline_of=ZERO,
    )
    yield Number(
        name=name,
        value=float(share["mae"]),
        unit="N",
        place=f"{share.name}, mean over x, y, z, in contact",
        baseline=float(share["mean_force"]),
        baseline_of=ZERO,
    )
    if held is not None:
        place = f"{held['recording']}, along {held['axis']}, in contact"
        yield Number("least share in the 95 % band", 100 * float(held["coverage95"]), "%", place)


def _unjudged(results: Results) -> Verdict:
    """Say what is known of the force where nothing judges its size."""
    if searched(results).empty:
        told = "No force was estimated that a force sensor could judge."
        return Verdict(TOPIC, "not determined", told, " ".join(readings(results)))
    if len(results.tables["force_mae"]):
        told = "The force sensor felt no contact on a recording that no fit has seen."
        return Verdict(TOPIC, "not determined", told)
    counts = found_without_sensor(results)
    alarms = quiet(results)["alarms_per_min"]
    touched = sum(map(bool, counts.values()))
    parts = []
    if counts:
        parts.append(
            f"contacts found: {sum(counts.values())}, on {touched} of {len(counts)} recordings"
        )
    if len(alarms):
        parts.append(f"{alarms.mean():.1f} false alarms per minute on validate recordings")
    return Verdict(
        topic=TOPIC,
        state="not determined",
        sentence="No force sensor was recorded: contacts are plausible only, their size is "
        "untested.",
        evidence=sentence("; ".join(parts)),
    )
