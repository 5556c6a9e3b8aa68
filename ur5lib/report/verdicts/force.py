"""Whether the estimated force can be used in contact."""

from collections.abc import Iterator
from typing import NamedTuple

import pandas as pd

from ur5lib.pipeline.estimators import ESTIMATES, SPOKEN
from ur5lib.report.document import Number, State, Verdict
from ur5lib.report.formats import joined
from ur5lib.report.results import Results
from ur5lib.report.sentences import say
from ur5lib.report.verdicts.baseline import ZERO, error_bar, state
from ur5lib.report.views.contacts import found_without_sensor, quiet, readings
from ur5lib.report.views.forces import leading, searched

TOPIC = "Force in contact"
UNCALIBRATED = "static"  # the estimate without any fit


def errors_in_contact(results: Results) -> pd.DataFrame:
    """Return the leading estimate's errors along x, y, z on recordings that no fit has seen."""
    rows = results.rows("force_mae", kind="compensated", during="contact")
    rows = rows[rows["component"].str.startswith("F")]
    rows = leading(rows[~rows["recording"].isin(results.with_role("fit"))])
    return rows.assign(axis=rows["component"].str[1:])


class Worst(NamedTuple):
    """Where the force is worst.

    error: row of the largest error (axis and recording); share: means over x, y, z of the recording
    with the largest error relative to the sensor's force; held: row with the smallest coverage of
    the band, None where no band is stated.
    """

    error: pd.Series
    share: pd.Series
    held: pd.Series | None

    @property
    def has_interval(self) -> bool:
        """Whether the largest error has one."""
        return not pd.isna(self.error["mae_low"])

    def state(self) -> State:
        """Judge by the larger relative error, that of the axis or that of the recording."""
        tested = self.has_interval and self.error["estimate"] != UNCALIBRATED
        shares = [row["mae"] / row["mean_force"] for row in (self.error, self.share)]
        held = 1.0 if self.held is None else self.held["coverage95"]
        return state(max(shares), 1.0, held, tested)


def worst_of(rows: pd.DataFrame) -> Worst:
    """Return where errors in contact are worst."""
    means = rows.groupby("recording", sort=False)[["mae", "mean_force"]].mean()
    stated = rows.dropna(subset="coverage95")
    return Worst(
        error=rows.loc[rows["mae"].idxmax()],
        share=means.loc[(means["mae"] / means["mean_force"]).idxmax()],
        held=stated.loc[stated["coverage95"].idxmin()] if len(stated) else None,
    )


def judge_force(results: Results) -> Verdict:
    """Judge the force by the axis and the recording on which it is worst."""
    if results.stopped():
        return Verdict(TOPIC, "do not use", say("force.stopped"))
    judged = errors_in_contact(results)
    if judged.empty:
        return _unjudged(results)
    worst = worst_of(judged)
    row, share, held = worst
    about = {"known": worst.has_interval, "calibrated": row["estimate"] != UNCALIBRATED}
    return Verdict(
        topic=TOPIC,
        state=worst.state(),
        sentence=say("force.verdict", row=row, estimate=_named(row["estimate"])),
        evidence=say("force.evidence", row=row, share=share, held=held, zero=ZERO, **about),
        drawing=error_bar(row["mae"], row["mae_low"], row["mae_high"], row["mean_force"]),
        caption=say("force.caption", known=worst.has_interval),
        numbers=tuple(_numbers(worst)),
    )


def _named(estimate: str) -> str:
    """Return an estimate's name as used in sentences."""
    if estimate == UNCALIBRATED:
        return f"{SPOKEN[estimate]} of the force"
    if SPOKEN[estimate] != ESTIMATES[estimate]:
        return SPOKEN[estimate]
    noun = "the controller's own force" if estimate == "Fu" else "the force"
    return f"{noun} {ESTIMATES[estimate]}"


def _numbers(worst: Worst) -> Iterator[Number]:
    """Yield the numbers of the evidence."""
    row, share, held = worst
    name = f"mean absolute error of {ESTIMATES[row['estimate']]}"
    place = f"{row['recording']}, along {row['axis']}, in contact"
    error = Number(name, float(row["mae"]), "N", place)
    yield error.within(row["mae_low"], row["mae_high"], "95 %").beside(row["mean_force"], ZERO)
    place = f"{share.name}, mean over x, y, z, in contact"
    yield Number(name, float(share["mae"]), "N", place).beside(share["mean_force"], ZERO)
    if held is not None:
        place = f"{held['recording']}, along {held['axis']}, in contact"
        yield Number("least share in the 95 % band", 100 * float(held["coverage95"]), "%", place)


def _unjudged(results: Results) -> Verdict:
    """Return the verdict without a sensor that could judge the force."""
    if searched(results).empty:
        return Verdict(TOPIC, "not determined", say("force.none"), joined(readings(results)))
    if len(results.tables["force_mae"]):
        return Verdict(TOPIC, "not determined", say("force.untouched"))
    counts = [*found_without_sensor(results).values()]
    alarms = quiet(results)["alarms_per_min"]
    known = counts or len(alarms)
    evidence = say("force.plausible", counts=counts, alarms=alarms) if known else ""
    return Verdict(TOPIC, "not determined", say("force.no sensor"), evidence)
