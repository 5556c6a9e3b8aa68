"""Judge the live estimator of an arm by its found contacts and its false alarms."""

from collections.abc import Iterable, Iterator, Mapping
from datetime import date
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ur5lib.force.sensed_contact import CONTACT_FORCE
from ur5lib.force.touched import touched
from ur5lib.judging.contacts import (
    EVERY_DAY,
    FARTHEST,
    counted,
    days_between,
    in_all,
    of_days,
    rates,
)
from ur5lib.records.force_errors import Compared
from ur5lib.records.prediction import Prediction
from ur5lib.records.quality import Quality
from ur5lib.records.step import step
from ur5lib.records.verdicts import Verdict
from ur5lib.topics.live.rows import LiveFalseAlarms

QUESTION, ESTIMATE = "live", "live"
COLUMNS = ["role", "days", "duration", "minutes", "alarms"]  # a recording without contact


class JudgedLive(NamedTuple):
    """The verdicts on the live estimator, and its false alarms."""

    verdicts: list[Verdict]
    false_alarms: list[LiveFalseAlarms]


@step(
    "arm",
    "verdicts=live.verdicts.csv false_alarms=live_false_alarms.csv",
    detection="live_detection",
)
def judge_live(
    detection: Mapping[str, pd.DataFrame],
    quality: Mapping[str, Quality],
    prediction: Mapping[str, Prediction],
    compared: Mapping[str, Compared],
    roles: dict[str, str],
    dates: dict[str, str],
) -> JudgedLive:
    """Return the verdicts on an arm's live estimator: the number of found contacts, and the false
    alarms on recordings without contact and without an undeclared load.

    detection: live_detection.csv by recording; roles, dates (ISO 8601, empty where unknown): of the
    recordings.
    """
    minutes = {name: own.duration_s / 60 for name, own in quality.items()}
    counts = {name: rows.iloc[0] for name, rows in detection.items() if len(rows)}
    quiet = [
        name
        for name in counts
        if not prediction[name].is_loaded and touched(compared[name].sensed, roles[name]) is None
    ]
    days = days_between({name: _day(own) for name, own in dates.items()}, roles)
    free = [
        _time(counts[name], minutes[name]) | {"role": roles[name], "days": days.get(name, np.nan)}
        for name in quiet
    ]
    alarms = [*_false_alarms(pd.DataFrame(free, columns=COLUMNS))]
    unseen = [row for row in alarms if row.role == "validate" and row.days != FARTHEST]
    beside = _beside_contacts(detection, minutes)
    numbers = [*_found(detection.values())]
    numbers += [number for row in unseen for number in rates(row)]
    numbers += _false(beside, [row for row in alarms if row.days == EVERY_DAY])
    verdicts = [Verdict(question=QUESTION, rank=k, **own) for k, own in enumerate(numbers, start=1)]
    return JudgedLive(verdicts, alarms)


def _day(stated: str) -> date | None:
    return date.fromisoformat(stated) if stated else None


def _time(counts: "pd.Series[Any]", duration: float) -> dict[str, Any]:
    """Return a recording's duration [min], the minutes in which the estimator decides on contact,
    and the number of alarms, by name.
    """
    known, alarms = 1 - counts["unknown"], counts["alarms_per_min"]
    return {"duration": duration, "minutes": known * duration, "alarms": alarms * duration}


def _false_alarms(rows: pd.DataFrame) -> Iterator[LiveFalseAlarms]:
    """Yield the false alarms by role (fit, validate) and days (all, without a fit recording,
    farthest from one).
    """
    for role in ("validate", "fit"):
        for when, part in of_days(rows[rows["role"] == role]):
            unknown = 1 - part["minutes"].sum() / part["duration"].sum()
            about: Any = {
                "role": role,
                "estimate": ESTIMATE,
                "days": when,
                "unknown": float(unknown),
            }
            yield LiveFalseAlarms(**about, **counted(part))


def _of_contacts(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the row of live_detection.csv for contacts of at least 5 N at a sensor; empty without
    such contacts.
    """
    return rows[(rows["force_class_n"] == CONTACT_FORCE) & (rows["contacts"] > 0)]


def _found(detection: Iterable[pd.DataFrame]) -> Iterator[dict[str, Any]]:
    """Yield the number of found contacts of at least 5 N at a sensor, as fields of a verdict."""
    rows = [*map(_of_contacts, detection)]
    count, of = (sum(int(own[name].sum()) for own in rows) for name in ("found", "contacts"))
    if of:
        yield {
            "quantity": "contacts found",
            "count": count,
            "of": of,
            "basis": "real",
            "sense": "more",
        }


def _beside_contacts(
    detection: Mapping[str, pd.DataFrame], minutes: Mapping[str, float]
) -> pd.DataFrame:
    """Return the times of recordings with contacts at a sensor, as `_time`, and false alarms on
    them.
    """
    rows = {name: own.iloc[0] for name, of in detection.items() if len(own := _of_contacts(of))}
    times = [
        _time(row, minutes[name]) | {"alarms": round(row["false_alarms_per_min"] * minutes[name])}
        for name, row in rows.items()
    ]
    return pd.DataFrame(times, columns=COLUMNS[2:])


def _false(beside: pd.DataFrame, free: list[LiveFalseAlarms]) -> Iterator[dict[str, Any]]:
    """Yield the false alarms on recordings with contacts at a sensor, if there are such, and on all
    where a sensor or the role shows them, with the minutes of these, as fields of verdicts.
    """
    alarms = int(beside["alarms"].sum())
    if len(beside):
        quantity = "false alarms on recordings with contacts"
        yield {"quantity": quantity, "count": alarms, "sense": "less"}
    if minutes := float(beside["minutes"].sum()) + sum(row.minutes for row in free):
        yield from in_all(alarms + sum(row.alarms for row in free), minutes)
