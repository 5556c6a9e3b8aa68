"""End effector's accelerations compared with the IMU, its calibration, tests of the smoother."""

import pandas as pd

from ur5lib.report.results import Results, with_zero
from ur5lib.report.topics import shown_first

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


def drawn(results: Results) -> list[str]:
    """Return the recordings that the figures of accelerations show: those that topics ask for, or
    else the first with errors.
    """
    first = results.shown(shown_first(results, "acceleration_mae"))
    return first or results.shown(results.listed("acceleration_mae"), 1)


def errors(results: Results) -> pd.DataFrame:
    """Return the errors with and without IMU, and of zero, for recordings with a valid IMU."""
    rows = results.tables["acceleration_mae"]
    rows = rows[~rows["estimate"].str.startswith("euler")]
    rows = rows.assign(value=rows["mae"], zero=rows["zero_mae"])
    return with_zero(rows, "estimate", ["component"])


def by_estimate(results: Results) -> pd.DataFrame:
    """Return `errors` with a row for each recording and estimate, and a column for each component
    of the acceleration.
    """
    rows = errors(results)
    keys = {"index": ["recording", "estimate"], "columns": "component", "values": "value"}
    return rows.pivot_table(**keys, sort=False).reset_index()


def judged(results: Results) -> pd.DataFrame:
    """Return the judged errors of the acceleration, the linear ones of each arm first."""
    rows = results.rows("judged_errors", question="motion")
    rank = {name: place for place, name in enumerate(COMPONENTS)}
    order = rows.assign(rank=rows["component"].map(rank)).sort_values(["robot", "rank"])
    return rows.loc[order.index]
