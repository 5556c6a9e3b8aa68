"""Friction of the simulated joints.

Coulomb friction with stiction and Stribeck effect, a part proportional to the load, viscous
friction, and a torque periodic in the joint's angle, as the flexspline of a harmonic drive causes.
The magnitudes are those of the thesis's UR5 (fits of its currents), relative to a motor's largest
torque, so that they apply to any arm.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.robots.friction import ROOT_LINE
from ur5lib.timeseries.arrays import Array

# Shares of the motor's largest torque, of the UR5's joints from base to wrist:
COULOMB_SHARE = np.array([0.054, 0.058, 0.054, 0.078, 0.083, 0.071])
VISCOUS_SHARE = np.array([0.063, 0.060, 0.038, 0.077, 0.077, 0.048])  # per rad/s
# Per √(rad/s), minus the nearest line, which the other two contain.
ROOT_SHARE = np.array([0.018, 0.009, 0.069, 0.054, 0.034, 0.0])
ROOT_ONSET = 0.02  # rad/s; viscous below, so that steps of a millisecond are stable
LOAD_SHARE = 0.05  # Nm of friction per Nm of load
PERIODIC_SHARE = 0.05  # of the Coulomb friction
STICTION_RATIO = 1.15  # breakaway over Coulomb torque
STRIBECK_VELOCITY = 0.03  # rad/s; at it, stiction has vanished
PRESLIDING_DEFLECTION = 2e-4  # rad; a joint that sticks deflects this far before it slips
USUAL_TEMPERATURE = 30.0  # °C; at which the values above are valid
# Relative change per kelvin: viscous friction of a UR3 and a UR5 is 17 to 20 % lower once the arm
# is warm, and dry friction changes less.
COULOMB_WARMING, VISCOUS_WARMING = -0.003, -0.009  # 1/K


def along_chain(values: Array, joints: int) -> Array:
    """Return values for an arm's joints (joints,), interpolated along the chain from those of the
    UR5's joints, base to wrist (6,).
    """
    if joints == len(values):
        return values
    places = np.linspace(0, len(values) - 1, joints)
    return np.asarray(np.interp(places, np.arange(len(values)), values))


@dataclass(frozen=True)
class FrictionParameters:
    """Friction of an arm's joints, each parameter (n,).

    coulomb: [Nm]; viscous: [Nm s/rad]; velocity_root: [Nm √(s/rad)], beyond its nearest line, see
    `ROOT_LINE`; load: Nm of friction per Nm of load; stiction: ratio of breakaway to Coulomb
    torque; stribeck_velocity: [rad/s], at which stiction has vanished; periodic, phase: of the
    torque periodic cos(q + phase) [Nm, rad]; presliding: [rad], elastic deflection before slip;
    coulomb_warming, viscous_warming: relative change per kelvin [1/K].
    """

    coulomb: Array
    viscous: Array
    velocity_root: Array
    load: Array
    periodic: Array
    stiction: Array
    stribeck_velocity: Array
    phase: Array
    presliding: Array
    coulomb_warming: Array
    viscous_warming: Array

    def dry(self, qd: Array, load: Array, warmth: float = 0.0) -> Array:
        """Return the dry friction of sliding joints (..., n) [Nm].

        qd [rad/s], load [Nm]: (..., n); warmth: [K], above the usual temperature.
        """
        stribeck = (self.stiction - 1) * np.exp(-((qd / self.stribeck_velocity) ** 2))
        coulomb = self.coulomb * (1 + self.coulomb_warming * warmth)
        return coulomb * (1 + stribeck) + self.load * np.abs(load)

    def changed(
        self, coulomb: Array | Sequence[float] | float, viscous: Array | Sequence[float] | float
    ) -> Self:
        """Return the friction with factors on Coulomb and viscous friction, (n,) or one for all."""
        return replace(
            self,
            coulomb=self.coulomb * np.asarray(coulomb),
            viscous=self.viscous * np.asarray(viscous),
            velocity_root=self.velocity_root * np.asarray(viscous),
        )


def friction_of(robot: Robot, friction: bool, root: bool = False) -> FrictionParameters:
    """Return the friction of an arm's joints; friction: False for none; root: whether it grows with
    the root of velocity, too.
    """
    largest = np.array(robot.torque_limits()) * friction
    shares = COULOMB_SHARE, VISCOUS_SHARE, PERIODIC_SHARE * COULOMB_SHARE, root * ROOT_SHARE
    coulomb, viscous, periodic, velocity_root = (
        along_chain(share, len(largest)) * largest for share in shares
    )
    each = np.ones(len(largest))
    return FrictionParameters(
        coulomb=coulomb,
        viscous=viscous,
        velocity_root=velocity_root,
        load=LOAD_SHARE * friction * each,
        periodic=periodic,
        stiction=STICTION_RATIO * each,
        stribeck_velocity=STRIBECK_VELOCITY * each,
        phase=np.arange(float(len(largest))),
        presliding=PRESLIDING_DEFLECTION * each,
        coulomb_warming=COULOMB_WARMING * each,
        viscous_warming=VISCOUS_WARMING * each,
    )


class BristleFriction:
    """Friction torque step by step, with the elastic deflection of sticking joints.

    Bristle model of Dahl and LuGre: z' = qd - |qd| z / z_max, with z_max = dry / stiffness, solved
    exactly over a step, so that it is stable at any speed of the joint.
    """

    def __init__(self, parameters: FrictionParameters, start: Array) -> None:
        """Begin with a deflection; start: (n,), initial dry friction, as a share of the breakaway
        torque.
        """
        self._parameters, self._rubs = parameters, bool(parameters.coulomb.any())
        self._stiffness = parameters.coulomb / parameters.presliding
        self._deflection = start * parameters.presliding

    def torque(self, q: Array, qd: Array, load: Array, step: float, warmth: float = 0.0) -> Array:
        """Return the friction (n,) [Nm] against the motion after a step [s]; load: (n,) [Nm].

        warmth: [K], above the usual temperature.
        """
        parameters = self._parameters
        dry = parameters.dry(qd, load, warmth)
        if not self._rubs:
            return dry
        limit = dry / self._stiffness * np.sign(qd)
        decay = np.exp(-np.abs(qd) * step * self._stiffness / dry)
        self._deflection = limit + (self._deflection - limit) * decay
        periodic = parameters.periodic * np.cos(q + parameters.phase)
        viscous = parameters.viscous * (1 + parameters.viscous_warming * warmth)
        direction = self._deflection * self._stiffness / dry
        dry_line, viscous_line = ROOT_LINE
        root = qd / np.sqrt(np.abs(qd) + ROOT_ONSET) - dry_line * direction - viscous_line * qd
        sliding = viscous * qd + parameters.velocity_root * root
        return self._stiffness * self._deflection + sliding + periodic
