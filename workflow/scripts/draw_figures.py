"""Figures of one recording, after the thesis's 4.4, 5.11, 5.12, 5.14, 5.15 and 6.4."""

from functools import partial
from typing import Any

from ur5lib.pipeline.records.accelerations import Accelerations
from ur5lib.pipeline.records.currents import Currents
from ur5lib.pipeline.records.dynamics import Kinematics, Torques
from ur5lib.pipeline.records.forces import Forces, SensorWrenches
from ur5lib.pipeline.records.signals import Signals
from ur5lib.report.figures import recording_figures as figures
from ur5lib.report.figures.house_style import save
from ur5lib.robots.description import load_robot


def draw_figures(input: Any, output: Any, params: Any) -> None:
    # each figure reads its tables anew, so that none holds those of another
    signals, robot = partial(Signals.read, input.signals), load_robot(input.arm)
    save(figures.packet_figure(signals()), output.packets)
    torques = figures.torque_figure(signals(), Torques.read(input.torques), robot.chosen_model)
    save(torques, output.torques)
    predicted, sensed = Currents.read(input.currents), robot.senses_torque()
    save(figures.current_figure(signals(), predicted, sensed), output.currents)
    accelerations = Accelerations.read(input.accelerations)
    save(figures.acceleration_figure(accelerations), output.accelerations)
    felt, modelled = accelerations.published_felt, accelerations.published.get("euler")
    save(figures.euler_figure(accelerations, felt, modelled), output.accelerations_published)
    singular = Kinematics.read(input.kinematics).smallest_singular_value
    hidden = singular < params.min_singular_value
    forces = Forces.read(input.forces), SensorWrenches.read(input.sensor)
    save(figures.estimate_figure(*forces, hidden), output.forces_estimated)
