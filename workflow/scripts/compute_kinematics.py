"""Pose of frame 6, its Jacobian, and how near a singularity the arm is, for each sample."""

from typing import Any

import numpy as np
import pandas as pd
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.kinematics import jacobian, link_frames
from ur5lib.robots.description import load_robot
from ur5lib.steps import run_step
from ur5lib.tables import channel, named, read_table, write_table


def compute_kinematics(input: Any, output: Any, params: Any) -> None:
    robot = read_table(input.robot)
    description = load_robot(input.arm)
    arm = build_arm(description, next(iter(description.models)))  # masses do not matter here
    q = torch.from_numpy(channel(robot, "actual_q"))
    rotation, origin = link_frames(arm, q)
    J = jacobian(arm, q).numpy()
    kinematics = {
        "time": robot["time"],
        **named(origin[:, 6].numpy(), "o6"),
        **named(rotation[:, 6].numpy(), "R6"),
        **named(J, "J"),
        "sigma_min": np.linalg.svd(J, compute_uv=False)[:, -1],
    }
    write_table(pd.DataFrame(kinematics), output.kinematics)


if __name__ == "__main__":
    run_step(compute_kinematics, snakemake)  # type: ignore[name-defined]  # noqa: F821
