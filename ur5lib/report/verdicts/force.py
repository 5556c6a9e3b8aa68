"""Whether the estimated force can be used in contact."""

from collections.abc import Iterator

import pandas as pd

from ur5lib.pipeline.estimates import ESTIMATES
from ur5lib.report.cells import fixed, interval, sentence
from ur5lib.report.document import Number, Verdict
from ur5lib.report.results import Results
from ur5lib.report.verdicts.drawings import error_bar
from ur5lib.report.verdicts.errors import ZERO
from ur5lib.report.verdicts.states import state
from ur5lib.report.views.contacts import found_without_sensor, quiet
from ur5lib.report.views.forces import leading, searched

TOPIC = "Force in contact"
MEANS = ["mae", "mae_low", "mae_high", "mean_force", "coverage95"]


def errors_in_contact(results: Results) -> pd.DataFrame:
    """Return the leading estimate's errors on each recording that no fit has seen, as means over
    x, y, z.

    The mean of three intervals is at least as wide as the interval of the mean.
    """
    rows = results.rows("force_mae", kind="compensated", during="contact")
    rows = rows[rows["component"].str.startswith("F")]
    rows = leading(rows[~rows["recording"].isin(results.with_role("fit"))])
    return rows.groupby(["recording", "estimate"], sort=False)[MEANS].mean().reset_index("estimate")


def verdict(results: Results) -> Verdict:
    """Judge the force by the recording on which it is worst."""
    if results.stopped():
        return Verdict(TOPIC, "do not use", "A stop sign stands: recordings contradict the study.")
    judged = errors_in_contact(results)
    if judged.empty:
        return _unjudged(results)
    held = judged["coverage95"].min()
    row = judged.loc[(judged["mae"] / judged["mean_force"]).idxmax()]
    known = not pd.isna(row["mae_low"])
    dot = "Dot: error with its 95 % interval" if known else "Dot: error"
    return Verdict(
        topic=TOPIC,
        state=state(row["mae"], row["mean_force"], held, known),
        sentence=f"In contact, {_named(row['estimate'])} is off by {fixed(row['mae'], 1)} N per "
        f"axis at worst, where the sensor reads {fixed(row['mean_force'], 1)} N.",
        evidence=" ".join(_evidence(row, held)),
        drawing=error_bar(row["mae"], row["mae_low"], row["mae_high"], row["mean_force"]),
        caption=f"{dot}; line: error of zero force.",
        numbers=tuple(_numbers(row, held)),
    )


def _named(estimate: str) -> str:
    """Return an estimate's name as used in sentences."""
    own = "the controller's own force" if estimate == "Fu" else "the force"
    return f"{own} {ESTIMATES[estimate]}"


def _evidence(row: pd.Series, held: float) -> Iterator[str]:
    """Yield the error with its interval and baseline, the band's coverage, and what is missing."""
    known = not pd.isna(row["mae_low"])
    ends = f" (95 %: {interval(row['mae_low'], row['mae_high'], 1)})" if known else ""
    yield (
        f"{row.name}, mean over x, y, z: {fixed(row['mae'], 1)} N{ends}; {ZERO}: "
        f"{fixed(row['mean_force'], 1)} N."
    )
    if not pd.isna(held):
        yield f"The 95 % band holds {100 * held:.0f} % at worst."
    if not known:
        yield "Fewer than three contacts: no interval."


def _numbers(row: pd.Series, held: float) -> Iterator[Number]:
    """Yield the numbers of the evidence."""
    known = not pd.isna(row["mae_low"])
    place = f"{row.name}, mean over x, y, z, in contact"
    yield Number(
        name=f"mean absolute error of {ESTIMATES[row['estimate']]}",
        value=float(row["mae"]),
        unit="N",
        place=place,
        low=float(row["mae_low"]) if known else None,
        high=float(row["mae_high"]) if known else None,
        interval="95 %" if known else "",
        baseline=float(row["mean_force"]),
        baseline_of=ZERO,
    )
    if not pd.isna(held):
        yield Number("least share in the 95 % band", 100 * float(held), "%")


def _unjudged(results: Results) -> Verdict:
    """Say what is known of the force where nothing judges its size."""
    if searched(results).empty:
        return Verdict(TOPIC, "not determined", "No force was estimated.")
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
