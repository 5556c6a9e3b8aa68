"""Rigid-body dynamics of one state in microseconds, by Pinocchio, which is an extra."""

from typing import Any

import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import link_tail, rigid_bodies
from ur5lib.timeseries.arrays import Array


class OneState:
    """An arm under one of its link models; states are arrays (n,) [rad, rad/s, rad/s²].

    Each result is an array of its own. Raises ImportError without Pinocchio.
    """

    def __init__(self, robot: Robot, model: str) -> None:
        """Build Pinocchio's model."""
        import pinocchio

        self._pin = pinocchio
        self.model, self.end = pinocchio_model(robot, model)
        self._data = self.model.createData()
        self._above = np.triu(np.ones((self.model.nv, self.model.nv), bool))

    def inverse_dynamics(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return τ = D(q) q̈ + C(q, q̇) q̇ + g(q) (n,) [Nm]."""
        return np.array(self._pin.rnea(self.model, self._data, q, qd, qdd))

    def forward_dynamics(self, q: Array, qd: Array, torque: Array) -> Array:
        """Return q̈ = D⁻¹ (τ - C q̇ - g) (n,) [rad/s²]; torque: (n,) [Nm], less friction."""
        return np.array(self._pin.aba(self.model, self._data, q, qd, torque))

    def gravity(self, q: Array) -> Array:
        """Return g(q) (n,) [Nm]."""
        return np.array(self._pin.computeGeneralizedGravity(self.model, self._data, q))

    def mass_matrix(self, q: Array) -> Array:
        """Return D(q) (n, n) [kg m²], rotors included."""
        found = self._pin.crba(self.model, self._data, q)  # below the diagonal, it is not defined
        return np.where(self._above, found, found.T)

    def jacobian(self, q: Array) -> Array:
        """Return J (6, n) of the velocity [m/s, rad/s] of frame n's origin, base axes."""
        pin = self._pin
        axes = pin.LOCAL_WORLD_ALIGNED
        return np.array(pin.computeFrameJacobian(self.model, self._data, q, self.end, axes))


def pinocchio_model(robot: Robot, model: str) -> tuple[Any, int]:
    """Return an arm as a Pinocchio model, and the number of its frame n in it.

    No URDF is between: its joints have limits, without which Pinocchio counts them as two.
    """
    import pinocchio as pin

    bodies = rigid_bodies(robot, model)
    built, joint, place = pin.Model(), 0, pin.SE3.Identity()
    for k, pose in enumerate(robot.link_poses()):
        joint = built.addJoint(joint, pin.JointModelRZ(), place, f"joint_{k + 1}")
        rotation, position = link_tail(pose)
        center = position + rotation @ bodies.center_of_mass[k]
        tensor = rotation @ bodies.inertia[k] @ rotation.T
        link = pin.Inertia(bodies.mass[k], center, tensor)
        built.appendBodyToJoint(joint, link, pin.SE3.Identity())
        place = pin.SE3(rotation, position)
    end = built.addFrame(pin.Frame(f"frame_{built.nv}", joint, place, pin.FrameType.OP_FRAME))
    built.armature, built.gravity.linear = bodies.rotor_inertia, np.array(robot.gravity)
    return built, end
