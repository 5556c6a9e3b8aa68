"""What touches the arm: forces in time, a wall, a spring, a hand."""

from dataclasses import dataclass, field

import mujoco
import numpy as np

from ur5lib.stand.arm import FLANGE, TOOL
from ur5lib.stand.plan import Hand, Load, Push, Spring, Timed, Wall
from ur5lib.timeseries.arrays import Array

Kind = Push | Hand | Spring | Wall | Load

GRASP = 0.2  # s, until a load is lifted, or put down


def _swell(contact: Timed, time: float) -> float:
    """0 where it starts and ends, 1 in the middle."""
    return float(np.sin(np.pi * (time - contact.start_s) / contact.seconds) ** 2)


def _grip(load: Load, time: float) -> float:
    """How much of a load is held: 0 where it starts and ends, 1 in between."""
    since = min(time - load.start_s, load.start_s + load.seconds - time)
    return float(np.sin(np.pi / 2 * min(since / GRASP, 1.0)) ** 2)


@dataclass
class Touch:
    """One contact while it is simulated.

    gravity: (3,) [m/s²], base axes; anchor: where a spring is held, or a hand is [m], once it
    touches; velocity, weight: of a load, in the step before [m/s, N].
    """

    plan: Kind
    gravity: Array
    anchor: Array | None = field(default=None, init=False)
    velocity: Array | None = field(default=None, init=False)
    weight: Array = field(default_factory=lambda: np.zeros(3), init=False)

    def force(
        self, time: float, point: Array, velocity: Array, mobility: Array, step: float
    ) -> Array:
        """On the arm (3,) [N], base axes, at a point [m] that moves [m/s].

        mobility: by which a force there accelerates the point (3, 3) [1/kg].
        """
        contact = self.plan
        if isinstance(contact, Wall):
            return _wall(contact, point, velocity)
        if not contact.start_s <= time <= contact.start_s + contact.seconds:
            return np.zeros(3)
        if isinstance(contact, Push):
            return _swell(contact, time) * np.array(contact.force)
        if isinstance(contact, Load):
            return self._weigh(_grip(contact, time) * contact.mass, velocity, mobility, step)
        return self._pull(contact, time, point, velocity, step)

    def _weigh(self, mass: float, velocity: Array, mobility: Array, step: float) -> Array:
        """Weight and inertia of a mass at the point: f = m (g − a), a = a_free + W f.

        a_free, without the mass, is that of the step before: so any mass is stable.
        """
        before = velocity if self.velocity is None else self.velocity
        free = (velocity - before) / step - mobility @ self.weight
        self.velocity = velocity
        held = np.linalg.solve(np.eye(3) + mass * mobility, mass * (self.gravity - free))
        self.weight = held.astype(np.float64)
        return self.weight

    def _pull(
        self,
        contact: Hand | Spring,
        time: float,
        point: Array,
        velocity: Array,
        step: float,
    ) -> Array:
        """Of a spring and damper whose far end is drawn away and, if a hand's, follows."""
        swell = _swell(contact, time)
        anchor = point.copy() if self.anchor is None else self.anchor
        follows = np.zeros(3)
        if isinstance(contact, Hand):
            follows = (point - anchor) / contact.lag_s
        self.anchor = anchor + follows * step
        stretch = anchor + swell * np.array(contact.displacement) - point
        # It takes hold and lets go softly: a jump of the force is no hand's.
        hold = min(1.0, 4 * swell)
        pull = contact.stiffness_n_m * stretch + contact.damping_ns_m * (follows - velocity)
        return hold * pull


def _wall(wall: Wall, point: Array, velocity: Array) -> Array:
    """It pushes and never pulls."""
    normal = np.array(wall.normal) / np.linalg.norm(wall.normal)
    depth = float(normal @ (np.array(wall.through) - point))
    if depth <= 0:
        return np.zeros(3)
    push = wall.stiffness_n_m * depth - wall.damping_ns_m * float(normal @ velocity)
    return max(push, 0.0) * normal


class Contacts:
    """All contacts of a recording, put onto the arm step by step."""

    def __init__(self, model: mujoco.MjModel, contacts: list[Kind]) -> None:
        self._touches = [Touch(contact, model.opt.gravity.copy()) for contact in contacts]
        self._flange = model.body(FLANGE).id
        self._bodies = [
            model.body(TOOL if touch.plan.link == 6 else f"link_{touch.plan.link}").id
            for touch in self._touches
        ]
        self._jacobian = np.zeros((3, model.nv))

    def apply(self, model: mujoco.MjModel, data: mujoco.MjData, step: float) -> tuple[Array, Array]:
        """Put the forces of this instant onto the bodies.

        Returns the joint torques that stand for all of them (6,) [Nm], and the wrench of those on
        link 6 and beyond (6,) [N, Nm]: environment on arm, base axes, at the origin of frame 6.
        """
        torque, wrench = np.zeros(6), np.zeros(6)
        data.xfrc_applied[:] = 0
        for touch, body in zip(self._touches, self._bodies, strict=True):
            point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ touch.plan.point
            mujoco.mj_jac(model, data, self._jacobian, None, point, body)
            velocity, mobility = self._jacobian @ data.qvel, self._mobility(model, data)
            force = touch.force(data.time, point, velocity, mobility, step)
            if not force.any():
                continue
            moment = np.cross(point - data.xipos[body], force)
            data.xfrc_applied[body] += np.concatenate([force, moment])
            torque += force @ self._jacobian
            if touch.plan.link == 6:
                wrench[:3] += force
                wrench[3:] += np.cross(point - data.xpos[self._flange], force)
        return torque, wrench

    def _mobility(self, model: mujoco.MjModel, data: mujoco.MjData) -> Array:
        """W = J M⁻¹ Jᵀ (3, 3) [1/kg] of the point whose Jacobian was computed last."""
        solved = np.empty_like(self._jacobian)
        mujoco.mj_solveM(model, data, solved, self._jacobian)
        return solved @ self._jacobian.T
