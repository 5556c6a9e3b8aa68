"""What can be observed: the smallest push by speed, and where friction is predicted."""

import math
from collections.abc import Iterator
from typing import Any

import pandas as pd

from ur5lib.force.trial_contacts import MOST
from ur5lib.report.cells import fixed, with_error
from ur5lib.report.document import Cell
from ur5lib.report.observability_figure import flange_speeds
from ur5lib.report.results import Body, Column, Results, tabulated
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


def pushes(results: Results) -> Body:
    """Return the smallest push that is detected, by speed of the flange."""
    rows = results.rows("observability", quantity="smallest_push_95")
    columns: dict[str, Column] = {
        "arm": "robot",
        "speed of the flange [m/s]": flange_speeds,
        "trial pushes": lambda row: f"{row.samples:.0f}",
        "smallest push [N]": _push,
    }
    return tabulated(rows.itertuples(), columns)


def velocities(results: Results) -> Body:
    """Return the speeds of each joint at which its friction is predicted within its band."""
    rows = results.rows("observability", quantity="least_velocity")
    shares = results.rows("observability", quantity="friction_in_band").dropna(subset="value")
    body = []
    for row in rows.itertuples():
        ranges = shares[(shares["robot"] == row.robot) & (shares["joint"] == row.joint)]
        slower = ranges[~(ranges["speed_low"] >= row.speed_low)]  # all, where no range suffices
        faster = ranges[ranges["speed_low"] >= row.speed_high]
        shown = [
            _share(part) for part in (slower, ranges.drop([*slower.index, *faster.index]), faster)
        ]
        place = [Cell(row.robot), Cell(f"{row.joint:.0f}")]
        body.append([*place, _speed(row.value), _speed(row.speed_high), *shown])
    header = ["arm", "joint", "from [rad/s]", "up to [rad/s]"]
    return Body([*header, "slower: in band [%]", "between [%]", "faster [%]"], body)


def _speed(speed: float) -> Cell:
    return Cell("–" if math.isnan(speed) else f"{speed:g}")


def _share(rows: pd.DataFrame) -> Cell:
    """Return the share [%] of samples within the band over several bins."""
    if rows.empty:
        return Cell("–")
    return Cell(fixed(100 * (rows["value"] * rows["samples"]).sum() / rows["samples"].sum(), 0))


def _push(row: Any) -> Cell:
    if row.value <= MOST:
        return with_error(row.value, row.std_error, 0)
    return Cell(f"> {MOST:.0f}")


def _push_at(row: Any) -> tuple[Sentence, Sentence]:
    """Return the speed at a push, and its force."""
    during = say("observed.during", speeds=flange_speeds(row))
    return during, say("observed.force", force=row.value, most=MOST)
