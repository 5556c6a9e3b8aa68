"""The report's part on an arm's health: how each joint changed over time."""

import pandas as pd

from ur5lib.report.results import Results
from ur5lib.topics.health import found

MIN_TEMPERATURE_EFFECT = 0.5  # %; a smaller effect of temperature is not mentioned


def of_arms(results: Results) -> pd.DataFrame:
    """Return for each arm the number of its dates, the first and the last, whether temperatures
    were recorded, and the largest share of lost frames.
    """
    rows = results.rows("health")
    lost = rows["value"].where(rows["quantity"] == "lost_frames")
    arms = rows.assign(lost=lost).groupby("robot", sort=False)
    own = arms.agg(
        dates=("date", "nunique"),
        first=("date", "min"),
        last=("date", "max"),
        temperatures=("temperature_c", "count"),
        lost=("lost", "max"),
    )
    return own.reset_index()


def paths(results: Results) -> pd.DataFrame:
    """Return the dates on which each path was recorded: path, from 1 on, and days since the first
    date.
    """
    rows = results.rows("health").dropna(subset="group").drop_duplicates(["robot", "date", "group"])
    first = pd.to_datetime(rows.groupby("robot")["date"].transform("min"))
    days = (pd.to_datetime(rows["date"]) - first).dt.days
    return rows[["robot", "date"]].assign(path=rows["group"].astype(int) + 1, days=days)


def changed(results: Results) -> pd.DataFrame:
    """Return the changes as `ranked`, relative to the value before (offsets excepted): part,
    part_error, part_low, part_high; part_by_temperature if it exceeds MIN_TEMPERATURE_EFFECT.
    """
    rows = found.ranked(results)
    before = rows["before"].abs().where(rows["quantity"] != "offset")
    parts = {
        "part": "size", "part_error": "std_error", "part_low": "low", "part_high": "high",
        "part_by_temperature": "by_temperature",
    }  # fmt: skip
    rows = rows.assign(**{part: rows[own] / before for part, own in parts.items()})
    worth = 100 * rows["part_by_temperature"].abs() >= MIN_TEMPERATURE_EFFECT
    return rows.assign(part_by_temperature=rows["part_by_temperature"].where(worth))
