"""Accelerations as published, after Figures 5.14 and 5.15."""

from ur5lib.records.accelerations import Accelerations
from ur5lib.records.step import step
from ur5lib.report.figures.house_style import Drawing
from ur5lib.topics.thesis.figure import euler_figure


@step("recording", "accelerations_published.svg")
def draw_published_accelerations(accelerations: Accelerations) -> dict[str, Drawing]:
    """Return by name the figure of the acceleration through Euler angles and the IMU's, both with a
    causal filter.
    """
    felt, modelled = accelerations.causal_felt, accelerations.causal.get("euler")
    return {"accelerations_published": euler_figure(accelerations, felt, modelled)}
