"""The report's part on observability: smallest pushes, and the speeds at which bands suffice."""

import pandas as pd

from ur5lib.identification.validation import MIN_SHARE_IN_BAND
from ur5lib.judging.contacts import at_sensors
from ur5lib.report.results import Results

AT_REST = ("friction_in_band", "rest_band_factor", "band_at_rest")
LEAST_DRAWN_SPEED = 0.003  # rad/s; the axis of speeds begins there


def smallest_pushes(results: Results) -> pd.DataFrame:
    """Return the smallest pushes [N] that trials found, and the largest ones tried in vain."""
    rows = results.rows("pushes")
    return rows[rows["value"].notna() | rows["bound"].eq(">")]


def real_contacts(results: Results) -> pd.DataFrame:
    """Return the contacts at the sensors, with motion, fate and largest force, for comparison with
    the smallest pushes.
    """
    rows = at_sensors(results)
    return rows.assign(robot=rows["recording"].map(results.arms()))


def by_speed(results: Results) -> pd.DataFrame:
    """Return the share of each joint's readings within their band by speed, the least first.

    enough: smallest sufficient share; holds: whether it is reached, yes or no; speed: geometric
    mean of the range's ends [rad/s].
    """
    rows = results.rows("observability", quantity="friction_in_band").dropna(subset="value")
    low, high = rows["speed_low"].clip(lower=LEAST_DRAWN_SPEED), rows["speed_high"].astype(float)
    middle = (low * high.fillna(2 * low)) ** 0.5
    holds = (rows["value"] >= MIN_SHARE_IN_BAND).map({True: "yes", False: "no"})
    every = rows.assign(speed=middle, enough=MIN_SHARE_IN_BAND, holds=holds)
    return every.sort_values("value", kind="stable")


def at_rest(results: Results) -> pd.DataFrame:
    """Return the least and the largest value over an arm's resting joints of each quantity: share
    within the band, multiple of the band that contains 95 %, width at rest / width in motion.
    """
    rows = results.rows("observability", speed_low=0.0, quantity=[*AT_REST]).dropna(subset="value")
    return (
        rows.groupby(["robot", "quantity"], sort=False)["value"].agg(["min", "max"]).reset_index()
    )
