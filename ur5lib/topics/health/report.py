"""The report's part on an arm's health: how each joint changed over time."""

from collections.abc import Iterator
from typing import Any

import pandas as pd

from ur5lib.report.page.formats import day, days
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results

MIN_TEMPERATURE_EFFECT = 0.5  # %, smallest effect of temperature that is mentioned


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
    for row in results.rows("verdicts", question="drift").drop_duplicates("question").itertuples():
        if changes.empty:
            yield say("health.unchanged" if row.state == "good" else "health.paths apart")


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
