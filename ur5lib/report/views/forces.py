"""Contact forces compared with the force sensor, their bands, and detected contacts."""

import math
from itertools import product

import numpy as np
import pandas as pd

from ur5lib.force.estimators import GATED, LEADING, NEW, PUBLISHED
from ur5lib.records.arm_state import LARGEST_PUSH
from ur5lib.records.contacts import SPEEDS
from ur5lib.report.results import Results
from ur5lib.timeseries.metrics import NORMAL95

FORCE_COMPONENTS = ["Fx", "Fy", "Fz"]
FORCE_STDS = [f"{name}_std" for name in FORCE_COMPONENTS]
SMALLEST_PUSHES = [f"smallest_push_95_{axis}" for axis in "xyz"]  # of observability.csv
PLACE = ["robot", "state", "axis"]
REPORT_RANK = {
    name: place for place, name in enumerate([*NEW, *PUBLISHED])
}  # in the report's order


def compared(results: Results) -> list[str]:
    """Return recordings with printed errors, with a force sensor, then others with contact."""
    touched = results.with_role("contact", searched(results)["recording"])
    beside = [*results.listed("force_mae"), *results.listed("sensed")]
    return results.shown([*results.printed("force_mae"), *beside, *touched])


def with_moments(results: Results) -> list[str]:
    """Return recordings on which the leading estimate determines a moment in contact."""
    rows = results.rows("force_mae", kind="compensated", during="contact", determined="yes")
    return results.shown([*leading(rows[rows["component"].str.startswith("n")])["recording"]])


def searched(results: Results) -> pd.DataFrame:
    """Return the detections by the estimates of this study, without published ones."""
    return results.rows("detection", estimate=GATED)


def leading(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the leading estimate: the first in the report's order."""
    rank = rows["estimate"].map(REPORT_RANK)
    return rows[rank == rank.min()]


def contact_errors(results: Results, recording: str) -> pd.DataFrame:
    """Return peak, impulse and onset of each contact, with the leading estimate's errors."""
    return leading(results.rows("contact_errors", recording=recording, component="norm"))


def contacts(results: Results, recording: str) -> pd.DataFrame:
    """Return the contacts that the leading estimate finds, with their largest `size` [N] and the
    `least` minimum detectable force of an axis at their speed, NaN where that is unknown.
    """
    rows = results.rows("contacts", recording=recording, estimate=LEADING)
    pushes = results.rows("observability", quantity=SMALLEST_PUSHES)
    pushes = pushes[pushes["robot"] == (results.arms()[recording] if len(pushes) else "")]
    least = pushes.groupby(pushes["speed_low"].map(SPEEDS))["value"].min()
    size = np.sqrt((rows[FORCE_COMPONENTS].astype(float) ** 2).sum(axis="columns"))
    return rows.assign(size=size, least=flange_speeds(rows).map(least).astype(float))


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
    rows = results.rows("contacts", estimate=LEADING, kind="contact", recording=names)
    rows = rows.assign(robot=rows["recording"].map(results.arms()), state=flange_speeds(rows))
    return rows.value_counts(PLACE[:2]).rename("contacts").reset_index()


def flange_speeds(rows: pd.DataFrame) -> pd.Series:
    """Return the range of the flange's speed during each contact, in words."""
    steps, labels = [*SPEEDS, math.inf], [*SPEEDS.values()]
    return pd.cut(rows["flange_speed"], steps, right=False, labels=labels).astype(object)


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
