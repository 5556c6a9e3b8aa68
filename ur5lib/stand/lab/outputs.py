"""The outputs of the controller cycle by cycle; `stand/controller.py` computes whole recordings."""

from collections.abc import Mapping

import mujoco
import numpy as np
from scipy.signal import butter
from scipy.spatial.transform import Rotation

from ur5lib.stand.arm import FLANGE
from ur5lib.stand.controller import (
    COUNTS,
    FORCE_CUTOFF,
    POSITION_NOISE,
    TEMPERATURE_STEP,
    VELOCITY_NOISE,
    WINDOW,
    damped_wrench,
)
from ur5lib.stand.drive import current_noise, motion_share
from ur5lib.stand.friction import USUAL
from ur5lib.stand.lab.live_arm import LiveArm
from ur5lib.stand.lab.truth import COLUMNS
from ur5lib.stand.plan import WristSensor
from ur5lib.stand.rig import STEP
from ur5lib.stand.wrist_sensor import MINUTE, NOISE
from ur5lib.timeseries.arrays import Array

Outputs = Mapping[str, Array | float]

ELBOW = "link_2"
VOLTAGE = 48.0  # V, of the supply
POWER_WITHOUT_MOTION = 60.0  # W


class Instruments:
    """Measurements and estimates of the controller in each cycle."""

    def __init__(self, arm: LiveArm, cycle: float, random: np.random.Generator) -> None:
        """cycle: [s]; random: generator of the noise, unused where the plan has none."""
        self._arm, self._random, self._noisy = arm, random, arm.plan.noise
        self._estimate = ForceEstimate(cycle)
        self._wrist = Wrist(arm, random) if arm.rig.robot.wrist_sensor else None

    def read(self) -> dict[str, Array | float]:
        """Return the outputs that concern the arm, SI units, vectors in base axes."""
        arm, drive = self._arm, self._arm.rig.drive
        target, q, qd = arm.motion, *self._encoders()
        moment, target_pose, target_speed = self._of_targets()
        current = arm.state("motor_torque") / drive.torque_constant
        if self._noisy:
            current = current + current_noise(arm.state("q"), arm.state("qd"), self._random)
        jacobian = self._jacobian(FLANGE, arm.state("q"))
        expected = moment + drive.known_friction(target.qd)
        external = drive.torque_constant * current - expected
        return {
            "target_q": target.q,
            "target_qd": target.qd,
            "target_qdd": target.qdd,
            "target_current": (moment + drive.viscous * target.qd) / drive.torque_constant,
            "target_moment": moment,
            "actual_q": q,
            "actual_qd": qd,
            "actual_current": current,
            "actual_current_as_torque": drive.torque_constant * current,
            "joint_control_output": current,
            "actual_TCP_pose": _pose(arm.state("origin"), arm.state("rotation")),
            "actual_TCP_speed": jacobian @ qd,
            "target_TCP_pose": target_pose,
            "target_TCP_speed": target_speed,
            "actual_tool_accelerometer": arm.state("imu")[:3],
            "joint_temperatures": np.full(6, self._temperature()),
            **self._forces(jacobian, external),
            **self._elbow(qd),
            **self._electrics(current),
        }

    def zero_force(self) -> None:
        """Zero the wrist sensor, if the arm has one."""
        if self._wrist is not None:
            self._wrist.zero()

    def _encoders(self) -> tuple[Array, Array]:
        """Return positions by counts, and velocities by their difference over WINDOW steps."""
        states, at = self._arm.states, COLUMNS["q"]
        if not self._noisy:
            return states[-1][at], states[-1][COLUMNS["qd"]]
        noise = motion_share(states[-1][COLUMNS["qd"]]) * self._random.normal(size=(2, 6))
        count = 2 * np.pi / COUNTS
        q = count * np.rint((states[-1][at] + POSITION_NOISE * noise[0]) / count)
        before = states[-1 - WINDOW][at]
        return q, (states[-1][at] - before) / (WINDOW * STEP) + VELOCITY_NOISE * noise[1]

    def _of_targets(self) -> tuple[Array, Array, Array]:
        """Return inverse dynamics, pose and speed of frame 6 at the targets, payload included."""
        rig, target = self._arm.rig, self._arm.motion
        data = rig.nominal_data
        data.qpos, data.qvel, data.qacc = target.q, target.qd, target.qdd
        mujoco.mj_inverse(rig.nominal, data)
        flange, jacobian = data.body(FLANGE), np.zeros((6, 6))
        mujoco.mj_jacBody(rig.nominal, data, jacobian[:3], jacobian[3:], flange.id)
        return data.qfrc_inverse.copy(), _pose(flange.xpos, flange.xmat), jacobian @ target.qd

    def _jacobian(self, body: str, q: Array) -> Array:
        """Return the geometric Jacobian (6, 6) at a body's origin, base axes."""
        rig, jacobian = self._arm.rig, np.zeros((6, 6))
        rig.nominal_data.qpos = q
        mujoco.mj_kinematics(rig.nominal, rig.nominal_data)
        mujoco.mj_comPos(rig.nominal, rig.nominal_data)
        number = rig.nominal.body(body).id
        mujoco.mj_jacBody(rig.nominal, rig.nominal_data, jacobian[:3], jacobian[3:], number)
        return jacobian

    def _forces(self, jacobian: Array, external: Array) -> dict[str, Array | float]:
        """Return the force at the tool: sensed in the wrist, otherwise estimated from currents."""
        if self._wrist is not None:
            raw, force = self._wrist.read()
        else:
            raw, force = np.zeros(6), self._estimate.update(jacobian, external)
        size = float(np.linalg.norm(force[:3]))
        return {"ft_raw_wrench": raw, "actual_TCP_force": force, "tcp_force_scalar": size}

    def _elbow(self, qd: Array) -> dict[str, Array | float]:
        """Return position [m] and velocity [m/s] of the elbow; needs the state of `_jacobian`."""
        rig, jacobian = self._arm.rig, np.zeros((3, 6))
        elbow = rig.nominal_data.body(ELBOW)
        mujoco.mj_jacBody(rig.nominal, rig.nominal_data, jacobian, None, elbow.id)
        return {"elbow_position": elbow.xpos.copy(), "elbow_velocity": jacobian @ qd}

    def _electrics(self, current: Array) -> dict[str, Array | float]:
        power = POWER_WITHOUT_MOTION + float(
            np.abs(self._arm.state("motor_torque") @ self._arm.state("qd"))
        )
        return {
            "actual_current_window": np.full(6, 1.0) + 0.1 * np.abs(current),
            "actual_joint_voltage": np.full(6, VOLTAGE),
            "actual_main_voltage": VOLTAGE,
            "actual_robot_voltage": VOLTAGE,
            "actual_robot_current": power / VOLTAGE,
        }

    def _temperature(self) -> float:
        return TEMPERATURE_STEP * round((USUAL + self._arm.warmth()) / TEMPERATURE_STEP)


class ForceEstimate:
    """The controller's estimate of the force at the tool, from the currents of an arm without a
    force sensor: the wrench of the arm on its environment, at the origin of frame 6, base axes.
    """

    def __init__(self, cycle: float) -> None:
        """cycle: [s]."""
        (self._gain, _), (_, self._decay) = butter(1, FORCE_CUTOFF, fs=1 / cycle)
        self._before: Array | None = None
        self._force = np.zeros(6)

    def update(self, jacobian: Array, external: Array) -> Array:
        """Return the estimate (6,) [N, Nm] from external torques (6,) [Nm], low-pass filtered."""
        wrench = damped_wrench(external, jacobian)
        if self._before is None:
            self._before, self._force = wrench, wrench
        both, self._before = wrench + self._before, wrench
        self._force = self._gain * both - self._decay * self._force
        return self._force


class Wrist:
    """The force sensor in the wrist of an e-Series arm."""

    def __init__(self, arm: LiveArm, random: np.random.Generator) -> None:
        """random: generator of the noise."""
        self._arm, self._random = arm, random
        self._sensor = arm.plan.wrist_sensor or WristSensor()
        turn = Rotation.from_rotvec(self._sensor.rotation_deg, degrees=True)
        self._turn = turn.as_matrix()
        self._zero = np.zeros(6)
        self.zero()

    def read(self) -> tuple[Array, Array]:
        """Return the raw reading in the sensor's axes (6,) [N, Nm], and the force at the tool in
        base axes: less the declared payload's weight and the zero offset.
        """
        raw = self._raw()
        if self._arm.plan.noise:
            raw = raw + NOISE * self._random.normal(size=6)
        rotation = self._arm.state("rotation").reshape(3, 3)
        compensated = raw - self._weight() - self._zero
        return raw, (compensated.reshape(2, 3) @ rotation.T).ravel()

    def zero(self) -> None:
        """Set the zero offset to the present reading less the declared payload's weight."""
        self._zero = self._raw() - self._weight()

    def _raw(self) -> Array:
        halves = self._arm.state("force_sensor").reshape(2, 3)
        drift = np.multiply(self._sensor.drift_per_min, self._arm.time / MINUTE)
        felt = self._sensor.scale * (halves @ self._turn).ravel()
        return np.asarray(felt + self._sensor.bias + drift, np.float64)

    def _weight(self) -> Array:
        """Return the weight of the declared payload (6,), axes of frame 6."""
        declared = self._arm.rig.declared
        if declared is None:
            return np.zeros(6)
        gravity = np.array(self._arm.rig.robot.gravity)
        force = declared.mass * gravity @ self._arm.state("rotation").reshape(3, 3)
        return np.concatenate([force, np.cross(declared.center_of_mass, force)])


def _pose(origin: Array, rotation: Array) -> Array:
    """Return origin [m] and rotation vector [rad] (6,); rotation: (9,)."""
    quaternion, vector = np.empty(4), np.empty(3)
    mujoco.mju_mat2Quat(quaternion, rotation)
    mujoco.mju_quat2Vel(vector, quaternion, 1.0)
    return np.concatenate([origin, vector])
