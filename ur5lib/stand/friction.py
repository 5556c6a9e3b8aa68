"""Friction of the joints: what the motor must give besides what the links need.

Coulomb friction with stiction and Stribeck's fall, a part that grows with the load, viscous
friction, and a torque that comes and goes over a turn of the joint, as a harmonic drive's
flexspline causes. Sizes as on the thesis's UR5 (fits of its currents), in units of a motor's
largest torque, so that any arm has them.
"""

from dataclasses import dataclass, field

import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

COULOMB = np.array([0.054, 0.058, 0.054, 0.078, 0.083, 0.071])  # of the motor's largest torque
VISCOUS = np.array([0.063, 0.060, 0.038, 0.077, 0.077, 0.048])  # of that, per rad/s
LOAD = np.full(6, 0.05)  # Nm/Nm
PERIODIC = 0.05  # of the Coulomb friction


@dataclass(frozen=True)
class FrictionParameters:
    """Friction of six joints, each parameter (6,).

    coulomb: [Nm]; viscous: [Nm s/rad]; load: Nm of friction per Nm of load; stiction: breakaway
    by Coulomb torque; stribeck_velocity: [rad/s], where stiction is gone; periodic, phase: of what
    a turn brings, periodic cos(q + phase) [Nm, rad]; presliding: [rad], elastic way before slip.
    """

    coulomb: Array
    viscous: Array
    load: Array
    periodic: Array
    stiction: Array = field(default_factory=lambda: np.full(6, 1.15))
    stribeck_velocity: Array = field(default_factory=lambda: np.full(6, 0.03))
    phase: Array = field(default_factory=lambda: np.arange(6.0))
    presliding: Array = field(default_factory=lambda: np.full(6, 2e-4))

    def dry(self, qd: Array, load: Array) -> Array:
        """The dry friction (..., 6) [Nm] at which a joint slides, at a speed, under a load [Nm]."""
        stribeck = (self.stiction - 1) * np.exp(-((qd / self.stribeck_velocity) ** 2))
        return self.coulomb * (1 + stribeck) + self.load * np.abs(load)


def friction_of(robot: Robot, friction: bool) -> FrictionParameters:
    """The friction of an arm's joints; friction: False for none."""
    size = np.array([robot.motor(joint).torque_max for joint in range(1, 7)]) * friction
    return FrictionParameters(
        COULOMB * size, VISCOUS * size, LOAD * friction, PERIODIC * COULOMB * size
    )


class Friction:
    """Friction torque step by step, with the elastic deflection that sticking joints have.

    Dahl's and LuGre's bristles: z' = qd - |qd| z / z_max, with z_max = dry / stiffness, solved
    exactly over a step, so that no step is too long however fast the joint turns.
    """

    def __init__(self, parameters: FrictionParameters, start: Array) -> None:
        """start (6,): the dry friction that is there at rest, as a share of what holds."""
        self._parameters = parameters
        self._stiffness = parameters.coulomb / parameters.presliding
        self._deflection = start * parameters.presliding

    def torque(self, q: Array, qd: Array, load: Array, step: float) -> Array:
        """Friction (6,) [Nm] against the motion after a further step [s]; load: (6,) [Nm]."""
        parameters = self._parameters
        dry = parameters.dry(qd, load)
        if not dry.any():
            return dry
        most = dry / self._stiffness * np.sign(qd)
        decay = np.exp(-np.abs(qd) * step * self._stiffness / dry)
        self._deflection = most + (self._deflection - most) * decay
        periodic = parameters.periodic * np.cos(q + parameters.phase)
        return self._stiffness * self._deflection + parameters.viscous * qd + periodic
