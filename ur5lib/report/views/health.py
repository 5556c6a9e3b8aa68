"""How each joint changed over time: friction, torque constants, offsets and noise."""

from collections.abc import Iterator
from typing import Any

import pandas as pd

from ur5lib.report.cells import day, days
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, say

LEAST = 0.5  # %, smallest effect of temperature that is mentioned


def dated(results: Results) -> list[str]:
    """Return the arms with enough dates."""
    return [*results.tables["health"]["robot"].unique()]


def dates(results: Results) -> Iterator[Sentence]:
    """Report each arm's dates, whether temperatures were recorded, and lost frames."""
    for robot in dated(results):
        rows = results.rows("health", robot=robot)
        yield say(
            "health.dates",
            robot=robot,
            days=rows["date"].nunique(),
            span=days(rows["date"].min(), rows["date"].max(), "to"),
            warm=rows["temperature_c"].notna().any(),
            lost=100 * rows.loc[rows["quantity"] == "lost_frames", "value"].max(),
        )


def sentences(results: Results) -> Iterator[Sentence]:
    """Yield a sentence for each change, the largest relative change first."""
    changes = ranked(results)
    for row in changes.itertuples():
        yield say("health.of arm", robot=row.robot, change=change(row))
    if changes.empty and dated(results):
        yield say("health.nothing")


def ranked(results: Results) -> pd.DataFrame:
    """Return the changes, the largest relative to the value before first; offsets last."""
    rows = results.tables["health_changes"]
    share = (rows["size"] / rows["before"]).abs().mask(rows["quantity"] == "offset", 0.0)
    return rows.assign(share=share).sort_values("share", ascending=False, kind="stable")


def change(row: Any) -> Sentence:
    """Return a sentence on a change: joint, quantity, size, dates, and the temperature's effect."""
    by, added = say("health.by offset", row=row), 0.0
    if row.quantity != "offset":
        size, error = abs(share(row.size, row)), share(row.std_error, row)
        by = say("health.by share", share=size, error=error, digits=int(error < 1))
        added = share(row.by_temperature, row)
    added = added if abs(added) >= LEAST else 0.0
    return say("health.change", row=row, by=by, added=added)


def share(size: float, row: Any) -> float:
    """Return a change in per cent of the value before it."""
    return float(100 * size / abs(row.before))


def steps(results: Results) -> Iterator[Sentence]:
    """Ask for a fit to the recordings after the largest change."""
    rows = ranked(results)
    for row in rows[rows["share"] > 0][:1].itertuples():
        yield say("health.step", row=row, day=day(row.last))
