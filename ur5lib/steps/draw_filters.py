"""Frequency response of the study's low-pass filters."""

import numpy as np

from ur5lib.report.figures.charts import response_panel
from ur5lib.report.figures.house_style import Drawing
from ur5lib.timeseries.lowpass import Butterworth, frequency_response

SAMPLING_RATE = 125.0  # Hz; of a controller of the CB series
FILTERED = {
    "motion": "measured motion",
    "accelerations": "accelerations compared",
    "currents": "currents",
}


def draw_filters(lowpass: dict[str, Butterworth]) -> dict[str, Drawing]:
    """Return the figure of the filters; lowpass: their designs, by filtered signal."""
    frequency = np.geomspace(0.1, 0.49 * SAMPLING_RATE, 300)
    gains = {}
    for key, name in FILTERED.items():
        order, cutoff = lowpass[key]
        response = frequency_response(frequency, SAMPLING_RATE, order, cutoff)
        gains[f"{name}: order {order}, {cutoff:g} Hz, both ways"] = response**2
    return {"filters": response_panel(frequency, gains)}
