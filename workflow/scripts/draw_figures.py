"""Figures of one recording, after the thesis's 5.9 to 5.12, 5.14, 5.15 and 6.4."""

from typing import Any

from ur5lib.pipeline.records.accelerations import Accelerations
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.forces import Forces, SensorWrenches
from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.torques import ClosedLoop, Torques
from ur5lib.report import recording_figures as figures
from ur5lib.report.house_style import save
from ur5lib.robots.description import load_robot


def draw_figures(input: Any, output: Any, params: Any) -> None:
    signals, robot = Signals.read(input.signals), load_robot(input.arm)
    closed_loop = ClosedLoop.read(input.closed_loop)
    save(figures.tracking_figure(signals, closed_loop, robot, "q"), output.positions)
    save(figures.tracking_figure(signals, closed_loop, robot, "qd"), output.velocities)
    torques = Torques.read(input.torques)
    save(figures.torque_figure(signals, torques, robot.chosen_model), output.torques)
    accelerations = Accelerations.read(input.accelerations)
    save(figures.acceleration_figure(accelerations), output.accelerations)
    published = figures.published_acceleration_figure(accelerations)
    save(published, output.accelerations_published)
    sensor, forces = SensorWrenches.read(input.sensor), Forces.read(input.forces)
    singular = Kinematics.read(input.kinematics).smallest_singular_value
    hidden = singular < params.min_singular_value
    save(figures.estimate_figure(forces, sensor, hidden), output.forces_estimated)
    currents = Currents.read(input.currents)
    save(figures.current_figure(signals, currents), output.currents)
