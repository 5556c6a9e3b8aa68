"""Judge whether a joint of an arm changed between dates, where paths were repeated."""

from collections.abc import Iterator
from typing import Any

import pandas as pd

from ur5lib.records.step import step
from ur5lib.records.verdicts import Reason, State, Verdict
from ur5lib.topics.health.changes import MIN_DATES

QUESTION = "drift"


@step("arm", "verdicts=health.verdicts.csv")
def judge_health(health: pd.DataFrame, changes: pd.DataFrame) -> list[Verdict]:
    """Return whether friction, constants, offsets or noise of a joint changed; [] with too few
    dates.

    health, changes: health.csv and health_changes.csv of an arm.
    """
    return [*_judged(health, changes)] if len(health) else []


def _judged(health: pd.DataFrame, changes: pd.DataFrame) -> Iterator[Verdict]:
    state, reason = state_of(health, changes)
    tested = health.dropna(subset="joint").groupby(["joint", "quantity"]).ngroups
    dates = health["date"].nunique()
    if reason == "few_dates":
        name = "dates with a path of another date"
        about: Any = {"state": state, "reason": reason, "quantity": name, "sense": "more"}
        yield Verdict(question=QUESTION, **about, count=repeated(health), of=dates)
        return
    yield Verdict(
        question=QUESTION,
        state=state,
        reason=reason,
        quantity="quantities of joints that changed",
        sense="less",
        count=len(changes),
        of=tested,
    )
    yield Verdict(question=QUESTION, rank=2, quantity="dates", count=dates)
    relative = changes[changes["quantity"] != "offset"]
    shares = 100 * relative["size"] / relative["before"].abs()
    if len(shares):
        row = relative.loc[shares.abs().idxmax()]
        yield Verdict(
            question=QUESTION,
            rank=3,
            quantity=f"largest change, {str(row['quantity']).replace('_', ' ')}",
            value=float(shares[row.name]),
            unit="%",
            sense="change",
            joint=int(row["joint"]),
        )


def state_of(health: pd.DataFrame, changes: pd.DataFrame) -> tuple[State, Reason]:
    """Return the state, and why it is not good. Only dates with a repeated path count: otherwise
    the path may explain a difference.
    """
    if len(changes):
        return "usable", "changed"
    return ("good", "") if repeated(health) >= MIN_DATES else ("not determined", "few_dates")


def repeated(health: pd.DataFrame) -> int:
    """Return the number of dates on which the arm moved along the paths of another date."""
    days = health.groupby("group")["date"].nunique()
    return int(days.where(days > 1, 0).sum())
