"""The report's part on estimates against the truth: how many intervals contain it."""

import pandas as pd

from ur5lib.report.results import Results
from ur5lib.topics.truth import found

SINGLE = ["clock_offset", "clock_drift", "rotor_inertia", "imu_mounting", "imu_tilt", "load"]
SINGLE += ["imu_gyroscope_bias", "imu_place", "torque_constant", "offset", "coulomb", "viscous"]


def intervals(results: Results) -> pd.DataFrame:
    """Return how many stated intervals contain the truth, by quantity."""
    stated = results.rows("truth").dropna(subset="within95")
    groups = stated.assign(inside=stated["within95"] == "yes").groupby("quantity", sort=False)
    return groups["inside"].agg(values="size", inside="sum").reset_index()


def counted(results: Results) -> pd.DataFrame:
    """Return how many stated intervals contain the truth, as `found.Count`."""
    count = found.counted(results)
    return pd.DataFrame([count] if count else [])


def fitted(results: Results) -> pd.DataFrame:
    """Return the values fitted to several recordings, and those of a recording's clocks."""
    return results.rows("truth", quantity=SINGLE)
