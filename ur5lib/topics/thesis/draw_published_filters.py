"""Frequency response of the low-pass filters of the published numbers."""

import numpy as np

from ur5lib.report.figures.charts import response_panel
from ur5lib.report.figures.house_style import Drawing
from ur5lib.signals.euler_angles import CAUSAL
from ur5lib.timeseries.lowpass import Butterworth, frequency_response

SAMPLING_RATE = 125.0  # Hz; the thesis's controller samples at this rate
CURRENT_LOWPASS = Butterworth(5, 1.454)  # N_b and Ω_c of Section 6.1, which is Hz (erratum 4)


def draw_published_filters(order: int, cutoff: float) -> dict[str, Drawing]:
    """Return the figure of the filters; order, cutoff [Hz]: of the external torques here."""
    frequency = np.geomspace(0.1, 0.49 * SAMPLING_RATE, 300)

    def response(order: int, cutoff: float) -> np.ndarray:
        return frequency_response(frequency, SAMPLING_RATE, order, cutoff)

    ours = f"external torques: order {order}, {cutoff:g} Hz, both ways"
    gains = {ours: response(order, cutoff) ** 2} | {
        f"thesis: order {design.order}, {design.cutoff:g} Hz, one way": response(*design)
        for design in (CAUSAL, CURRENT_LOWPASS)
    }
    return {"filters_published": response_panel(frequency, gains)}
