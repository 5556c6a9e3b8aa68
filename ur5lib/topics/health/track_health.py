"""The health of an arm over time: each joint's condition by date, and what changed."""

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from datetime import date
from functools import partial
from typing import NamedTuple

import numpy as np

from ur5lib.identification.samples import path_of
from ur5lib.records.motion import Motion
from ur5lib.records.step import step
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.trajectories import PathStates, group_by_path
from ur5lib.topics.health.changes import (
    FALSE_ALARM_PROBABILITY,
    MIN_DATES,
    DatedSeries,
    find_changes,
    over_spans,
)
from ur5lib.topics.health.rows import Checkup, Condition, Health, JointChange

MIN_TEMPERATURE_RANGE = 1.0  # K; temperature is a covariate if dates differ by more


class TrackedHealth(NamedTuple):
    """The rows of health.csv and health_changes.csv of an arm: each joint's condition by date, and
    what changed.
    """

    health: list[Condition]
    changes: list[JointChange]


@step(
    "arm",
    "health.csv changes=health_changes.csv",
    recordings="contact_free",
    checkups="checkup",
)
def track_health(checkups: Mapping[str, Checkup], motion: Mapping[str, Motion]) -> TrackedHealth:
    """Return the condition of each joint by date, and what changed.

    checkups, motion: of the arm's contact-free recordings.
    """
    dated = {name: one for name, one in checkups.items() if one.date}
    motions = (motion[name] for name in dated)
    paths = (path_of(own.q, own.motor_qd, own.period) for own in motions)
    found = health_of([*dated.values()], paths)
    return TrackedHealth(found.dates, found.changes)


def health_of(checkups: Sequence[Checkup], paths: Iterable[PathStates]) -> Health:
    """Return each quantity by date and its changes; empty with fewer than MIN_DATES dates.

    paths: along which the arm moved, one for each checkup.
    """
    if len({one.date for one in checkups}) < MIN_DATES:
        return Health()
    rows = [*_by_date(checkups, group_by_path(paths))]
    return Health(rows, [*_changes(rows)])


def _by_date(checkups: Sequence[Checkup], paths: Labels) -> Iterator[Condition]:
    """Yield value and standard error of each quantity on each date, ascending.

    paths: label of the path of each checkup. Dates with the same paths form a `group`, as friction
    and noise depend on the path.
    """
    days = defaultdict(list)
    for place in sorted(range(len(checkups)), key=lambda place: checkups[place].date):
        days[checkups[place].date].append(place)
    groups = [frozenset(int(paths[place]) for place in places) for places in days.values()]
    for (day, places), group in zip(days.items(), groups, strict=True):
        yield from _on_date([checkups[place] for place in places], day, groups.index(group))


def _on_date(checkups: Sequence[Checkup], day: str, group: int) -> Iterator[Condition]:
    """Yield the rows of one date."""
    yield Condition(date=day, quantity="lost_frames", value=max(one.lost for one in checkups))
    for joint in range(len(checkups[0].joints)):
        warmth = float(np.mean([one.temperature[joint] for one in checkups]))
        here = partial(Condition, date=day, joint=joint + 1, temperature_c=warmth, group=group)
        for quantity in checkups[0].joints[joint]:
            found = np.array([one.joints[joint][quantity] for one in checkups])
            found = found[np.isfinite(found).all(axis=1)]
            if len(found):
                value, error = together(*found.T)
                yield here(quantity=quantity, value=value, std_error=error)


def together(value: Array, std_error: Array) -> tuple[float, float]:
    """Return the weighted mean of a date's recordings (n,) and its standard error.

    value, std_error: of the recordings (n,). The standard error is the larger of two: from the
    stated errors, and from the scatter.
    """
    weight = 1 / np.maximum(std_error, 1e-9 * np.abs(value) + 1e-300) ** 2
    mean = float(weight @ value / weight.sum())
    scatter = float(weight @ (value - mean) ** 2) / max(1, len(value) - 1)
    return mean, float(np.sqrt(max(1.0, scatter) / weight.sum()))


def _changes(rows: Sequence[Condition]) -> Iterator[JointChange]:
    """Yield the changes of every quantity of every joint."""
    groups = defaultdict(list)
    for row in rows:
        if row.joint is not None:
            groups[row.joint, row.quantity].append(row)
    tested = {key: own for key, own in groups.items() if len(own) >= MIN_DATES}
    for (joint, quantity), own in tested.items():
        for change in find_changes(over_spans(_series(own)), FALSE_ALARM_PROBABILITY / len(tested)):
            dates = {"first": _day(change.first), "last": _day(change.last)}
            found = vars(change) | dates | {"by_temperature": change.explained}
            del found["explained"]
            yield JointChange(**found, joint=joint, quantity=quantity)


def _series(rows: Sequence[Condition]) -> DatedSeries:
    """Return a quantity on all dates, from its rows of health.csv; the temperature is its covariate
    if every date has one.
    """
    day = np.array([date.fromisoformat(row.date).toordinal() for row in rows], dtype=float)
    value, error = (
        np.array([getattr(row, name) for row in rows]) for name in ("value", "std_error")
    )
    warmth = np.array([row.temperature_c for row in rows], dtype=float)
    tells = bool(np.isfinite(warmth).all() and np.ptp(warmth) > MIN_TEMPERATURE_RANGE)
    group = np.array([row.group for row in rows])
    return DatedSeries(day, value, error, warmth if tells else None, group)


def _day(ordinal: float) -> str:
    return date.fromordinal(round(ordinal)).isoformat()
