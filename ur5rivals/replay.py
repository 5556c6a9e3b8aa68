"""`ur5 replay`: a model file compared with a recording: its torques, and its motion in closed
loop."""

import math
from collections.abc import Iterator, Sequence
from copy import copy
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np

from ur5lib.errors import InputError
from ur5lib.finished import StudyFiles
from ur5lib.identification.currents import motor_torque
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.robots.mjcf import mjcf
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import DEAD_ZONE, by_segment, unbroken

DISABLED_FLAGS = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
LOWPASS_ORDER, CUTOFF_HZ = 4, 2.0  # Hz; above, measured currents are mostly noise
# rad, s; as of the UR5e in MuJoCo Menagerie, 2000 Nm/rad and 400 Nm s/rad on joints of 150 Nm.
SERVO_RANGE, SERVO_TIME = 0.075, 0.2
SIMULATION_STEP = 0.002  # s, at most


def replayed(file: Path, results: Path, name: str) -> Iterator[str]:
    """Yield lines of two tables of root mean square errors in motion: of low-passed torques [Nm]
    against the torque of the currents, by a model file, the maker's model and the study's
    prediction; and of the joints' angles [deg], of both models in closed loop.

    file: MJCF or URDF of the arm, as MuJoCo reads them, with the recording's payload; results:
    results/<study>; name: of the recording. Raises InputError for missing results.
    """
    study = StudyFiles(results)
    recording = study.recording(name)
    robot = recording.arm.known_as
    arm, friction = study.arm(robot), study.parameters(Friction, robot, "friction")
    signals, motion = study.record(Signals, name), study.record(Motion, name)
    torques, currents = study.record(Torques, name), study.record(Currents, name)
    if currents.predicted is None or signals.effort is None:
        signs = study.record(Premises, name).contradictions.stop_signs
        cause = next(iter(signs), None) or friction.stopped or friction.refused
        why = cause.sentence() if cause else f"see the report of {results}"
        raise InputError(f"no current was predicted on {name}: {why}")
    fit = friction.fit_for(name)
    measured = motor_torque(fit, signals.effort)
    loaded = arm.carrying(study.payload(name)).mounted(recording.known_gravity())
    described = "fitted" if arm.links == "fitted" else "maker's"
    gravity, maker = np.array(loaded.gravity), f"{described} model ({arm.chosen_model})"
    model = read_model(file, gravity, len(arm.joints))
    compared = {
        file.name: inverse_dynamics(model, motion),
        maker: torques.measured[arm.chosen_model] + torques.payload_torque,
        "this study's prediction": motor_torque(fit, currents.predicted),
        "zero": np.zeros_like(measured),
    }
    rate, moving = 1 / signals.period, np.abs(motion.qd) >= DEAD_ZONE
    yield _row("torque error [Nm], joint", [str(k) for k in arm.joint_numbers])
    for label, torque in compared.items():
        error = by_segment(
            zero_phase_lowpass, measured - torque, signals.segment, rate, LOWPASS_ORDER, CUTOFF_HZ
        )
        yield _rms(label, error, moving)
    described = mujoco.MjModel.from_xml_string(mjcf(loaded, arm.chosen_model, None))
    yield _row("error in closed loop [deg], joint", [str(k) for k in arm.joint_numbers])
    for label, one in {file.name: model, maker: described}.items():
        error = deviation(one, motion, measured, np.array(arm.torque_limits()), signals.period)
        yield _rms(label, np.degrees(error), moving)


def _row(label: str, cells: Sequence[str]) -> str:
    return f"{label:<40}" + "".join(f"{cell:>9}" for cell in cells)


def _rms(label: str, error: Array, moving: Mask) -> str:
    """Return a row of RMS errors in motion, from errors (N, n): NaN for a joint that rests."""
    square = np.where(moving, error**2, np.nan)
    with np.errstate(invalid="ignore"):
        rms = np.sqrt(np.nansum(square, axis=0) / np.isfinite(square).sum(axis=0))
    return _row(label, [f"{value:.3f}" for value in rms])


def read_model(file: Path, gravity: Array, joints: int) -> mujoco.MjModel:
    """Return a model file as MuJoCo reads it, without contacts and limits.

    gravity: (3,) [m/s²], base frame. Raises InputError where MuJoCo cannot read the file, or the
    model does not have so many joints.
    """
    try:
        model = compiled(file)
    except (ValueError, OSError, ElementTree.ParseError) as error:
        raise InputError(f"{file} cannot be read by MuJoCo ({error}); name MJCF or URDF") from error
    if model.nv != joints:
        raise InputError(f"{file} has {model.nv} degrees of freedom instead of {joints}")
    model.opt.disableflags |= DISABLED_FLAGS
    model.opt.gravity = gravity  # a URDF has none
    return model


def compiled(file: Path) -> mujoco.MjModel:
    """Return a model file as MuJoCo compiles it; of a URDF, the shapes are left out, as their files
    may be missing.
    """
    root = ElementTree.parse(file).getroot()
    if root.tag != "robot":
        return mujoco.MjModel.from_xml_path(str(file))
    for link in root.iter("link"):
        for shape in [*link.findall("visual"), *link.findall("collision")]:
            link.remove(shape)
    return mujoco.MjModel.from_xml_string(ElementTree.tostring(root, encoding="unicode"))


def inverse_dynamics(model: mujoco.MjModel, motion: Motion) -> Array:
    """Return the inverse dynamics (N, n) [Nm] of a model along a motion."""
    data, torque = mujoco.MjData(model), np.empty_like(motion.q)
    states = zip(motion.q, motion.qd, motion.qdd, strict=True)
    for row, (data.qpos, data.qvel, data.qacc) in zip(torque, states, strict=True):
        mujoco.mj_inverse(model, data)
        row[:] = data.qfrc_inverse
    return torque


def deviation(
    model: mujoco.MjModel, motion: Motion, torque: Array, torque_max: Array, period: float
) -> Array:
    """Return the deviation (N, n) [rad] of a simulated arm from a motion with the same torque.

    A servo adds kp (q - q̂) + kd (q̇ - q̇̂), with kp = torque_max / SERVO_RANGE and
    kd = SERVO_TIME kp. The arm starts on each unbroken stretch of the motion, and follows it if the
    model is right.

    torque: (N, n) [Nm], of the motors; torque_max: (n,) [Nm]; period: [s] between samples.
    """
    steps = math.ceil(period / SIMULATION_STEP)
    stiffness = torque_max / SERVO_RANGE
    servo = copy(model)
    servo.opt.disableflags |= DISABLED_FLAGS
    servo.opt.timestep = period / steps
    servo.opt.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    servo.dof_damping.reshape(model.nv, -1)[:, 0] += SERVO_TIME * stiffness
    result = np.full_like(motion.q, np.nan)
    known: Mask = np.all(np.isfinite(np.hstack([motion.q, motion.qd, torque])), axis=1)
    for stretch in unbroken(motion.segment, known):
        if known[stretch.start]:
            q, qd = motion.q[stretch], motion.qd[stretch]
            moments = np.arange(len(q) * steps) / steps
            # MuJoCo's velocities belong to the middle between two positions.
            driving = _at(moments, torque[stretch] + stiffness * q)
            driving += SERVO_TIME * stiffness * _at(moments + 0.5 / steps, qd)
            result[stretch] = _simulated(servo, q[0], qd[0], driving, stiffness)[::steps] - q
    return result


def _at(moments: Array, values: Array) -> Array:
    """Return values (N, n) linearly interpolated at moments (M,) in units of samples."""
    return np.transpose([np.interp(moments, np.arange(len(values)), one) for one in values.T])


def _simulated(
    model: mujoco.MjModel, q: Array, qd: Array, torque: Array, stiffness: Array
) -> Array:
    """Return the angles (M, n) [rad] of an arm under torques (M, n) [Nm] less stiffness q, step by
    step.

    q, qd: (n,) at the start; stiffness: (n,) [Nm/rad].
    """
    data, result = mujoco.MjData(model), np.empty_like(torque)
    data.qpos, data.qvel = q, qd
    for row, applied in zip(result, torque, strict=True):
        row[:] = data.qpos
        data.qfrc_applied = applied - stiffness * data.qpos
        mujoco.mj_step(model, data)
    return result
