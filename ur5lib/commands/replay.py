"""`ur5 replay`: the torques of a model file along a recording, compared with its currents."""

from collections.abc import Iterator
from pathlib import Path

import mujoco
import numpy as np

from ur5lib.commands.exported import motor_torque
from ur5lib.errors import InputError
from ur5lib.finished import FinishedStudy
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Torques
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import zero_phase_lowpass
from ur5lib.timeseries.segments import DEAD_ZONE, by_segment

DISABLED_FLAGS = mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_LIMIT
LOWPASS_ORDER, CUTOFF_HZ = 4, 2.0  # Hz; above, measured currents are mostly noise


def replayed(file: Path, results: Path, name: str) -> Iterator[str]:
    """Yield lines of a table: root mean square errors [Nm] of low-passed torques in motion against
    the torque of the currents, by a model file, the maker's model and the study's prediction.

    file: MJCF or URDF of the arm, as MuJoCo reads them, with the recording's payload; results:
    results/<study>; name: of the recording. Raises InputError for missing results.
    """
    study = FinishedStudy(results)
    recording = study.recording(name)
    robot = recording.arm.known_as
    arm, friction = study.arm(robot), study.parameters(Friction, robot, "friction")
    signals, motion = study.record(Signals, name), study.record(Motion, name)
    torques, currents = study.record(Torques, name), study.record(Currents, name)
    if currents.predicted_current is None or signals.actual_current is None:
        raise InputError(f"no current was predicted on {name}; see the report of {results}")
    fit = friction.fit_for(name)
    measured = motor_torque(fit, signals.actual_current)
    maker, gravity = arm.chosen_model, arm.mounted(recording.known_gravity()).gravity
    compared = {
        file.name: inverse_dynamics(file, motion, np.array(gravity)),
        f"maker's model ({maker})": torques.measured[maker] + torques.payload_torque,
        "this study's prediction": motor_torque(fit, currents.predicted_current),
        "zero": np.zeros_like(measured),
    }
    rate = 1 / signals.period
    still = np.abs(motion.qd) < DEAD_ZONE
    yield f"{'torque error [Nm], joint':<40}" + "".join(f"{k:>9}" for k in arm.joint_numbers)
    for label, torque in compared.items():
        error = by_segment(
            zero_phase_lowpass, measured - torque, signals.segment, rate, LOWPASS_ORDER, CUTOFF_HZ
        )
        error[still] = np.nan
        with np.errstate(invalid="ignore"):  # NaN for a joint that rests throughout
            rms = np.sqrt(np.nansum(error**2, axis=0) / np.isfinite(error).sum(axis=0))
        yield f"{label:<40}" + "".join(f"{value:>9.3f}" for value in rms)


def inverse_dynamics(file: Path, motion: Motion, gravity: Array) -> Array:
    """Return the inverse dynamics (N, n) [Nm] of a model file along a motion, by MuJoCo.

    gravity: (3,) [m/s²], base frame. Raises InputError where MuJoCo cannot read the file, or the
    model does not have the motion's n joints.
    """
    try:
        model = mujoco.MjModel.from_xml_path(str(file))
    except ValueError as error:
        raise InputError(f"{file} cannot be read by MuJoCo ({error}); name MJCF or URDF") from error
    if model.nv != motion.q.shape[1]:
        raise InputError(f"{file} has {model.nv} degrees of freedom instead of {motion.q.shape[1]}")
    model.opt.disableflags |= DISABLED_FLAGS
    model.opt.gravity = gravity  # a URDF has none
    data, torque = mujoco.MjData(model), np.empty_like(motion.q)
    states = zip(motion.q, motion.qd, motion.qdd, strict=True)
    for row, (data.qpos, data.qvel, data.qacc) in zip(torque, states, strict=True):
        mujoco.mj_inverse(model, data)
        row[:] = data.qfrc_inverse
    return torque
