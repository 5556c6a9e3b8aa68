"""Pose and Jacobian of frame 6 and its smallest singular value, for each sample."""

from typing import Any

import numpy as np

from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import load_robot


def compute_kinematics(input: Any, output: Any, params: Any) -> None:
    robot = Signals.read(input.robot)
    rotation, origin, J = flange_kinematics(load_robot(input.arm), robot.actual_q)
    Kinematics(
        time=robot.time,
        origin=origin,
        rotation=rotation,
        jacobian=J,
        smallest_singular_value=np.linalg.svd(J, compute_uv=False)[:, -1].astype(float),
    ).write(output.kinematics)
