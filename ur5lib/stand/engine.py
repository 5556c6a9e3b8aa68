"""The simulation loop: targets, drives, friction and contacts."""

from dataclasses import dataclass

import mujoco
import numpy as np

from ur5lib.errors import InputError
from ur5lib.robots.description import Payload, Robot
from ur5lib.stand.arm import FLANGE, build_arm
from ur5lib.stand.contacts import Contacts
from ur5lib.stand.drive import Drive, drive_of, link_torques
from ur5lib.stand.friction import USUAL, Friction, FrictionParameters, friction_of
from ur5lib.stand.plan import Imu, SimulatedRecording
from ur5lib.stand.trajectories import Targets, plan_targets
from ur5lib.timeseries.arrays import Array

STEP = 0.001  # s, of the integration
SETTLE = 300  # steps simulated before the recording starts
START = 0.5  # largest initial dry friction, as a share of the breakaway torque
PARTS = {  # quantities stored of each step, and their numbers of components
    "q": 6,
    "qd": 6,
    "qdd": 6,
    "motor_torque": 6,
    "friction_torque": 6,
    "contact_torque": 6,
    "wrench": 6,
    "force_sensor": 6,
    "imu": 6,
    "origin": 3,
    "rotation": 9,
}


@dataclass(frozen=True)
class Motion:
    """The true motion and forces, every millisecond.

    time: (N,) [s]; targets; q, qd, qdd: (N, 6); torques: (N, 6) [Nm], of the motors, of friction
    (against the motion) and of contacts: D q̈ + C q̇ + g = motor − friction + contact; wrench:
    (N, 6), environment on link 6 and beyond, base axes, at the origin of frame 6; force_sensor:
    (N, 6), of tool and environment on the flange, at the sensor, its axes; imu: (N, 6), specific
    force [m/s²] and angular rate [rad/s], IMU axes; origin, rotation: of frame 6, (N, 3) [m] and
    (N, 9).
    """

    time: Array
    targets: Targets
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
class Experiment:
    """A simulated arm and its motion.

    robot: with all that it carries; model: name of its true link model; plant: that model in
    MuJoCo; known: the arm as the controller knows it; declared: the payload that the controller was
    given.
    """

    robot: Robot
    model: str
    plan: SimulatedRecording
    plant: mujoco.MjModel
    known: mujoco.MjModel
    declared: Payload | None
    friction: FrictionParameters
    drive: Drive
    motion: Motion


def perform(
    robot: Robot, plan: SimulatedRecording, random: np.random.Generator, tell: bool = True
) -> Experiment:
    """Simulate a plan; random: generator of the initial friction.

    tell: whether the plan's payload is declared to the controller; an undeclared one never is.
    Raises InputError when the arm cannot execute the plan.
    """
    model = plan.model or list(robot.models)[-1]
    if model not in robot.models:
        known = ", ".join(robot.models)
        raise InputError(
            f"{robot.name} has no link model {model!r} to simulate; give one of {known}"
        )
    declared = plan.payload if tell else None
    loaded = robot.carrying(plan.payload).carrying(plan.undeclared_payload)
    mounting = np.deg2rad((plan.imu or Imu()).mounting_deg)
    plant = build_arm(loaded, model, mounting, STEP)
    known = build_arm(robot.carrying(declared), model, mounting, STEP)
    friction = friction_of(robot, plan.friction)
    drive = drive_of(robot, friction)
    rubbing = Friction(friction, random.uniform(-START, START, 6))
    motion = _move(plant, known, loaded, plan, drive, rubbing)
    return Experiment(loaded, model, plan, plant, known, declared, friction, drive, motion)


def _move(
    plant: mujoco.MjModel,
    known: mujoco.MjModel,
    robot: Robot,
    plan: SimulatedRecording,
    drive: Drive,
    friction: Friction,
) -> Motion:
    time: Array = STEP * np.arange(round(plan.seconds / STEP) + 1, dtype=np.float64)
    targets = plan_targets(plan.trajectory, robot, time)
    contacts = Contacts(plant, plan.contacts)
    kept = np.empty((len(time), sum(PARTS.values())))
    data, control = mujoco.MjData(plant), Control(known, mujoco.MjData(known), drive)
    data.qpos, data.time = targets.q[0], -SETTLE * STEP
    wanted = [*zip(targets.q, targets.qd, targets.qdd, strict=True)]
    warmth = np.interp(time, time[[0, -1]], plan.temperature_c) - USUAL
    for step in range(-SETTLE, len(time)):
        now = max(step, 0)
        _step(plant, data, control, friction, contacts, wanted[now], warmth[now], kept[now])
    parts = np.split(kept, np.cumsum(list(PARTS.values()))[:-1], axis=1)
    return Motion(time, targets, *parts)


@dataclass(frozen=True)
class Control:
    """The drives, with the arm as the controller knows it."""

    known: mujoco.MjModel
    data: mujoco.MjData
    drive: Drive

    def torques(self, q: Array, qd: Array, target: tuple[Array, Array, Array]) -> Array:
        """Return the motor torques (6,) [Nm] in the state q [rad], qd [rad/s]."""
        self.data.qpos, self.data.qvel = q, qd
        mujoco.mj_fwdPosition(self.known, self.data)
        mujoco.mj_fwdVelocity(self.known, self.data)
        return self.drive.torques(self.known, self.data, target)


def _step(
    plant: mujoco.MjModel,
    data: mujoco.MjData,
    control: Control,
    friction: Friction,
    contacts: Contacts,
    target: tuple[Array, Array, Array],
    warmth: float,
    row: Array,
) -> None:
    """Advance by one step; write the state before it into `row`, in the order of PARTS."""
    mujoco.mj_step1(plant, data)
    q, qd = data.qpos.copy(), data.qvel.copy()
    motor = control.torques(q, qd, target)
    load = link_torques(plant, data, target[2])
    rubbing = friction.torque(q, qd, load, STEP, warmth)
    contact, wrench = contacts.apply(plant, data, STEP)
    data.qfrc_applied = motor - rubbing
    mujoco.mj_step2(plant, data)
    flange, held, imu = data.body(FLANGE), *np.split(data.sensordata, 2)
    felt = (motor, rubbing, contact, wrench, -held, imu)
    np.concatenate((q, qd, data.qacc, *felt, flange.xpos, flange.xmat), out=row)
