"""The report's part on estimates beside the truth: how many intervals hold it."""

import pandas as pd

from ur5lib.report.results import Results

REMARKABLE_CHANCE = (
    0.025  # below this chance, the count of intervals that contain the truth is remarkable
)
SINGLE = ["clock_offset", "clock_drift", "rotor_inertia", "imu_mounting", "imu_tilt", "load"]
SINGLE += ["imu_gyroscope_bias", "imu_place", "torque_constant", "offset", "coulomb", "viscous"]


def intervals(results: Results) -> pd.DataFrame:
    """Return how many stated intervals contain the truth, by quantity."""
    stated = results.rows("truth").dropna(subset="within95")
    groups = stated.assign(inside=stated["within95"] == "yes").groupby("quantity", sort=False)
    return groups["inside"].agg(values="size", inside="sum").reset_index()


def counted(results: Results) -> pd.DataFrame:
    """Return how many stated intervals contain the truth, how many should; too: wide or narrow,
    where the chance of as many or as few is small for independent values.
    """
    stated = results.rows("truth")["within95"].dropna()
    from scipy.special import bdtr, bdtrc  # slow to import, for studies without a truth

    if stated.empty:
        return pd.DataFrame()
    count, inside = len(stated), int((stated == "yes").sum())
    many, few = bdtrc(inside - 1, count, 0.95), bdtr(inside, count, 0.95)
    remarkable = min(many, few) < REMARKABLE_CHANCE
    too = ("wide" if many < few else "narrow") if remarkable else None
    own = {"values": count, "inside": inside, "expected": 0.95 * count, "too": too}
    return pd.DataFrame([own | {"chance": min(many, few)}])


def fitted(results: Results) -> pd.DataFrame:
    """Return the values fitted to several recordings, and those of a recording's clocks."""
    return results.rows("truth", quantity=SINGLE)
