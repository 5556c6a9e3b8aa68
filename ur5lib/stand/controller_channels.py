"""The controller's channels: its measurements, and quantities by its model of the arm."""

from typing import NamedTuple

import mujoco
import numpy as np
import pandas as pd
from scipy.signal import butter, lfilter

from ur5lib.channels import SIGNED_CHANNELS, TORQUE
from ur5lib.robots.description import Payload
from ur5lib.robots.drives import as_counted
from ur5lib.robots.mjcf import flange
from ur5lib.stand.drive import Drive, current_noise, motion_share
from ur5lib.stand.friction import along_chain
from ur5lib.stand.rig import STEP, Experiment, Rig, States, step_times
from ur5lib.stand.torque_sensors import TorqueSensors
from ur5lib.stand.trajectories import Targets
from ur5lib.tables import named
from ur5lib.timeseries.arrays import Array

DECIMALS = 6  # of all channels, as in the thesis's logs
ENCODER_COUNTS = 2**19  # per turn of an encoder
# Noise of moving joints, like the real residuals against the targets.
POSITION_NOISE = np.array([5e-5, 4e-5, 6e-5, 15e-5, 9e-5, 15e-5])  # rad
VELOCITY_NOISE = np.array([0.004, 0.006, 0.005, 0.025, 0.011, 0.033])  # rad/s
VELOCITY_WINDOW = 4  # velocity is averaged over this many steps, which delays it by 2 ms
FORCE_CUTOFF = 5.0  # Hz; cut-off of the controller's force estimate
SINGULARITY_DAMPING = 0.02**2 * np.eye(6)  # of that estimate, near singularities
TEMPERATURE_STEP = 1 / 16  # °C


class Measurement(NamedTuple):
    """The joints' measured angles [rad], speeds [rad/s] and motor currents [A], (..., n) each."""

    q: Array
    qd: Array
    current: Array


def frames(
    experiment: Experiment, cycle: float, random: np.random.Generator | None
) -> pd.DataFrame:
    """Return the controller's frames: `time` [s] and its channels under RTDE names.

    cycle: [s]; random: generator of the noise, None for no noise.
    """
    rig, states = experiment.rig, experiment.motion
    q = states["q"]  # the arm rests before the first state
    before = np.concatenate([np.repeat(q[:1], VELOCITY_WINDOW, axis=0), q[:-VELOCITY_WINDOW]])
    measured = measure(rig.drive, states, before, random)
    sent = slice(None, None, round(cycle / STEP))
    time, estimate = step_times(len(states))[sent], ForceEstimate(cycle)
    targets = Targets(*(part[sent] for part in experiment.targets))
    measured = Measurement(*(part[sent] for part in measured))
    values = channels(rig, states[sent], measured, targets, estimate)
    if rig.robot.measured == TORQUE:
        values = TorqueSensors.of(rig.robot).channels(values, states[sent], random)
    temperature = rounded_temperature(experiment.plan.temperature(time))
    values["joint_temperatures"] = np.repeat(temperature[:, None], q.shape[1], axis=1)
    columns = {"time": np.round(time, DECIMALS)}
    counted = {
        name: as_counted(name, values[name], rig.robot)
        for name in SIGNED_CHANNELS
        if name in values
    }
    for name, numbers in (values | counted).items():
        columns |= named(np.round(numbers, DECIMALS), name)
    for name, constant in payload_channels(rig.declared).items():
        rows = np.tile(constant, (len(time), 1))
        columns |= {name: rows[:, 0]} if rows.shape[1] == 1 else named(rows, name)
    return pd.DataFrame(columns)


def measure(
    drive: Drive, states: States, before: Array, random: np.random.Generator | None
) -> Measurement:
    """Return the measurements of true states (...): angles in encoder counts, speeds by
    differences.

    before: angles VELOCITY_WINDOW steps earlier (..., n) [rad]; random: generator of the noise,
    None for the true values.
    """
    q, qd = states["q"], states["qd"]
    current = states["motor_torque"] / drive.torque_constant
    if random is None:
        return Measurement(q, qd, current)
    noise = motion_share(qd) * random.normal(size=(2, *q.shape))
    of_q, of_qd = (along_chain(size, q.shape[-1]) for size in (POSITION_NOISE, VELOCITY_NOISE))
    count = 2 * np.pi / ENCODER_COUNTS
    return Measurement(
        q=count * np.rint((q + of_q * noise[0]) / count),
        qd=(q - before) / (VELOCITY_WINDOW * STEP) + of_qd * noise[1],
        current=current + current_noise(q, qd, random),
    )


def channels(
    rig: Rig, states: States, measured: Measurement, targets: Targets, estimate: "ForceEstimate"
) -> dict[str, Array]:
    """Return the controller's channels by their RTDE names, (..., n) or (..., 6), in base axes, for
    true states (...).

    The controller estimates a wrench from currents minus the torques of its model and its friction.
    `actual_TCP_force` is this wrench, of the arm on its environment. For an arm with a wrist
    sensor, `wrench_calc_from_currents` is its opposite, of the environment on the arm, and
    `actual_TCP_force` is zero until the sensor's readings replace it.
    """
    drive, moment = rig.drive, model_torques(rig, targets)
    jacobian = jacobians(rig, states["q"])
    friction = drive.known_friction(targets.qd)
    external = drive.torque_constant * measured.current - (moment + friction)
    force = estimate.update(jacobian, external)
    forces = {"actual_TCP_force": force}
    target_friction = drive.viscous * targets.qd  # in the target current of a real UR5
    if rig.robot.wrist_sensor:  # on a real UR5e, model and both terms explain over 99.7 % of it
        target_friction = friction
        forces = {"actual_TCP_force": np.zeros_like(force), "wrench_calc_from_currents": -force}
    return {
        "target_q": targets.q,
        "target_qd": targets.qd,
        "target_qdd": targets.qdd,
        "target_current": (moment + target_friction) / drive.torque_constant,
        "target_moment": moment,
        "actual_q": measured.q,
        "actual_qd": measured.qd,
        "actual_current": measured.current,
        **forces,
        "actual_TCP_pose": poses(states["origin"], states["rotation"]),
        "actual_TCP_speed": (jacobian @ measured.qd[..., None])[..., 0],
    }


def rounded_temperature(temperature: Array) -> Array:
    """Return the motors' temperatures [°C], rounded to the sensor's step."""
    return TEMPERATURE_STEP * np.rint(temperature / TEMPERATURE_STEP)


def payload_channels(declared: Payload | None) -> dict[str, Array]:
    """Return RTDE's channels of the payload configured at the controller, empty without one."""
    if declared is None:
        return {}
    return {
        "payload": np.array([declared.mass]),
        "payload_cog": np.array(declared.center_of_mass),
        "payload_inertia": np.array(declared.inertia),
    }


def model_torques(rig: Rig, motion: Targets) -> Array:
    """Return the controller's inverse dynamics (..., n) [Nm] of a motion, with rotors and the
    declared payload.
    """
    data, torques = rig.nominal_data, np.empty_like(motion.q)
    states = zip(*map(np.atleast_2d, motion), strict=True)
    for torque, (data.qpos, data.qvel, data.qacc) in zip(
        np.atleast_2d(torques), states, strict=True
    ):
        mujoco.mj_inverse(rig.nominal, data)
        torque[:] = data.qfrc_inverse
    return torques


def jacobians(rig: Rig, q: Array) -> Array:
    """Return the geometric Jacobian (..., 6, n) at the flange's origin, base axes; q: (..., n).

    Leaves `rig.nominal_data` in the last posture.
    """
    data, joints = rig.nominal_data, q.shape[-1]
    result, last = np.empty((*q.shape[:-1], 6, joints)), flange(rig.nominal)
    for jacobian, data.qpos in zip(result.reshape(-1, 6, joints), np.atleast_2d(q), strict=True):
        mujoco.mj_kinematics(rig.nominal, data)
        mujoco.mj_comPos(rig.nominal, data)
        mujoco.mj_jacBody(rig.nominal, data, jacobian[:3], jacobian[3:], last)
    return result


def poses(origin: Array, rotation: Array) -> Array:
    """Return origins [m] and rotation vectors [rad] (..., 6); rotation: matrices (..., 9)."""
    result, quaternion = np.empty((*origin.shape[:-1], 6)), np.empty(4)
    result[..., :3] = origin
    for pose, matrix in zip(np.atleast_2d(result), np.atleast_2d(rotation), strict=True):
        mujoco.mju_mat2Quat(quaternion, matrix)
        mujoco.mju_quat2Vel(pose[3:], quaternion, 1.0)
    return result


class ForceEstimate:
    """Low-pass filtered wrenches of external torques, at the flange's origin, base axes."""

    def __init__(self, cycle: float) -> None:
        """Begin with no estimate; cycle: time between estimates [s]."""
        self._filter = butter(1, FORCE_CUTOFF, fs=1 / cycle)
        self._first: Array | None = None
        self._memory = np.zeros((1, 6))

    def update(self, jacobian: Array, external: Array) -> Array:
        """Return the next estimates (..., 6) [N, Nm]; jacobian: (..., 6, n), external: torques
        (..., n) [Nm].
        """
        wrench = np.atleast_2d(damped_wrench(external, jacobian))
        if self._first is None:
            self._first = wrench[0]
        slow, self._memory = lfilter(*self._filter, wrench - self._first, axis=0, zi=self._memory)
        return np.reshape(slow + self._first, (*external.shape[:-1], 6))


def damped_wrench(external: Array, jacobian: Array) -> Array:
    """Return the wrenches (..., 6) [N, Nm] of external torques (..., n) [Nm] by damped least
    squares; jacobian: (..., 6, n).
    """
    square = jacobian @ jacobian.mT + SINGULARITY_DAMPING
    return np.asarray(np.linalg.solve(square, jacobian @ external[..., None])[..., 0])
