"""The simulation of a recording: an arm follows the targets of a plan."""

from dataclasses import dataclass

import mujoco
import numpy as np

from ur5lib.robots.description import Payload, Robot
from ur5lib.stand.drive import Drive
from ur5lib.stand.friction import USUAL, FrictionParameters
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import PARTS, SETTLE, STEP, Rig, build_rig
from ur5lib.stand.trajectories import Targets, plan_targets
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class TrueMotion:
    """The true motion and forces, every millisecond.

    time: (N,) [s]; q, qd, qdd: (N, 6); torques: (N, 6) [Nm], of the motors, of friction
    (against the motion) and of contacts: D q̈ + C q̇ + g = motor − friction + contact; wrench:
    (N, 6), environment on link 6 and beyond, base axes, at the origin of frame 6; force_sensor:
    (N, 6), of tool and environment on the flange, at the sensor, its axes; imu: (N, 6), specific
    force [m/s²] and angular rate [rad/s], IMU axes; origin, rotation: of frame 6, (N, 3) [m] and
    (N, 9).
    """

    time: Array
    q: Array
    qd: Array
    qdd: Array
    motor_torque: Array
    friction_torque: Array
    contact_torque: Array
    wrench: Array
    force_sensor: Array
    imu: Array
    origin: Array
    rotation: Array


@dataclass(frozen=True)
class SimulatedMotion(TrueMotion):
    """The true motion and forces, and the targets of the arm."""

    targets: Targets


@dataclass(frozen=True)
class Experiment:
    """A simulated arm and its motion.

    robot: with every payload; model: name of its true link model; plant: that model in MuJoCo;
    nominal: the controller's model of the arm; declared: the payload configured at the controller.
    """

    robot: Robot
    model: str
    plan: SimulatedRecording
    plant: mujoco.MjModel
    nominal: mujoco.MjModel
    declared: Payload | None
    friction: FrictionParameters
    drive: Drive
    motion: SimulatedMotion


def perform(
    robot: Robot, plan: SimulatedRecording, random: np.random.Generator, declare: bool = True
) -> Experiment:
    """Simulate a plan; random: generator of the initial friction.

    declare: whether the controller is given the plan's `payload`; never its `undeclared_payload`.
    Raises InputError when the arm cannot execute the plan.
    """
    rig = build_rig(robot, plan, random, declare)
    return Experiment(
        robot=rig.robot,
        model=rig.model,
        plan=plan,
        plant=rig.plant,
        nominal=rig.nominal,
        declared=rig.declared,
        friction=rig.friction,
        drive=rig.drive,
        motion=_move(rig, plan),
    )


def _move(rig: Rig, plan: SimulatedRecording) -> SimulatedMotion:
    time: Array = STEP * np.arange(round(plan.seconds / STEP) + 1, dtype=np.float64)
    targets = plan_targets(plan.trajectory, rig.robot, time)
    states = np.empty((len(time), sum(PARTS.values())))
    rig.data.qpos, rig.data.time = targets.q[0], -SETTLE * STEP
    rows = [*zip(targets.q, targets.qd, targets.qdd, strict=True)]
    warmth = np.interp(time, time[[0, -1]], plan.temperature_c) - USUAL
    for step in range(-SETTLE, len(time)):
        now = max(step, 0)  # while the arm settles, the first target holds
        rig.step(rows[now], warmth[now], states[now])
    parts = np.split(states, np.cumsum(list(PARTS.values()))[:-1], axis=1)
    return SimulatedMotion(time=time, targets=targets, **dict(zip(PARTS, parts, strict=True)))
