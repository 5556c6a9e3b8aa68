"""Positions and velocities of one recording in closed loop, after the thesis's 5.9 and 5.10."""

from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.report.figures.house_style import Drawing
from ur5lib.robots.description import Robot
from ur5lib.topics.thesis.figure import chosen_gains, tracking_figure
from ur5lib.topics.thesis.records import ClosedLoop


@step("recording", "positions.svg velocities.svg")
def draw_tracking(signals: Signals, closed_loop: ClosedLoop, arm: Robot) -> dict[str, Drawing]:
    """Return by name the figures of a recording's positions and velocities, measured and in closed
    loop.
    """
    known = signals, closed_loop, chosen_gains(arm)
    return {
        "positions": tracking_figure(*known, "q"),
        "velocities": tracking_figure(*known, "qd"),
    }
