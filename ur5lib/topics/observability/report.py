"""The report's part on what can be observed: smallest pushes, and at which speeds bands suffice."""

import pandas as pd

from ur5lib.identification.validation import MIN_SHARE_IN_BAND
from ur5lib.judging.contacts import at_sensors
from ur5lib.report.results import Results

AT_REST = ("friction_in_band", "rest_band_factor", "band_at_rest")
LEAST_DRAWN_SPEED = 0.003  # rad/s; the axis of speeds begins there


def smallest_pushes(results: Results) -> pd.DataFrame:
    """Return the smallest pushes [N] that trials find, or did not find."""
    rows = results.rows("pushes")
    return rows[rows["value"].notna() | rows["bound"].eq(">")]


def real_contacts(results: Results) -> pd.DataFrame:
    """Return the contacts at the sensors, at rest or in motion, with their fate and largest force;
    those that the smallest pushes are compared with.
    """
    rows = at_sensors(results)
    return rows.assign(robot=rows["recording"].map(results.arms()))


def by_speed(results: Results) -> pd.DataFrame:
    """Return the shares of each joint's readings within their band by speed, least first; enough:
    the share from which on a band suffices, holds: whether it does; speed [rad/s]: in the middle of
    the range on a logarithmic scale.
    """
    rows = results.rows("observability", quantity="friction_in_band").dropna(subset="value")
    low, high = rows["speed_low"].clip(lower=LEAST_DRAWN_SPEED), rows["speed_high"].astype(float)
    middle = (low * high.fillna(2 * low)) ** 0.5
    holds = (rows["value"] >= MIN_SHARE_IN_BAND).map({True: "yes", False: "no"})
    every = rows.assign(speed=middle, enough=MIN_SHARE_IN_BAND, holds=holds)
    return every.sort_values("value", kind="stable")


def at_rest(results: Results) -> pd.DataFrame:
    """Return by arm and quantity, of its resting joints, the least and the largest value: the share
    within the band, the part of the band that would contain 95 %, its width over that in motion.
    """
    rows = results.rows("observability", speed_low=0.0, quantity=[*AT_REST]).dropna(subset="value")
    return (
        rows.groupby(["robot", "quantity"], sort=False)["value"].agg(["min", "max"]).reset_index()
    )
