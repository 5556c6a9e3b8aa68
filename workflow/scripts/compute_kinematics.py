"""Pose and Jacobian of frame 6 and its smallest singular value, for each sample."""

from typing import Any

from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.signals import Signals
from ur5lib.robots.description import load_robot


def compute_kinematics(input: Any, output: Any, params: Any) -> None:
    robot = Signals.read(input.robot)
    frames = flange_kinematics(load_robot(input.arm), robot.actual_q)
    Kinematics.of(robot.time, *frames).write(output.kinematics)
