"""Contacts of the simulated arm: pushes, a hand, a spring, a wall, a grasped load."""

from dataclasses import dataclass, field

import mujoco
import numpy as np

from ur5lib.robots.mjcf import TOOL_BODY, flange
from ur5lib.stand.plan import Contact, Hand, Load, Push, Spring, Timed, Wall
from ur5lib.timeseries.arrays import Array

GRASP_TIME = 0.2  # s; a load is lifted or put down in this time


def _strength(contact: Timed, time: float) -> float:
    """Return the strength of a contact at a time, as a share of its largest: 0 at its start and
    end, 1 halfway.
    """
    return float(np.sin(np.pi * (time - contact.start_s) / contact.seconds) ** 2)


def _held_share(load: Load, time: float) -> float:
    """Return the share of a load's weight that the arm carries: 0 at both ends, otherwise 1."""
    since = min(time - load.start_s, load.start_s + load.seconds - time)
    return float(np.sin(np.pi / 2 * min(since / GRASP_TIME, 1.0)) ** 2)


def _cross(one: Array, other: Array) -> Array:
    """Return the cross product of two vectors (3,); NumPy's takes a third of a step."""
    (a, b, c), (x, y, z) = one.tolist(), other.tolist()
    return np.array([b * z - c * y, c * x - a * z, a * y - b * x])


@dataclass
class Touch:
    """The state of one contact during the simulation.

    plan: the contact as planned; gravity: (3,) [m/s²], base axes; anchor: far end of a spring, or
    place of a hand [m], set at the first touch; velocity, weight: velocity [m/s] and weight [N] of
    a grasped load at the previous step.
    """

    plan: Contact
    gravity: Array
    anchor: Array | None = field(default=None, init=False)
    velocity: Array | None = field(default=None, init=False)
    weight: Array = field(default_factory=lambda: np.zeros(3), init=False)

    def may_act(self, time: float) -> bool:
        """Return whether the contact may push: a wall always, others during their time."""
        plan = self.plan
        return isinstance(plan, Wall) or plan.start_s <= time <= plan.start_s + plan.seconds

    def force(
        self, time: float, point: Array, velocity: Array, mobility: Array, step: float
    ) -> Array:
        """Return the force (3,) [N], base axes, at a point [m] that moves with velocity [m/s].

        The contact must be one that `may_act`. mobility: acceleration of the point per force on it
        (3, 3) [1/kg].
        """
        contact = self.plan
        if isinstance(contact, Wall):
            return _wall_force(contact, point, velocity)
        if isinstance(contact, Push):
            return _strength(contact, time) * np.array(contact.force)
        if isinstance(contact, Load):
            return self._load_force(
                _held_share(contact, time) * contact.mass, velocity, mobility, step
            )
        return self._spring_force(contact, time, point, velocity, step)

    def _load_force(self, mass: float, velocity: Array, mobility: Array, step: float) -> Array:
        """Return weight and inertial force of a mass at the point: f = m (g − a), a = a_free + W f.

        a_free, the acceleration without the mass, is that of the previous step, which keeps the
        simulation stable for any mass.
        """
        before = velocity if self.velocity is None else self.velocity
        free = (velocity - before) / step - mobility @ self.weight
        self.velocity = velocity
        held = np.linalg.solve(np.eye(3) + mass * mobility, mass * (self.gravity - free))
        self.weight = held.astype(np.float64)
        return self.weight

    def _spring_force(
        self,
        contact: Hand | Spring,
        time: float,
        point: Array,
        velocity: Array,
        step: float,
    ) -> Array:
        """Return the force of a spring and damper with a moving far end; a hand follows the arm."""
        strength = _strength(contact, time)
        anchor = point.copy() if self.anchor is None else self.anchor
        follows = np.zeros(3)
        if isinstance(contact, Hand):
            follows = (point - anchor) / contact.lag_s
        self.anchor = anchor + follows * step
        stretch = anchor + strength * np.array(contact.displacement) - point
        # A hand grasps and lets go gradually, without a jump of the force.
        grip = min(1.0, 4 * strength)
        pull = contact.stiffness_n_m * stretch + contact.damping_ns_m * (follows - velocity)
        return grip * pull


def _wall_force(wall: Wall, point: Array, velocity: Array) -> Array:
    """Return the force of a wall, which pushes and never pulls."""
    normal = np.array(wall.normal) / np.linalg.norm(wall.normal)
    depth = float(normal @ (np.array(wall.through) - point))
    if depth <= 0:
        return np.zeros(3)
    push = wall.stiffness_n_m * depth - wall.damping_ns_m * float(normal @ velocity)
    return max(push, 0.0) * normal


class Contacts:
    """All contacts of a recording, applied to the arm step by step."""

    def __init__(self, model: mujoco.MjModel, contacts: list[Contact]) -> None:
        self._touches: list[Touch] = []
        self._bodies: list[int] = []
        for contact in contacts:
            self.add(model, contact)
        self.flange, self._tool = flange(model), model.body(TOOL_BODY).id
        self._jacobian = np.zeros((3, model.nv))

    def add(self, model: mujoco.MjModel, contact: Contact) -> None:
        """Add a contact to those of the recording."""
        self._touches.append(Touch(contact, model.opt.gravity.copy()))
        on_tool = contact.link in (None, model.nv)
        self._bodies.append(model.body(TOOL_BODY if on_tool else f"link_{contact.link}").id)

    def apply(self, model: mujoco.MjModel, data: mujoco.MjData, step: float) -> tuple[Array, Array]:
        """Apply the forces of this instant to the bodies.

        Returns the joint torques of all of them (n,) [Nm], and the wrench of those on the tool (6,)
        [N, Nm]: environment on arm, base axes, at the origin of the flange's frame.
        """
        torque, wrench = np.zeros(model.nv), np.zeros(6)
        if not self._touches:
            return torque, wrench
        solved = np.empty_like(self._jacobian)
        data.xfrc_applied[:] = 0
        for touch, body in zip(self._touches, self._bodies, strict=True):
            if not touch.may_act(data.time):
                continue
            point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ touch.plan.point
            mujoco.mj_jac(model, data, self._jacobian, None, point, body)
            velocity = self._jacobian @ data.qvel
            mujoco.mj_solveM(model, data, solved, self._jacobian)
            mobility = solved @ self._jacobian.T  # W = J M⁻¹ Jᵀ
            force = touch.force(data.time, point, velocity, mobility, step)
            if not force.any():
                continue
            moment = _cross(point - data.xipos[body], force)
            data.xfrc_applied[body] += np.concatenate([force, moment])
            torque += force @ self._jacobian
            if body == self._tool:
                wrench[:3] += force
                wrench[3:] += _cross(point - data.xpos[self.flange], force)
        return torque, wrench
