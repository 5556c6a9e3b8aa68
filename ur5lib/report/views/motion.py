"""End effector's accelerations compared with the IMU, its calibration, tests of the smoother."""

import pandas as pd

from ur5lib.report.results import Results, with_zero


def drawn(results: Results) -> list[str]:
    """Return the recordings whose acceleration is drawn: with printed errors, or the first."""
    printed = results.shown(results.printed("acceleration_mae"))
    return printed or results.shown(results.listed("acceleration_mae"), 1)


def errors(results: Results) -> pd.DataFrame:
    """Return the errors with and without IMU, and of zero, for recordings with a valid IMU."""
    rows = results.tables["acceleration_mae"]
    rows = rows[~rows["estimate"].str.startswith("euler")]
    rows = rows.assign(value=rows["mae"], zero=rows["zero_mae"])
    return with_zero(rows, "estimate", ["component"])
