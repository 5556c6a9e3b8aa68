"""How each joint changed over time: friction, torque constants, offsets and noise."""

from collections.abc import Iterator
from datetime import date
from typing import Any

import pandas as pd

from ur5lib.report.cells import interval, number, significant
from ur5lib.report.results import Body, Column, Results, tabulated
from ur5lib.report.sentences import Sentence, say

NAMES = {
    "coulomb": ("Coulomb friction", "Nm"),
    "viscous": ("viscous friction", "Nm s/rad"),
    "torque_constant": ("torque constant", "Nm/A"),
    "offset": ("offset", "Nm"),
    "noise": ("noise of the current", "A"),
}
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
            span=span(rows["date"].min(), rows["date"].max()),
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
    name, unit = NAMES[row.quantity]
    when = f"between {days(row.first, row.last, 'and')}"
    if row.kind == "drift":
        when = span(row.first, row.last)
    by, added = say("health.by offset", row=row, unit=unit), 0.0
    if row.quantity != "offset":
        size, error = abs(share(row.size, row)), share(row.std_error, row)
        by = say("health.by share", share=size, error=error, digits=int(error < 1))
        added = share(row.by_temperature, row)
    added = added if abs(added) >= LEAST else 0.0
    return say("health.change", row=row, name=name, by=by, when=when, added=added)


def share(size: float, row: Any) -> float:
    """Return a change in per cent of the value before it."""
    return float(100 * size / abs(row.before))


def changes(results: Results) -> Body:
    """Return the table of changes."""
    columns: dict[str, Column] = {
        "arm": "robot",
        "joint": "joint",
        "quantity": lambda row: NAMES[row.quantity][0],
        "when": lambda row: f"{row.kind}, {days(row.first, row.last, 'to')}",
        "before": lambda row: f"{significant(row.before, 3)} {NAMES[row.quantity][1]}",
        "change": lambda row: significant(row.size, 2).replace("-", "−"),
        "95 %": lambda row: interval(row.low, row.high, 3),
        "by temperature": lambda row: number(row.by_temperature, 3),
    }
    return tabulated(ranked(results).itertuples(), columns)


def span(first: str, last: str) -> str:
    """Return a period in words."""
    return f"from {days(first, last, 'to')}"


def days(first: str, last: str, word: str) -> str:
    """Return two dates in words, without repeating month and year."""
    _, month, year = day(last).split()
    return f"{day(first).removesuffix(f' {year}').removesuffix(f' {month}')} {word} {day(last)}"


def day(iso: str) -> str:
    """Return an ISO date in words."""
    parsed = date.fromisoformat(iso)
    return f"{parsed.day} {parsed:%B %Y}"


def steps(results: Results) -> Iterator[Sentence]:
    """Ask for a fit to the recordings after the largest change."""
    rows = ranked(results)
    for row in rows[rows["share"] > 0][:1].itertuples():
        yield say("health.step", row=row, day=day(row.last), name=NAMES[row.quantity][0])
