"""Frequency response of the study's low-pass filters; in the thesis's study, of its own too."""

from collections.abc import Iterable

import numpy as np

from ur5lib.report.figures.charts import response_panel
from ur5lib.report.figures.house_style import Drawing
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import (
    THESIS_ACCELERATION,
    THESIS_CURRENT,
    Butterworth,
    frequency_response,
)

SAMPLING_RATE = 125.0  # Hz, of the thesis's controller
FILTERED = {
    "motion": "measured motion",
    "accelerations": "accelerations compared",
    "currents": "currents",
}
FILTERED_IN_THESIS = {"published_forces": "the thesis's external torques"}


def draw_filters(lowpass: dict[str, Butterworth], is_thesis: bool) -> dict[str, Drawing]:
    """Return the figure of the filters; lowpass: designs by what is filtered."""
    frequency = np.geomspace(0.1, 0.49 * SAMPLING_RATE, 300)
    filtered = FILTERED | (FILTERED_IN_THESIS if is_thesis else {})
    ours = ((name, lowpass[key]) for key, name in filtered.items())
    theirs = (THESIS_ACCELERATION, THESIS_CURRENT) if is_thesis else ()
    gains = both_ways(frequency, ours) | one_way(frequency, theirs)
    return {"filters": response_panel(frequency, gains)}


def both_ways(frequency: Array, designs: Iterable[tuple[str, Butterworth]]) -> dict[str, Array]:
    """Return the gains (N,) of filters that run forwards and backwards, by their descriptions."""
    return {
        f"{name}: order {order}, {cutoff:g} Hz, both ways": frequency_response(
            frequency, SAMPLING_RATE, order, cutoff
        )
        ** 2
        for name, (order, cutoff) in designs
    }


def one_way(frequency: Array, designs: Iterable[Butterworth]) -> dict[str, Array]:
    """Return the gains (N,) of the thesis's causal filters, by their descriptions."""
    return {
        f"thesis: order {order}, {cutoff:g} Hz, one way": frequency_response(
            frequency, SAMPLING_RATE, order, cutoff
        )
        for order, cutoff in designs
    }
