"""A simulated arm with its drives, friction and contacts, advanced step by step along a plan."""

from dataclasses import dataclass, replace

import mujoco
import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from ur5lib.errors import InputError
from ur5lib.robots.description import Mounting, Payload, Robot
from ur5lib.robots.mjcf import add_arm
from ur5lib.stand.contacts import Contacts
from ur5lib.stand.drive import Drive, drive_of, link_torques
from ur5lib.stand.friction import (
    USUAL_TEMPERATURE,
    BristleFriction,
    FrictionParameters,
    friction_of,
)
from ur5lib.stand.plan import Imu, SimulatedRecording
from ur5lib.stand.trajectories import Targets, plan_targets
from ur5lib.stand.varied_friction import run_factors, varied_torque
from ur5lib.timeseries.arrays import Array

STEP = 0.001  # s; of the integration
SETTLING_STEPS = 300  # steps simulated before anything is recorded
MAX_INITIAL_FRICTION = 0.5  # largest initial dry friction, as a share of the breakaway torque
WRENCH_TYPE = float, 6
MUJOCO_SENSORS = {  # name: MuJoCo type, site where it is mounted
    "force": (mujoco.mjtSensor.mjSENS_FORCE, "force_sensor"),
    "torque": (mujoco.mjtSensor.mjSENS_TORQUE, "force_sensor"),
    "accelerometer": (mujoco.mjtSensor.mjSENS_ACCELEROMETER, "imu"),
    "gyroscope": (mujoco.mjtSensor.mjSENS_GYRO, "imu"),
}
MOUNTING_AT_ORIGIN = Mounting(imu=(0.0, 0.0, 0.0), force_sensor=(0.0, 0.0, 0.0))

States = NDArray[np.void]  # (N,) of `state_type` the arm's joints, every millisecond
Target = tuple[Array, Array, Array]  # q [rad], qd [rad/s], qdd [rad/s²], each (n,)


def state_type(joints: int) -> np.dtype[np.void]:
    """Return the dtype of an arm's state; D q̈ + C q̇ + g = motor − friction + contact."""
    each = float, joints
    return np.dtype(
        [
            ("q", *each),  # rad
            ("qd", *each),  # rad/s
            ("qdd", *each),  # rad/s²
            ("motor_torque", *each),  # Nm
            ("friction_torque", *each),  # Nm, against the motion
            ("contact_torque", *each),  # Nm
            ("wrench", *WRENCH_TYPE),  # environment on the last link, base axes, its frame's origin
            ("force_sensor", *WRENCH_TYPE),  # tool and environment at the sensor, its axes
            ("imu", float, 6),  # specific force [m/s²] and angular rate [rad/s], IMU axes
            ("origin", float, 3),  # of the last link's frame [m]
            ("rotation", float, 9),  # of that frame
        ]
    )


@dataclass(frozen=True)
class Rig:
    """A simulated arm and its state.

    robot: with all payloads; model: name of its true link model; plant, data: that model in MuJoCo
    and its state; nominal, nominal_data: the controller's model of the arm; declared: the payload
    configured at the controller; friction: parameters of the joints' friction; friction_state: that
    friction with its present deflection; drive: control of the joints; contacts: what touches the
    arm.
    """

    robot: Robot
    model: str
    plant: mujoco.MjModel
    data: mujoco.MjData
    nominal: mujoco.MjModel
    nominal_data: mujoco.MjData
    declared: Payload | None
    friction: FrictionParameters
    friction_state: BristleFriction
    drive: Drive
    contacts: Contacts

    def step(self, target: Target, warmth: float, row: Array) -> None:
        """Advance by one step; write the state before the step into `row`, in the order of
        `state_type`.

        warmth: [K], of the motors above the usual temperature.
        """
        mujoco.mj_step1(self.plant, self.data)
        q, qd = self.data.qpos.copy(), self.data.qvel.copy()
        if self.nominal_data is not self.data:
            self.nominal_data.qpos, self.nominal_data.qvel = q, qd
            mujoco.mj_fwdPosition(self.nominal, self.nominal_data)
            mujoco.mj_fwdVelocity(self.nominal, self.nominal_data)
        motor = self.drive.torques(self.nominal, self.nominal_data, target)
        contact, wrench = self.contacts.apply(self.plant, self.data, STEP)
        # The gears transmit the torque of a contact, too.
        load = link_torques(self.plant, self.data, target[2]) - contact
        friction = self.friction_state.torque(q, qd, load, STEP, warmth)
        self.data.qfrc_applied = motor - friction
        mujoco.mj_step2(self.plant, self.data)
        last, sensed = self.contacts.flange, self.data.sensordata
        forces = (motor, friction, contact, wrench, -sensed[:6], sensed[6:])
        frame = self.data.xpos[last], self.data.xmat[last]
        np.concatenate((q, qd, self.data.qacc, *forces, *frame), out=row)


def arm_in_mujoco(robot: Robot, model: str, imu: Imu | None) -> mujoco.MjModel:
    """Return the MuJoCo model of an arm with one of its link models.

    imu: the plan's, None: as usually mounted. Sensor data (12,): force, torque, accelerometer,
    gyroscope, each in its own axes. Force and torque are those of the flange on the tool, at the
    sensor's origin.
    """
    spec = mujoco.MjSpec()
    spec.option.gravity = robot.gravity
    spec.option.timestep = STEP
    spec.option.disableflags = mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    tool = add_arm(spec, robot, model)
    mounting = robot.mounting or MOUNTING_AT_ORIGIN
    turn = Rotation.from_rotvec(np.deg2rad((imu or Imu()).mounting_deg))
    tool.parent.add_site(name="imu", pos=mounting.imu, quat=turn.as_quat(scalar_first=True))
    tool.add_site(name="force_sensor", pos=mounting.force_sensor)
    for name, (kind, site) in MUJOCO_SENSORS.items():
        spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=site)
    return spec.compile()


def build_rig(
    robot: Robot, plan: SimulatedRecording, random: np.random.Generator, declare: bool = True
) -> Rig:
    """Return the arm of a plan; random: generator of what friction varies by.

    declare: whether the controller knows the plan's `payload`; it never knows its
    `undeclared_payload`. Raises InputError when the arm has no such link model or another number of
    joints.
    """
    if misfits := [*plan.misfits(robot.name, len(robot.joints), robot.models)]:
        raise InputError("; ".join(f"`{misfit}" for misfit in misfits))
    model = plan.model or list(robot.models)[-1]
    declared = plan.payload if declare else None
    loaded = robot.carrying(plan.payload).carrying(plan.undeclared_payload)
    plant = arm_in_mujoco(loaded, model, plan.imu)
    nominal = arm_in_mujoco(robot.carrying(declared), model, plan.imu)
    usual = friction_of(robot, plan.friction, plan.root_friction)
    friction = usual.changed(plan.coulomb_factor or 1.0, plan.viscous_factor or 1.0)
    most = MAX_INITIAL_FRICTION
    initial = random.uniform(-most, most, len(robot.joints))
    run = run_factors(len(initial), random) if plan.varied_friction else np.ones(len(initial))
    return Rig(
        robot=loaded,
        model=model,
        plant=plant,
        data=mujoco.MjData(plant),
        nominal=nominal,
        nominal_data=mujoco.MjData(nominal),
        declared=declared,
        friction=friction,
        friction_state=BristleFriction(friction.changed(run, run), initial),
        drive=drive_of(robot, usual),
        contacts=Contacts(plant, plan.contacts),
    )


@dataclass(frozen=True)
class Experiment:
    """A simulated arm and what it did along a plan.

    rig: the arm; motion: its states (N,); targets: of the drives, at each state.
    """

    rig: Rig
    plan: SimulatedRecording
    motion: States
    targets: Targets


def perform(
    robot: Robot, plan: SimulatedRecording, random: np.random.Generator, declare: bool = True
) -> Experiment:
    """Simulate a plan; arguments as of `build_rig`.

    Raises InputError when the arm cannot execute the plan.
    """
    rig = build_rig(robot, plan, random, declare)
    time = step_times(round(plan.seconds / STEP) + 1)
    targets = plan_targets(plan.trajectory, rig.robot, time)
    warmth = plan.temperature(time) - USUAL_TEMPERATURE
    states = np.empty(len(time), state_type(len(robot.joints)))
    rig.data.qpos, rig.data.time = targets.q[0], -SETTLING_STEPS * STEP
    target_rows, rows = [*zip(*targets, strict=True)], as_rows(states)
    mover = rig
    if robot.carrying(rig.declared) == rig.robot:  # then arm and controller share one model
        mover = replace(rig, nominal=rig.plant, nominal_data=rig.data)
    for step in range(-SETTLING_STEPS, len(time)):
        now = max(step, 0)  # while the arm settles, the first target applies
        mover.step(target_rows[now], warmth[now], rows[now])
    if plan.varied_friction:
        load = states["motor_torque"] - states["friction_torque"]
        more = varied_torque(states["q"], states["qd"], load, rig.friction, STEP, random)
        states["motor_torque"] += more
        states["friction_torque"] += more
    return Experiment(rig, plan, states, targets)


def step_times(count: int) -> Array:
    """Return the times of the first steps (count,) [s]."""
    return np.asarray(STEP * np.arange(count, dtype=np.float64))


def as_rows(states: States) -> Array:
    """Return states as an array with a row of numbers for each; both share memory."""
    return states.view(np.float64).reshape(len(states), -1)
