"""Arms of one geometry that differ in masses and gravity, each in a state of its own: arrays in,
arrays out.
"""

from collections.abc import Sequence

import numpy as np
import torch

from ur5lib.dynamics import rigid_body
from ur5lib.dynamics.arm import geometry
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import inertial_parameters, rigid_bodies
from ur5lib.timeseries.arrays import Array, Labels


class ManyArms:
    """M arms of n joints and of one geometry, with their equations of motion D q̈ + h = τ.

    q, qd are arrays (M, n) [rad, rad/s], one state of each arm.
    """

    def __init__(
        self, kinds: Sequence[tuple[Robot, str]], of: Labels, rotors: Array | float = 0.0
    ) -> None:
        """Take the kinds of arms, a description and one of its link models each.

        of: (M,), the kind of each arm, by its place among them; rotors: (M, n) [kg m²], added to
        those of the link models. Raises KeyError where an arm has no link model of this name.
        """
        robot = kinds[0][0]
        self.geometry = geometry(robot)._replace(gravity=(0.0, 0.0, 0.0))  # each has its own
        parameters = [inertial_parameters(arm, rigid_bodies(arm, model)) for arm, model in kinds]
        each = np.array(parameters)[of]
        each[:, -len(robot.joints) :] += rotors
        self._parameters = torch.from_numpy(np.ascontiguousarray(each.T))
        gravity = np.array([arm.gravity for arm, _ in kinds])[of]
        self._gravity = torch.from_numpy(np.ascontiguousarray(gravity.T))

    def equation_of_motion(self, q: Array, qd: Array) -> tuple[Array, Array]:
        """Return D(q) (M, n, n) [kg m²], rotors included, and h = C(q, q̇) q̇ + g(q) (M, n) [Nm]."""
        found = rigid_body.equation_of_motion(
            self.geometry, self._parameters, self._gravity, *map(torch.from_numpy, (q, qd))
        )
        matrix, bias = (values.numpy() for values in found)
        return matrix, bias
