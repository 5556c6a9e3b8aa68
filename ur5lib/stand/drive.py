"""The drives: control of the joints, and noise of the motor currents."""

from dataclasses import dataclass

import mujoco
import numpy as np

from ur5lib.robots.description import Robot
from ur5lib.stand.friction import FrictionParameters, along_chain
from ur5lib.timeseries.arrays import Array

# rad/s; joints then deviate from their targets as much as real ones.
NATURAL_FREQUENCY = np.array([100.0, 130.0, 140.0, 160.0, 200.0, 140.0])
KNOWN_FRICTION_SHARE = 0.8  # share of the friction that the controller knows
MOVING_SPEED = 0.05  # rad/s; at it, a joint has three quarters of the noise of a fast one

# Values of the thesis's UR5, joint by joint: from its target currents at rest, and from its
# currents above 2 Hz: a ripple of two (big joints) or four periods per motor turn, and noise.
# Nm/A, an upper limit for all arms whose motors are a UR's in kind
MAX_TORQUE_CONSTANT = np.array([10.7, 10.7, 10.7, 10.2, 11.9, 10.7])
LARGEST_RATIO = 2.0  # to it; motors with larger constants are of another kind
CURRENT_RIPPLE = np.array([0.50, 0.57, 0.33, 0.27, 0.11, 0.27])  # A, amplitude
# The ripple has this many periods per turn of the joint.
RIPPLE_PERIODS = np.array([202, 202, 202, 404, 404, 404])
CURRENT_NOISE, CURRENT_NOISE_AT_REST = 0.05, 0.01  # A


@dataclass(frozen=True)
class Drive:
    """PD control with feed-forward (Equations 2.69, 2.71); parameters of each joint, (n,).

    position_gain: [1/s²]; velocity_gain: [1/s]; viscous, coulomb: the controller's friction [Nm
    s/rad, Nm]; torque_max: [Nm]; torque_constant: [Nm/A]. As in the target currents of a real UR5,
    the feed-forward contains viscous friction only.
    """

    position_gain: Array
    velocity_gain: Array
    viscous: Array
    coulomb: Array
    torque_max: Array
    torque_constant: Array

    def torques(
        self, model: mujoco.MjModel, data: mujoco.MjData, target: tuple[Array, Array, Array]
    ) -> Array:
        """Return the motor torques (n,) [Nm].

        u = D(q) a + C q̇ + g (2.69), a = q̈ᵈ − K0 (q − qᵈ) − K1 (q̇ − q̇ᵈ) (2.71), plus friction.
        model: the controller's model of the arm; data: with positions and velocities computed;
        target: q [rad], q̇ [rad/s], q̈ [rad/s²].
        """
        q, qd, qdd = target
        feedback = self.position_gain * (q - data.qpos) + self.velocity_gain * (qd - data.qvel)
        correction = np.empty(model.nv)
        mujoco.mj_mulM(model, data, correction, feedback)
        motors = link_torques(model, data, qdd) + correction + self.viscous * qd
        return np.minimum(np.maximum(motors, -self.torque_max), self.torque_max)

    def known_friction(self, qd: Array) -> Array:
        """Return the controller's friction torques (..., n) [Nm]; qd: [rad/s]."""
        # tanh instead of the sign: the current is continuous where the direction reverses
        return self.viscous * qd + self.coulomb * np.tanh(qd / MOVING_SPEED)


def link_torques(model: mujoco.MjModel, data: mujoco.MjData, qdd: Array) -> Array:
    """Return D(q) q̈ + C q̇ + g (n,) [Nm]; data: with positions and velocities computed."""
    torques = np.empty(model.nv)
    mujoco.mj_mulM(model, data, torques, qdd)
    return torques + data.qfrc_bias


def drive_of(robot: Robot, friction: FrictionParameters) -> Drive:
    """Return the drives of an arm; friction: of its joints."""
    joints = len(robot.joints)
    frequency = along_chain(NATURAL_FREQUENCY, joints)
    usual, known = along_chain(MAX_TORQUE_CONSTANT, joints), robot.maker_torque_constants()
    return Drive(
        position_gain=frequency**2,  # (2.74)
        velocity_gain=2 * frequency,
        viscous=KNOWN_FRICTION_SHARE * friction.viscous,
        coulomb=KNOWN_FRICTION_SHARE * friction.coulomb,
        torque_max=np.array(robot.torque_limits()),
        torque_constant=np.where(known > LARGEST_RATIO * usual, known, np.fmin(usual, known)),
    )


def motion_share(qd: Array) -> Array:
    """Return the share of a moving joint's noise, from 0 at rest to 1; qd: [rad/s]."""
    return np.tanh(np.abs(qd) / MOVING_SPEED)


def current_noise(q: Array, qd: Array, random: np.random.Generator) -> Array:
    """Return the ripple and noise of measured currents (N, n) [A]."""
    size, periods = (along_chain(each, q.shape[-1]) for each in (CURRENT_RIPPLE, RIPPLE_PERIODS))
    ripple = size * np.sin(periods * q)
    noise = random.normal(size=q.shape) * (CURRENT_NOISE_AT_REST + CURRENT_NOISE * motion_share(qd))
    return ripple * motion_share(qd) + noise
