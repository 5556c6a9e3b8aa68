"""Pose and Jacobian of frame 6 and its smallest singular value, for each sample."""

from typing import Any

import numpy as np

from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.pipeline.records.dynamics import Kinematics
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import load_robot
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import in_chunks


def compute_kinematics(input: Any, output: Any, params: Any) -> None:
    robot = Signals.read(input.robot)

    def smallest_singular_value(J: Array) -> Array:
        return np.linalg.svd(J, compute_uv=False)[:, -1].astype(float)

    rotation, origin, J = flange_kinematics(load_robot(input.arm), robot.actual_q)
    Kinematics(
        time=robot.time,
        origin=origin,
        rotation=rotation,
        jacobian=J,
        smallest_singular_value=in_chunks(smallest_singular_value, J),
    ).write(output.kinematics)
