"""Positions and velocities of one recording in closed loop, after the thesis's 5.9 and 5.10."""

from typing import Any

from ur5lib.pipeline.records.closed_loop import ClosedLoop
from ur5lib.pipeline.records.signals import Signals
from ur5lib.report.figures.house_style import save
from ur5lib.report.figures.recording_figures import chosen_gains, tracking_figure
from ur5lib.robots.description import load_robot


def draw_tracking(input: Any, output: Any, params: Any) -> None:
    signals, closed_loop = Signals.read(input.signals), ClosedLoop.read(input.closed_loop)
    gains = chosen_gains(load_robot(input.arm))
    for state, file in (("q", output.positions), ("qd", output.velocities)):
        save(tracking_figure(signals, closed_loop, gains, state), file)
