"""The torque of a load on the flange, per unit of it."""

import numpy as np

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.pipeline.records.motion import Motion
from ur5lib.robots.description import Robot
from ur5lib.robots.urdf import link_tail
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.chunks import in_chunks

LINK_6 = slice(50, 54)  # of π: mass and first moments; a payload is a part of link 6


def load_regressor(robot: Robot, model: str, motion: Motion) -> Array:
    """Return the torque (N, 6, 4) per mass [kg] and first moments [kg m] of a load in frame 6.

    robot: under the recording's gravity. The moments of link 6 in Y of τ = Y π, (N, 6, 66), are
    about its joint: h = m t + R h₆, with the constant transform R, t from there to frame 6.
    """
    rotation, tail = link_tail(robot.link_poses()[5])
    arm = LinkModel(robot, model)

    def per_load(*motion: Array) -> Array:
        mass, moments = np.split(arm.regressor(*motion)[:, :, LINK_6], [1], axis=2)
        return np.concatenate([mass + moments @ tail[:, None], moments @ rotation], axis=2)

    return in_chunks(per_load, motion.q, motion.qd, motion.qdd)
