"""The channels of the controller, frame by frame."""

import mujoco
import numpy as np
import pandas as pd
from scipy.signal import butter, lfilter
from scipy.spatial.transform import Rotation

from ur5lib.robots.description import Payload
from ur5lib.stand.arm import FLANGE
from ur5lib.stand.drive import current_noise, motion_share
from ur5lib.stand.engine import Experiment, SimulatedMotion
from ur5lib.stand.plan import SimulatedRecording
from ur5lib.stand.rig import STEP
from ur5lib.stand.trajectories import Targets
from ur5lib.tables import named
from ur5lib.timeseries.arrays import Array, Labels

DECIMALS = 6  # of all channels, as in the thesis's logs
COUNTS = 2**19  # of an encoder per turn
# Noise of moving joints, like the real residuals against the targets.
POSITION_NOISE = np.array([5e-5, 4e-5, 6e-5, 15e-5, 9e-5, 15e-5])  # rad
VELOCITY_NOISE = np.array([0.004, 0.006, 0.005, 0.025, 0.011, 0.033])  # rad/s
WINDOW = 4  # steps over which velocity is averaged, which delays it by 2 ms
FORCE_CUTOFF = 5.0  # Hz, of the controller's force estimate
DAMPING = 0.02  # of that estimate near singularities
TEMPERATURE_STEP = 1 / 16  # °C

Steps = Labels


def frames(
    experiment: Experiment, cycle: float, random: np.random.Generator | None
) -> pd.DataFrame:
    """Return the controller's frames: `time` [s] and its channels under RTDE names.

    cycle: [s]; random: generator of the noise, None for no noise. `actual_TCP_force` is the
    controller's estimate of the wrench of the arm on its environment: currents less the torques of
    model and known friction. It is zero for an arm with a wrist sensor, whose readings replace it.
    """
    nominal, drive, motion = experiment.nominal, experiment.drive, experiment.motion
    steps = np.arange(0, len(motion.time), round(cycle / STEP))
    q, qd = _encoders(motion, random)
    current = motion.motor_torque / drive.torque_constant
    if random is not None:
        current = current + current_noise(motion.q, motion.qd, random)
    targets, current = _at(motion.targets, steps), current[steps]
    moment = model_torques(nominal, targets)
    jacobian = jacobians(nominal, motion.q[steps])
    expected = moment + drive.known_friction(targets.qd)
    estimated = not experiment.robot.wrist_sensor
    force = estimated * _force(drive.torque_constant * current - expected, jacobian, cycle)
    channels = {
        "target_q": targets.q,
        "target_qd": targets.qd,
        "target_qdd": targets.qdd,
        "target_current": (moment + drive.viscous * targets.qd) / drive.torque_constant,
        "target_moment": moment,
        "actual_q": q[steps],
        "actual_qd": qd[steps],
        "actual_current": current,
        "actual_TCP_force": force,
        "actual_TCP_pose": _pose(motion, steps),
        "actual_TCP_speed": np.einsum("nij,nj->ni", jacobian, qd[steps]),
        "joint_temperatures": _temperatures(experiment.plan, motion.time)[steps],
    }
    columns = {"time": np.round(STEP * steps, DECIMALS)}
    for name, values in channels.items():
        columns |= named(np.round(values, DECIMALS), name)
    return pd.DataFrame(columns | _payload(experiment.declared, len(steps)))


def _temperatures(plan: SimulatedRecording, time: Array) -> Array:
    """Return the motors' temperatures (N, 6) [°C], rounded to the sensor's step."""
    warming = np.interp(time, time[[0, -1]], plan.temperature_c)
    return np.repeat(TEMPERATURE_STEP * np.rint(warming / TEMPERATURE_STEP)[:, None], 6, axis=1)


def _payload(declared: Payload | None, count: int) -> dict[str, Array]:
    """Return RTDE's channels of the payload configured at the controller, none without one."""
    if declared is None:
        return {}
    channels = {"payload_cog": declared.center_of_mass, "payload_inertia": declared.inertia}
    columns = {"payload": np.full(count, declared.mass)}
    for name, values in channels.items():
        columns |= named(np.tile(values, (count, 1)), name)
    return columns


def model_torques(plant: mujoco.MjModel, motion: Targets) -> Array:
    """Return the inverse dynamics of a motion (N, 6) [Nm], rotors and payload included."""
    data, torques = mujoco.MjData(plant), np.empty((len(motion.q), 6))
    states = zip(motion.q, motion.qd, motion.qdd, strict=True)
    for torque, (data.qpos, data.qvel, data.qacc) in zip(torques, states, strict=True):
        mujoco.mj_inverse(plant, data)
        torque[:] = data.qfrc_inverse
    return torques


def jacobians(plant: mujoco.MjModel, q: Array) -> Array:
    """Return the geometric Jacobian (N, 6, 6) at the origin of frame 6, base axes; q: (N, 6)."""
    data, result = mujoco.MjData(plant), np.empty((len(q), 6, 6))
    flange = plant.body(FLANGE).id
    for jacobian, data.qpos in zip(result, q, strict=True):
        mujoco.mj_kinematics(plant, data)
        mujoco.mj_comPos(plant, data)
        mujoco.mj_jacBody(plant, data, jacobian[:3], jacobian[3:], flange)
    return result


def _at(targets: Targets, steps: Steps) -> Targets:
    return Targets(targets.q[steps], targets.qd[steps], targets.qdd[steps])


def _encoders(motion: SimulatedMotion, random: np.random.Generator | None) -> tuple[Array, Array]:
    """Return measured positions and velocities (difference over WINDOW) at every step (N, 6)."""
    if random is None:
        return motion.q, motion.qd
    noise = motion_share(motion.qd) * random.normal(size=(2, *motion.q.shape))
    before = np.concatenate([np.repeat(motion.q[:1], WINDOW, axis=0), motion.q[:-WINDOW]])
    qd = (motion.q - before) / (WINDOW * STEP)
    count = 2 * np.pi / COUNTS
    q = count * np.rint((motion.q + POSITION_NOISE * noise[0]) / count)
    return q, qd + VELOCITY_NOISE * noise[1]


def damped_wrench(external: Array, jacobian: Array) -> Array:
    """Return the wrenches (..., 6) [N, Nm] of external torques (..., 6) [Nm] by damped least
    squares; jacobian: (..., 6, 6).
    """
    square = jacobian @ jacobian.mT + DAMPING**2 * np.eye(6)
    return np.asarray(np.linalg.solve(square, jacobian @ external[..., None])[..., 0])


def _force(external: Array, jacobian: Array, cycle: float) -> Array:
    """Return the wrenches (N, 6) of external torques (N, 6), low-pass filtered."""
    wrench = damped_wrench(external, jacobian)
    b, a = butter(1, FORCE_CUTOFF, fs=1 / cycle)
    return lfilter(b, a, wrench - wrench[0], axis=0) + wrench[0]


def _pose(motion: SimulatedMotion, steps: Steps) -> Array:
    """Return origin [m] and rotation vector [rad] of frame 6 (N, 6)."""
    turn = Rotation.from_matrix(motion.rotation[steps].reshape(-1, 3, 3)).as_rotvec()
    return np.concatenate([motion.origin[steps], turn], axis=1)
