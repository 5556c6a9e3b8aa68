"""Frequency response of the study's low-pass filters; in the thesis's study, of its own too."""

from typing import Any

import numpy as np

from ur5lib.report.figures.charts import response_panel
from ur5lib.report.figures.house_style import save
from ur5lib.timeseries.lowpass import THESIS_ACCELERATION, THESIS_CURRENT, frequency_response

RATE = 125.0  # Hz, of the thesis's controller
FILTERED = {
    "motion": "measured motion",
    "accelerations": "accelerations compared",
    "currents": "currents",
}


def draw_filters(input: Any, output: Any, params: Any) -> None:
    frequency = np.geomspace(0.1, 0.49 * RATE, 300)
    filtered = dict(FILTERED)
    if input.get("reference"):
        filtered["published_forces"] = "the thesis's external torques"
    gains = {
        f"{name}: order {order}, {cutoff:g} Hz, both ways": frequency_response(
            frequency, RATE, order, cutoff
        )
        ** 2
        for key, name in filtered.items()
        for order, cutoff in [params.lowpass[key].values()]
    }
    printed = (THESIS_ACCELERATION, THESIS_CURRENT) if input.get("reference") else ()
    gains |= {
        f"thesis: order {order}, {cutoff:g} Hz, one way": frequency_response(
            frequency, RATE, order, cutoff
        )
        for order, cutoff in printed
    }
    save(response_panel(frequency, gains), output.filters)
