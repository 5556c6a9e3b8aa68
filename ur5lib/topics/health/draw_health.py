"""Each joint's friction, torque constant, offset and noise over time, with their changes."""

import pandas as pd

from ur5lib.records.step import step
from ur5lib.report.figures.house_style import Drawing
from ur5lib.robots.description import Robot
from ur5lib.topics.health.figure import health_figure


@step("arm", "health.svg", arm="described")
def draw_health(arm: Robot, health: pd.DataFrame, changes: pd.DataFrame) -> dict[str, Drawing]:
    """Return the figure of an arm's health; health, changes: its tables."""
    return {"health": health_figure(health, changes, arm.measured)}
