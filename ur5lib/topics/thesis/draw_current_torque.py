"""Currents over torques, with the printed line: Figures 6.1 and 6.2."""

from ur5lib.records.dynamics import Torques
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.report.figures.house_style import Drawing
from ur5lib.robots.description import Robot
from ur5lib.topics.thesis.figure import printed_friction
from ur5lib.topics.thesis.torque_lines import current_torque


@step(
    "recording",
    "current_torque_printed.svg current_torque_friction_printed.svg",
    arm="described",
)
def draw_current_torque(signals: Signals, torques: Torques, arm: Robot) -> dict[str, Drawing]:
    """Return by name Figures 6.1 and 6.2 for a recording: currents over torques, with the printed
    line.
    """
    samples = current_torque(arm, signals, torques)
    rigid, with_friction = printed_friction(samples, arm.current_to_torque)
    return {
        "current_torque_printed": rigid,
        "current_torque_friction_printed": with_friction,
    }
