"""What the stated bands of the force estimates hold."""

from typing import Any

import numpy as np

from ur5lib.report.charts import calibration_panels
from ur5lib.report.house_style import ESTIMATES, save
from ur5lib.steps import run_step
from ur5lib.tables import read_csv

BANDS = [50, 80, 95]  # %


def draw_calibration(input: Any, output: Any, params: Any) -> None:
    errors = read_csv(input.errors)
    rows = errors[(errors["kind"] == "compensated") & errors["coverage95"].notna()]
    components = rows["component"].unique()
    held = {
        ESTIMATES[str(estimate)]: 100
        * np.array([part.groupby("component")[f"coverage{b}"].mean()[components] for b in BANDS])
        for estimate, part in rows.groupby("estimate", sort=False)
    }
    save(calibration_panels(BANDS, held, components), output.calibration)


if __name__ == "__main__":
    run_step(draw_calibration, snakemake)  # type: ignore[name-defined]  # noqa: F821
