"""The report's part on what can be observed: smallest pushes, and at which speeds bands hold."""

import math
from collections.abc import Iterator
from itertools import product

import pandas as pd

from ur5lib.force.estimators import LEADING
from ur5lib.records.contacts import OF_CONTACTS, SPEEDS
from ur5lib.report.page.sentences import say, spoken
from ur5lib.report.results import AT_REST, Results
from ur5lib.report.views.baseline import MIN_GOOD_COVERAGE
from ur5lib.report.views.contacts import FATES, FORCE_TOPIC, at_sensors, quiet
from ur5lib.report.views.currents import CURRENTS_TOPIC
from ur5lib.report.views.forces import contacts, flange_speeds
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.topics.observability.rows import LARGEST_PUSH

SMALLEST_PUSHES = [f"smallest_push_95_{axis}" for axis in "xyz"]
PLACE = ["robot", "state", "axis"]


def headline(results: Results) -> Iterator[str]:
    """Say from which size on pushes are noticed, where most is needed and in the fastest motion."""
    pushes = hardest_pushes(results).dropna(subset="value")
    if len(pushes):
        moving = easiest_pushes(results, pushes)
        unnoticed = [pushes, *_elsewhere(results, pushes)]
        unnoticed = [part for rows in unnoticed if len(part := rows[rows["bound"] == ">"])]
        words = {"pushes": pushes, "moving": moving, "unnoticed": unnoticed}
        yield say("observability.headline", **words, alone=quiet(results).empty)


def answers(results: Results, card: str) -> Iterator[str]:
    """Say on the card of the force which pushes are noticed, on that of the currents at which
    speeds their bands hold.
    """
    if card == FORCE_TOPIC and not results.stopped() and len(pushes := hardest_pushes(results)):
        words = {"rows": pushes, "others": _elsewhere(results, pushes)}
        yield say("observability.noticed", **words, alone=quiet(results).empty)
    if card == spoken(CURRENTS_TOPIC):
        yield from bands_at_rest(results)
        yield from bands_by_speed(results)


def smallest_pushes(results: Results) -> pd.DataFrame:
    """Return the smallest push [N] along each axis that is detected, by arm and speed of the flange
    (`state`), with its 95 % interval; contacts: found at that speed on recordings with contact.
    """
    rows = results.rows("observability", quantity=SMALLEST_PUSHES)
    tried = results.rows("observability", quantity=LARGEST_PUSH).set_index("robot")["value"]
    margin, most = NORMAL95 * rows["std_error"], rows["robot"].map(tried).astype(float)
    low, high = (rows["value"] - margin).clip(lower=0), rows["value"] + margin
    told = (rows["bound"] == ">") | (low > 0) | (high < most)
    axis, state = rows["quantity"].str[-1], rows["speed_low"].map(SPEEDS)
    value = rows["value"].where(told)
    rows = rows.assign(axis=axis, state=state, value=value, low=low, high=high)
    places = pd.DataFrame(product(rows["robot"].unique(), SPEEDS.values(), "xyz"), columns=PLACE)
    whole = places.merge(rows, "left", PLACE).merge(_touched_by_speed(results), "left")
    whole = whole.fillna({"contacts": 0}).assign(most=whole["robot"].map(tried).astype(float))
    return whole[whole["value"].notna() | (whole["contacts"] > 0)]


def _touched_by_speed(results: Results) -> pd.DataFrame:
    """Return the number of contacts found on recordings with contact, by arm and speed."""
    names = results.with_role("contact")
    rows = results.rows("contacts", estimate=LEADING, kind=OF_CONTACTS, recording=names)
    rows = rows.assign(robot=rows["recording"].map(results.arms()), state=flange_speeds(rows))
    return rows.value_counts(PLACE[:2]).rename("contacts").reset_index()


def hardest_pushes(results: Results) -> pd.DataFrame:
    """Return the smallest pushes at the speed at which the largest are needed, of the speeds at
    which contacts were found, if any.
    """
    rows = smallest_pushes(results)
    rows = rows[rows["contacts"] > 0] if (rows["contacts"] > 0).any() else rows
    needed = rows.groupby(PLACE[:2], sort=False)["value"].max().fillna(math.inf)
    if needed.empty:
        return rows
    robot, state = needed.idxmax()
    return rows[(rows["robot"] == robot) & (rows["state"] == state)]


def easiest_pushes(results: Results, hardest: pd.DataFrame) -> pd.DataFrame:
    """Return the smallest pushes at the highest speed of the same arm, if that is another one."""
    rows = smallest_pushes(results).dropna(subset="value")
    rows = rows[rows["robot"].isin(hardest["robot"])]
    rows = rows[rows["state"] == rows["state"].iloc[-1]] if len(rows) else rows
    return rows[~rows["state"].isin(hardest["state"])]


def _elsewhere(results: Results, pushes: pd.DataFrame) -> list[pd.DataFrame]:
    """Return the smallest pushes of the same arm at its other speeds, a table each."""
    rows = smallest_pushes(results).dropna(subset="value")
    rows = rows[rows["robot"].isin(pushes["robot"]) & ~rows["state"].isin(pushes["state"])]
    return [part for _, part in rows.groupby("state", sort=False)]


def too_small(results: Results) -> Iterator[str]:
    """Say which contacts without a sensor, and how many that are missed at a sensor, are of a
    smaller force than what is noticed at their speed along any axis.
    """
    sensed = at_sensors(results)
    touched = results.with_role("contact", results.rows("contacts", estimate=LEADING)["recording"])
    for recording in sorted({*touched} - {*sensed["recording"]}):
        least = _least_noticed(results, recording)
        alarms = contacts(results, recording)
        small = alarms[alarms["size"] < flange_speeds(alarms).map(least).astype(float)]
        if len(small):
            yield say("observability.hardly", name=recording, times=[*small["peak_s"]])
    for recording, missed in sensed[sensed["fate"] == FATES[-1]].groupby("recording"):
        rests = not results.moving(str(recording))
        least = _least_noticed(results, str(recording))
        least = least[(least.index == AT_REST) == rests]
        small = missed[missed["peak"] < least.min()]
        if len(small):
            yield say("observability.missed", name=recording, count=len(small), of=len(missed))


def _least_noticed(results: Results, recording: str) -> pd.Series:
    """Return the least minimum detectable force [N] of an axis on a recording's arm, by speed."""
    rows = smallest_pushes(results)
    rows = rows[rows["robot"] == results.arms()[recording]]
    return rows.groupby("state")["value"].min().astype(float)


def bands_at_rest(results: Results) -> Iterator[str]:
    """Say how many readings of resting joints the bands hold, and by how much they are too wide."""
    wider, held, factors = (
        results.rows("observability", quantity=name, speed_low=0.0)["value"].dropna().astype(float)
        for name in ("band_at_rest", "friction_in_band", "rest_band_factor")
    )
    if len(wider):
        ends = {"least": factors.min(), "most": factors.max(), "wider": wider}
        yield say("observability.at rest", held=held, **ends)


def bands_by_speed(results: Results) -> Iterator[str]:
    """Say at which speed of which joint the bands hold least, if that is too little."""
    speeds = results.rows("observability", quantity="friction_in_band").dropna(subset="value")
    for row in speeds.sort_values("value", kind="stable")[:1].itertuples():
        if row.value < MIN_GOOD_COVERAGE:
            yield say("observability.by speed", row=row)
