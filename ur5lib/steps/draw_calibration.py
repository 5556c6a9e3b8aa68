"""Actual over nominal coverage of the force estimates' bands, in contact and free."""

import pandas as pd

from ur5lib.force.estimators import NEW
from ur5lib.report.figures.charts import calibration_panels
from ur5lib.report.figures.house_style import Drawing
from ur5lib.timeseries.arrays import Array

BANDS = [50, 80, 95]  # %
DURING = {"contact": "in contact", "free": "free"}


def draw_calibration(errors: pd.DataFrame) -> dict[str, Drawing]:
    """Return the figure of coverages; errors: the table `force_mae`."""
    rows = errors[(errors["kind"] == "compensated") & errors["coverage95"].notna()]
    components = [*rows["component"].unique()]
    held = {
        NEW[str(estimate)]: {
            label: shares_held(part[part["during"] == during], components)
            for during, label in DURING.items()
        }
        for estimate, part in rows.groupby("estimate", sort=False)
    }
    return {"calibration": calibration_panels(BANDS, held, components)}


def shares_held(rows: pd.DataFrame, components: list[str]) -> Array:
    """Return the coverage [%] of bands, (bands, components), averaged over the recordings."""
    mean = rows.groupby("component")[[f"coverage{band}" for band in BANDS]].mean()
    return 100 * mean.reindex(components).to_numpy().T
