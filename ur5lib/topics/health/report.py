"""The report's part on an arm's health: how each joint changed over time, and the verdict."""

from collections.abc import Iterator
from typing import Any

import pandas as pd

from ur5lib.report.page.document import State, Verdict
from ur5lib.report.page.formats import capital, day, days
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.report.views.arms import by_arm
from ur5lib.timeseries.changes import MIN_DATES

MIN_TEMPERATURE_EFFECT = 0.5  # %, smallest effect of temperature that is mentioned
DRIFT_TOPIC = "Drift over time"  # topic


def dates(results: Results) -> Iterator[str]:
    """Report each arm's dates, whether temperatures were recorded, and lost frames."""
    for robot in results.listed("health", "robot"):
        rows = results.rows("health", robot=robot)
        yield say(
            "health.dates",
            robot=robot,
            days=rows["date"].nunique(),
            span=days(rows["date"].min(), rows["date"].max(), "to"),
            warm=rows["temperature_c"].notna().any(),
            lost=100 * rows.loc[rows["quantity"] == "lost_frames", "value"].max(),
        )


def changes(results: Results) -> Iterator[str]:
    """Yield a sentence for each change, the largest relative change first."""
    changes = ranked(results)
    for row in changes.itertuples():
        yield say("health.of arm", robot=row.robot, change=change(row))
    if changes.empty and len(dates := results.tables["health"]):
        yield _unchanged(dates)


def ranked(results: Results) -> pd.DataFrame:
    """Return the changes, the largest relative to the value before first; offsets last."""
    rows = results.tables["health_changes"]
    share = (rows["size"] / rows["before"]).abs().mask(rows["quantity"] == "offset", 0.0)
    return rows.assign(share=share).sort_values("share", ascending=False, kind="stable")


def change(row: Any) -> str:
    """Return a sentence on a change: joint, quantity, size, dates, and the temperature's effect."""
    by, added = say("health.by offset", row=row), 0.0
    if row.quantity != "offset":  # in per cent of the value before
        before = abs(row.before)
        size, error = 100 * abs(row.size) / before, 100 * row.std_error / before
        by = say("health.by share", share=size, error=error)
        added = 100 * row.by_temperature / before
    added = added if abs(added) >= MIN_TEMPERATURE_EFFECT else 0.0
    return say("health.change", row=row, by=by, added=added)


def advice(results: Results) -> Iterator[str]:
    """Ask for a fit to the recordings after the largest change."""
    rows = ranked(results)
    for row in rows[rows["share"] > 0][:1].itertuples():
        yield say("health.step", row=row, day=day(row.last))


def repeated(dates: pd.DataFrame) -> int:
    """Return on how many dates each arm at least moved along the same paths as on another date.

    dates: of health.csv. On others, a change of a joint looks like another path.
    """
    days = dates.groupby(["robot", "group"])["date"].nunique()
    return int(days.where(days > 1, 0).groupby("robot").sum().min())


def _unchanged(dates: pd.DataFrame) -> str:
    """Say that nothing changed, or that paths of their own do not tell."""
    told = "unchanged" if repeated(dates) >= MIN_DATES else "paths apart"
    return say(f"health.{told}", least=MIN_DATES)


def judge_drift(results: Results) -> Verdict | None:
    """Judge by whether anything changed where paths were repeated; None with too few dates."""
    dates = results.tables["health"]
    if dates.empty:
        return None
    span = days(dates["date"].min(), dates["date"].max(), "to")
    words = {"days": dates["date"].nunique(), "span": span}
    changes, again = ranked(results), repeated(dates)
    if changes.empty and again < MIN_DATES:
        undecided = say("health.undecided", again=again, **words)
        return Verdict(DRIFT_TOPIC, "not determined", _unchanged(dates), evidence=undecided)
    tested = dates.dropna(subset="joint").groupby(["robot", "joint", "quantity"]).ngroups
    state: State = "usable" if len(changes) else "good"
    found = [capital(change(row)) for row in changes[:1].itertuples()]
    return Verdict(
        topic=DRIFT_TOPIC,
        state=state,
        sentence=next(iter(found), _unchanged(dates)),
        evidence=say("health.evidence", changes=len(changes), tested=tested, **words),
    )


card = by_arm(judge_drift)
