"""Accelerations in the order of steps that the thesis's errors need, after Figures 5.14, 5.15."""

from typing import Any

from ur5lib.pipeline.records.dynamics import Kinematics
from ur5lib.pipeline.records.signals import Signals
from ur5lib.recordings.quality import Quality
from ur5lib.report.explained_errors import explained_accelerations
from ur5lib.report.figures.house_style import save
from ur5lib.report.figures.recording_figures import euler_figure
from ur5lib.report.reference import read_reference
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, read_table


def draw_filtered_first(input: Any, output: Any, params: Any) -> None:
    signals, kinematics = Signals.read(input.signals), Kinematics.read(input.kinematics)
    robot = load_robot(input.arm).mounted(params.gravity)
    imu, start = read_table(input.imu), read_record(Quality, input.quality).starts["imu"]
    way = read_reference(input.reference).explained_accelerations()[params.recording]
    modelled, felt = explained_accelerations(robot, signals, kinematics, imu, start, way)
    save(euler_figure(signals, felt, modelled), output.accelerations_filtered_first)
