"""Actual over nominal coverage of the force estimates' bands, in contact and free."""

from typing import Any

import pandas as pd

from ur5lib.pipeline.estimators import NEW
from ur5lib.report.figures.charts import calibration_panels
from ur5lib.report.figures.house_style import save
from ur5lib.tables import read_csv
from ur5lib.timeseries.arrays import Array

BANDS = [50, 80, 95]  # %
DURING = {"contact": "in contact", "free": "free"}


def draw_calibration(input: Any, output: Any, params: Any) -> None:
    errors = read_csv(input.errors)
    rows = errors[(errors["kind"] == "compensated") & errors["coverage95"].notna()]
    components = [*rows["component"].unique()]
    held = {
        NEW[str(estimate)]: {
            label: shares_held(part[part["during"] == during], components)
            for during, label in DURING.items()
        }
        for estimate, part in rows.groupby("estimate", sort=False)
    }
    save(calibration_panels(BANDS, held, components), output.calibration)


def shares_held(rows: pd.DataFrame, components: list[str]) -> Array:
    """Return the coverage [%] of bands, (bands, components), averaged over the recordings."""
    mean = rows.groupby("component")[[f"coverage{band}" for band in BANDS]].mean()
    return 100 * mean.reindex(components).to_numpy().T
