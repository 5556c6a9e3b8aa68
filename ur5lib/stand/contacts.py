"""What touches the arm: forces in time, a wall, a spring, a hand."""

from dataclasses import dataclass, field

import mujoco
import numpy as np
from numpy.typing import NDArray

from ur5lib.stand.arm import FLANGE, TOOL
from ur5lib.stand.plan import Hand, Push, Spring, Timed, Wall

Array = NDArray[np.float64]
Kind = Push | Hand | Spring | Wall


def _swell(contact: Timed, time: float) -> float:
    """0 where it starts and ends, 1 in the middle."""
    return float(np.sin(np.pi * (time - contact.start_s) / contact.seconds) ** 2)


@dataclass
class Touch:
    """One contact while it is simulated.

    anchor: where a spring is held, or a hand is [m], once it touches.
    """

    plan: Kind
    anchor: Array | None = field(default=None, init=False)

    def force(self, time: float, point: Array, velocity: Array, step: float) -> Array:
        """On the arm (3,) [N], base axes, at a point [m] that moves [m/s]."""
        contact = self.plan
        if isinstance(contact, Wall):
            return _wall(contact, point, velocity)
        if not contact.start_s <= time <= contact.start_s + contact.seconds:
            return np.zeros(3)
        if isinstance(contact, Push):
            return _swell(contact, time) * np.array(contact.force)
        return self._pull(contact, time, point, velocity, step)

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
        self._touches = [Touch(contact) for contact in contacts]
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
            force = touch.force(data.time, point, self._jacobian @ data.qvel, step)
            if not force.any():
                continue
            moment = np.cross(point - data.xipos[body], force)
            data.xfrc_applied[body] += np.concatenate([force, moment])
            torque += force @ self._jacobian
            if touch.plan.link == 6:
                wrench[:3] += force
                wrench[3:] += np.cross(point - data.xpos[self._flange], force)
        return torque, wrench
