"""Currents over torques, and the printed line between them: Figures 6.1 and 6.2."""

from typing import Any

from ur5lib.pipeline.published_constants import current_torque
from ur5lib.pipeline.records.dynamics import Torques
from ur5lib.pipeline.records.signals import Signals
from ur5lib.report.figures.friction_figures import printed_friction
from ur5lib.report.figures.house_style import save
from ur5lib.robots.description import load_robot


def draw_current_torque(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    samples = current_torque(robot, Signals.read(input.signals), Torques.read(input.torques))
    rigid, with_friction = printed_friction(samples, robot.current_to_torque)
    save(rigid, output.current_torque_printed)
    save(with_friction, output.current_torque_friction_printed)
