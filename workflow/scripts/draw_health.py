"""Each joint's friction, torque constant, offset and noise over time, with what changed."""

from typing import Any

from ur5lib.report.figures.arm_state_figures import health_figure
from ur5lib.report.figures.house_style import save
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_csv


def draw_health(input: Any, output: Any, params: Any) -> None:
    sensed = load_robot(input.arm).senses_torque()
    save(health_figure(read_csv(input.health), read_csv(input.changes), sensed), output.health)
