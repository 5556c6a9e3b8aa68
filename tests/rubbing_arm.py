"""A UR5 with made-up friction, as a fit of its currents states it."""

import numpy as np

from ur5lib.records.friction import CoefficientEstimate, CurrentFit, Friction, JointFit
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.friction import ROOT_LINE

TERMS = ("coulomb", "viscous", "load", "velocity_root")
CONSTANT = np.array([10.0, 11.0, 10.0, 8.0, 8.0, 8.0])  # Nm/A
FRICTION = np.array([5.0, 6.0, 0.06, 1.0])  # of each joint [Nm, ...]
# of the terms: the root's is less its line, which is in the others
COEFFICIENTS = FRICTION + FRICTION[3] * np.array([*ROOT_LINE, 0.0, 0.0])
HELD, OFFSET = -1.0, 0.3  # Nm


def robot() -> Robot:
    """Return the arm under another gravity than upright."""
    return load_robot(robot_path("ur5")).with_rotors().mounted([1.0, -2.0, -9.5])


def friction(arm: Robot) -> Friction:
    """Return its map from torque to current."""
    nothing = np.zeros((4, 2 + len(TERMS)))
    joints = [
        JointFit(
            terms=TERMS,
            distances=(),
            estimate=CoefficientEstimate(
                np.array([1.0, OFFSET, *COEFFICIENTS]) / k, nothing, nothing, nothing[0]
            ),
            held=np.array([HELD]) / k,
            band_moving=0.1,
            band_reversing=0.1,
            band_standing=0.1,
            band_unknown=0.1,
            unseen=nothing[0],
            remarks=(),
        )
        for k in CONSTANT[: len(arm.joints)]
    ]
    return Friction(from_=["one"], fit=CurrentFit(tuple(joints), 5))
