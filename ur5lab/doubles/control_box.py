"""The control box of a live arm: its state, its program, its outputs in each cycle."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass

import mujoco
import numpy as np

from ur5lab.doubles.live_arm import LiveArm
from ur5lab.rtde_variables import (
    INPUT_TYPES,
    OUTPUT_TYPES,
    RobotMode,
    RuntimeState,
    SafetyMode,
)
from ur5lib.robots.mjcf import flange
from ur5lib.stand.controller_channels import (
    ForceEstimate,
    channels,
    jacobians,
    measure,
    payload_channels,
    poses,
    rounded_temperature,
)
from ur5lib.stand.plan import WristSensor
from ur5lib.stand.rig import STEP
from ur5lib.stand.sensors import WristReader, declared_weight, in_base_axes
from ur5lib.stand.trajectories import Targets
from ur5lib.timeseries.arrays import Array

Program = Iterator[None]  # advanced once per cycle, until it ends
Outputs = Mapping[str, Array | float]  # under RTDE names
ELBOW_BODY = "link_2"
SUPPLY_VOLTAGE = 48.0  # V
STANDBY_POWER = 60.0  # W; of an arm at rest

PROTECTIVE_STOP_DECELERATION = 20.0  # rad/s²
PROGRAM_END_DECELERATION = 4.0  # rad/s²; if a program ends in motion

JOINT_RUNNING, JOINT_IDLE = 253, 255  # RTDE's `joint_mode`
POWER_ON_BIT, PROGRAM_BIT = 1, 2  # of `robot_status_bits`
NORMAL_BIT, PROTECTIVE_BIT = 1, 4  # of `safety_status_bits`


class UnsupportedCommandError(Exception):
    """Raised where a program uses a command that is not emulated."""


@dataclass
class Watchdog:
    """A limit on the time between a client's writes to a register, beyond which the program is
    stopped.

    name: of the input register; longest: allowed time between two writes [s]; last: time of the
    last write [s].
    """

    name: str
    longest: float
    last: float


class ControlBox:
    """The state of a controller, which all its interfaces share.

    software: major, minor, bugfix, build; cycle: [s]; uptime: [s] at the start; registers: by their
    RTDE names; log: listeners, called with each line of the robot's log; loaded: name of the loaded
    program.
    """

    def __init__(
        self,
        arm: LiveArm,
        software: tuple[int, int, int, int],
        cycle: float,
        uptime: float,
        random: np.random.Generator,
    ) -> None:
        """Start an arm's controller; cycle: [s]; uptime: at the start [s]; random: generator of the
        noise.
        """
        self.arm, self.software, self.cycle = arm, software, cycle
        self.registers = {
            name: 0.0 for name in [*INPUT_TYPES, *OUTPUT_TYPES] if "_register_" in name
        }
        self.robot_mode, self.safety_mode = RobotMode.RUNNING, SafetyMode.NORMAL
        self.paused = False
        self.loaded = ""
        self.log: list[Callable[[str], None]] = []
        self.watchdog: Watchdog | None = None
        self._uptime, self._cycles = uptime, 0
        self._program: Program | None = None
        self.arm.advance(1)
        self._instruments = Instruments(arm, cycle, random)
        self.zero_force = self._instruments.zero_force
        self._outputs: Outputs | None = None

    @property
    def time(self) -> float:
        """Return the time of the last cycle since the start [s], by the controller's clock."""
        return self._cycles * self.cycle

    @property
    def outputs(self) -> Outputs:
        """Return the outputs of the last cycle, computed at the first access."""
        if self._outputs is None:
            self._outputs = self._instruments.read() | self._status() | self.registers
        return self._outputs

    @property
    def state(self) -> RuntimeState:
        """Return whether a program is playing, paused or stopped."""
        if self._program is None:
            return RuntimeState.STOPPED
        return RuntimeState.PAUSED if self.paused else RuntimeState.PLAYING

    def run(self, program: Program) -> None:
        """Start a program in place of the present one, if the robot is ready."""
        if self.robot_mode != RobotMode.RUNNING or self.safety_mode != SafetyMode.NORMAL:
            self.say("the robot is not ready: the program is not started")
            return
        self._program, self.paused, self.watchdog = program, False, None

    def stop(self, deceleration: float = PROGRAM_END_DECELERATION) -> None:
        """End the program, if any, and the motion."""
        self._program, self.paused, self.watchdog = None, False, None
        if self.arm.motion.moving:
            self.arm.motion.stopj(deceleration)

    def protective_stop(self, reason: str = "commanded") -> None:
        """Stop the arm at once; nothing moves until `unlock`."""
        self.say(f"Protective stop: {reason}")
        self.safety_mode = SafetyMode.PROTECTIVE_STOP
        self.stop(PROTECTIVE_STOP_DECELERATION)

    def unlock(self) -> bool:
        """Release a protective stop, unless the arm still brakes; return whether it is released."""
        if not self.arm.motion.moving:
            self.safety_mode = SafetyMode.NORMAL
        return self.safety_mode == SafetyMode.NORMAL

    def say(self, text: str) -> None:
        """Write to the robot's log."""
        for listener in self.log:
            listener(text)

    def advance(self) -> None:
        """Advance by one cycle."""
        if self._program is not None and not self.paused:
            self._continue(self._program)
        self.arm.advance(round(self.cycle / STEP))
        if self.safety_mode == SafetyMode.NORMAL and (reason := self.arm.exceeded()):
            self.protective_stop(reason)
        self._cycles += 1
        self._outputs = None

    def _continue(self, program: Program) -> None:
        if self.watchdog is not None and self.time - self.watchdog.last > self.watchdog.longest:
            self.say("RTDE watchdog: the program is stopped")
            self.stop()
            return
        try:
            next(program)
        except StopIteration:
            self.stop()
        except (UnsupportedCommandError, ValueError, TypeError) as error:
            self.say(f"Runtime error: {error}")
            self.stop()

    def _status(self) -> dict[str, float]:
        running = self.robot_mode == RobotMode.RUNNING
        normal = self.safety_mode == SafetyMode.NORMAL
        playing = self.state == RuntimeState.PLAYING
        return {
            "timestamp": self._uptime + self.time,
            "actual_execution_time": 0.0003,
            "robot_mode": self.robot_mode,
            "joint_mode": JOINT_RUNNING if running else JOINT_IDLE,
            "safety_mode": self.safety_mode,
            "safety_status": self.safety_mode,
            "runtime_state": self.state,
            "speed_scaling": 1.0,
            "target_speed_fraction": 1.0,
            "robot_status_bits": POWER_ON_BIT * running | PROGRAM_BIT * playing,
            "safety_status_bits": NORMAL_BIT if normal else PROTECTIVE_BIT,
        }


class Instruments:
    """The measured and computed outputs of an arm in each cycle: those of `stand.controller`, and
    others.
    """

    def __init__(self, arm: LiveArm, cycle: float, random: np.random.Generator) -> None:
        """Take the arm; cycle: [s]; random: generator of the noise, unused where the plan has
        none.
        """
        self._arm, self._random = arm, random if arm.plan.noise else None
        self._estimate = ForceEstimate(cycle)
        self._wrist = WristReader(arm.plan.wrist_sensor or WristSensor(), self._random)
        self._zero = np.zeros(6)
        self.zero_force()

    def read(self) -> dict[str, Array | float]:
        """Return the outputs that concern the arm, SI units, vectors in base axes."""
        arm, rig, state = self._arm, self._arm.rig, self._arm.states[-1].copy()
        measured = measure(rig.drive, state, arm.states["q"][0], self._random)
        targets = Targets(arm.motion.q, arm.motion.qd, arm.motion.qdd)
        stated = channels(rig, state, measured, targets, self._estimate)
        # The controller's model is now in the present posture,
        elbow, turning = rig.nominal_data.body(ELBOW_BODY), np.zeros((3, 6))
        mujoco.mj_jacBody(rig.nominal, rig.nominal_data, turning, None, elbow.id)
        place = elbow.xpos.copy()
        # and then in that of the targets.
        jacobian, last = jacobians(rig, targets.q), rig.nominal_data.body(flange(rig.nominal))
        outputs: dict[str, Array | float] = {
            **stated,
            "elbow_position": place,
            "elbow_velocity": turning @ measured.qd,
            "target_TCP_pose": poses(last.xpos, last.xmat),
            "target_TCP_speed": jacobian @ targets.qd,
            **self._forces(),
            **payload_channels(rig.declared),
            **self._electrics(measured.current),
            "target_gravity": -np.array(rig.robot.gravity),
            "actual_tool_accelerometer": state["imu"][:3],
            "joint_temperatures": np.full(6, rounded_temperature(arm.plan.temperature(arm.time))),
        }
        size = float(np.linalg.norm(np.asarray(outputs["actual_TCP_force"])[:3]))
        return outputs | {"tcp_force_scalar": size}

    def zero_force(self) -> None:
        """Set the wrist sensor's zero so that it reads the weight of the declared payload now."""
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

    def _electrics(self, current: Array) -> dict[str, Array | float]:
        state = self._arm.states[-1]
        power = STANDBY_POWER + float(np.abs(state["motor_torque"] @ state["qd"]))
        return {
            "actual_current_as_torque": self._arm.rig.drive.torque_constant * current,
            "joint_control_output": current,
            "actual_current_window": np.full(6, 1.0) + 0.1 * np.abs(current),
            "actual_joint_voltage": np.full(6, SUPPLY_VOLTAGE),
            "actual_main_voltage": SUPPLY_VOLTAGE,
            "actual_robot_voltage": SUPPLY_VOLTAGE,
            "actual_robot_current": power / SUPPLY_VOLTAGE,
        }
