"""Pose of frame 6, its Jacobian, and how near a singularity the arm is, for each sample."""

from typing import Any

import numpy as np
import pandas as pd

from ur5lib.dynamics.flange import flange_kinematics
from ur5lib.robots.description import load_robot
from ur5lib.steps import run_step
from ur5lib.tables import channel, named, read_table, write_table


def compute_kinematics(input: Any, output: Any, params: Any) -> None:
    robot = read_table(input.robot)
    rotation, origin, J = flange_kinematics(load_robot(input.arm), channel(robot, "actual_q"))
    kinematics = {
        "time": robot["time"],
        **named(origin, "o6"),
        **named(rotation, "R6"),
        **named(J, "J"),
        "sigma_min": np.linalg.svd(J, compute_uv=False)[:, -1],
    }
    write_table(pd.DataFrame(kinematics), output.kinematics)


if __name__ == "__main__":
    run_step(compute_kinematics, snakemake)  # type: ignore[name-defined]  # noqa: F821
