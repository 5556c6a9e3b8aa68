"""What can be observed: the smallest push by speed, and where friction is predicted."""

import math
from collections.abc import Iterator
from typing import Any

import pandas as pd

from ur5lib.force.trial_contacts import MOST
from ur5lib.report.results import Results
from ur5lib.report.sentences import Sentence, joined, say


def arms(results: Results) -> list[str]:
    """Return the arms whose recordings were judged."""
    return [*results.tables["observability"]["robot"].unique()]


def sentences(results: Results) -> Iterator[Sentence]:
    """Report at which speeds pushes on an arm are detected best and worst, and by axis."""
    for robot in arms(results):
        rows = results.rows("observability", robot=robot, quantity="smallest_push_95")
        if len(rows) > 1:
            best, worst = (
                rows.loc[place] for place in (rows["value"].idxmin(), rows["value"].idxmax())
            )
            yield say("observed.pushes", robot=robot, best=_push_at(best), worst=_push_at(worst))
        yield from _by_axis(results, robot)


def _by_axis(results: Results, robot: str) -> Iterator[Sentence]:
    """Report the smallest push along each axis that is detected, at rest and in motion."""
    rows = results.rows("observability", robot=robot)
    rows = rows[rows["quantity"].str.startswith("smallest_push_95_")]
    limits = [
        (say("observed.rest", slowest=slowest), joined(map(_limit, pushes.itertuples()), ", "))
        for slowest, pushes in rows.groupby("speed_low")
    ]
    if limits:
        yield say("observed.missed", robot=robot, limits=limits)


def _limit(row: Any) -> Sentence:
    """Return a push with its standard error and axis, the last letter of its quantity."""
    return say("observed.limit", row=row, most=MOST)


def pushes(results: Results) -> pd.DataFrame:
    """Return the smallest push that is detected, by speed of the flange."""
    return results.rows("observability", quantity="smallest_push_95").assign(most=MOST)


def velocities(results: Results) -> pd.DataFrame:
    """Return the speeds of each joint at which its friction is predicted within its band.

    slower, between, faster: share [%] of the samples within the band, below, in and above them.
    """
    rows = results.rows("observability", quantity="least_velocity")
    shares = results.rows("observability", quantity="friction_in_band").dropna(subset="value")
    ranges = [_ranges(shares, row) for _, row in rows.iterrows()]
    return rows.reset_index(drop=True).join(pd.DataFrame(ranges))


def _ranges(shares: pd.DataFrame, row: "pd.Series[float]") -> dict[str, float]:
    own = shares[(shares["robot"] == row["robot"]) & (shares["joint"] == row["joint"])]
    slower = ~(own["speed_low"] >= row["speed_low"])  # all, where no range suffices
    faster = own["speed_low"] >= row["speed_high"]
    parts = {"slower": slower, "between": ~slower & ~faster, "faster": faster}
    return {name: _share(own[within]) for name, within in parts.items()}


def _share(rows: pd.DataFrame) -> float:
    """Return the share [%] of samples within the band over several bins, NaN without samples."""
    count = rows["samples"].sum()
    return float(100 * (rows["value"] * rows["samples"]).sum() / count) if count else math.nan


def _push_at(row: Any) -> tuple[Sentence, Sentence]:
    """Return the speed at a push, and its force."""
    during = say("observed.during", row=row)
    return during, say("observed.force", force=row.value, most=MOST)
