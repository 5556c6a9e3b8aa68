"""The flange: pose of frame 6 and its Jacobian, from joint positions as an array."""

import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.kinematics import jacobian, link_frames
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array


def flange_kinematics(robot: Robot, q: Array) -> tuple[Array, Array, Array]:
    """R_6 (N, 3, 3), o_6 (N, 3) [m] and J_g (N, 6, 6), base frame. q: (N, 6) [rad]."""
    arm = build_arm(robot, robot.chosen_model)  # its masses do not matter here
    positions = torch.from_numpy(q)
    rotation, origin = link_frames(arm, positions)
    return rotation[:, 6].numpy(), origin[:, 6].numpy(), jacobian(arm, positions).numpy()
