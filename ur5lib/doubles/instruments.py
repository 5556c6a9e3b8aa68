"""The outputs of the controller that concern the arm, cycle by cycle."""

from collections.abc import Mapping

import mujoco
import numpy as np

from ur5lib.doubles.live_arm import LiveArm
from ur5lib.stand.arm import flange
from ur5lib.stand.controller import (
    ForceEstimate,
    channels,
    jacobians,
    measure,
    payload_channels,
    poses,
    sensed,
)
from ur5lib.stand.plan import WristSensor
from ur5lib.stand.sensors import Wrist, declared_weight, in_base_axes
from ur5lib.stand.trajectories import Targets
from ur5lib.timeseries.arrays import Array

Outputs = Mapping[str, Array | float]  # under RTDE names

ELBOW = "link_2"
VOLTAGE = 48.0  # V, of the supply
POWER_WITHOUT_MOTION = 60.0  # W


class Instruments:
    """The channels of `stand.controller`, and further ones, in each cycle."""

    def __init__(self, arm: LiveArm, cycle: float, random: np.random.Generator) -> None:
        """cycle: [s]; random: generator of the noise, unused where the plan has none."""
        self._arm, self._random = arm, random if arm.plan.noise else None
        self._estimate = ForceEstimate(cycle)
        self._wrist = Wrist(arm.plan.wrist_sensor or WristSensor(), self._random)
        self._zero = np.zeros(6)
        self.zero_force()

    def read(self) -> dict[str, Array | float]:
        """Return the outputs that concern the arm, SI units, vectors in base axes."""
        arm, rig, state = self._arm, self._arm.rig, self._arm.states[-1].copy()
        measured = measure(rig.drive, state, arm.states["q"][0], self._random)
        targets = Targets(arm.motion.q, arm.motion.qd, arm.motion.qdd)
        outputs: dict[str, Array | float] = {
            **channels(rig, state, measured, targets, self._estimate),
            **self._elbow(measured.qd),
            **self._forces(),
            **payload_channels(rig.declared),
            **self._electrics(measured.current),
            "target_gravity": -np.array(rig.robot.gravity),
            **self._target_tool(targets),
            "actual_tool_accelerometer": state["imu"][:3],
            "joint_temperatures": np.full(6, sensed(arm.plan.temperature(arm.time))),
        }
        size = float(np.linalg.norm(np.asarray(outputs["actual_TCP_force"])[:3]))
        return outputs | {"tcp_force_scalar": size}

    def zero_force(self) -> None:
        """Set the wrist sensor's zero to the present reading less the declared payload's weight."""
        force = self._wrist.noiseless(self._arm.states["force_sensor"][-1], self._arm.time)
        self._zero = force - declared_weight(self._arm.rig, self._rotation())

    def _rotation(self) -> Array:
        return np.asarray(self._arm.states["rotation"][-1].reshape(3, 3))

    def _forces(self) -> dict[str, Array]:
        """Return the wrist sensor's channels, for an arm that has one."""
        arm, rotation = self._arm, self._rotation()
        if not arm.rig.robot.wrist_sensor:
            return {"ft_raw_wrench": np.zeros(6)}
        raw = self._wrist.read(arm.states["force_sensor"][-1], arm.time)
        force = raw - declared_weight(arm.rig, rotation) - self._zero
        return {"ft_raw_wrench": raw, "actual_TCP_force": in_base_axes(force, rotation)}

    def _elbow(self, qd: Array) -> dict[str, Array]:
        """Return position [m] and velocity [m/s] of the elbow; needs the state of `jacobians`."""
        rig, jacobian = self._arm.rig, np.zeros((3, 6))
        elbow = rig.nominal_data.body(ELBOW)
        mujoco.mj_jacBody(rig.nominal, rig.nominal_data, jacobian, None, elbow.id)
        return {"elbow_position": elbow.xpos.copy(), "elbow_velocity": jacobian @ qd}

    def _target_tool(self, targets: Targets) -> dict[str, Array]:
        """Return pose and speed of frame 6 at the targets."""
        rig = self._arm.rig
        jacobian, last = jacobians(rig, targets.q), rig.nominal_data.body(flange(rig.nominal))
        return {
            "target_TCP_pose": poses(last.xpos, last.xmat),
            "target_TCP_speed": jacobian @ targets.qd,
        }

    def _electrics(self, current: Array) -> dict[str, Array | float]:
        state = self._arm.states[-1]
        power = POWER_WITHOUT_MOTION + float(np.abs(state["motor_torque"] @ state["qd"]))
        return {
            "actual_current_as_torque": self._arm.rig.drive.torque_constant * current,
            "joint_control_output": current,
            "actual_current_window": np.full(6, 1.0) + 0.1 * np.abs(current),
            "actual_joint_voltage": np.full(6, VOLTAGE),
            "actual_main_voltage": VOLTAGE,
            "actual_robot_voltage": VOLTAGE,
            "actual_robot_current": power / VOLTAGE,
        }
