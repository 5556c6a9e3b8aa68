"""The simulated arm, advanced as time passes."""

from collections import deque
from dataclasses import replace
from functools import cached_property

import mujoco
import numpy as np

from ur5lib.robots.description import Payload, Robot
from ur5lib.stand.arm import build_arm
from ur5lib.stand.friction import USUAL
from ur5lib.stand.lab.motion import JointMotion
from ur5lib.stand.lab.truth import COLUMNS, WIDTH, Truth
from ur5lib.stand.plan import Contact, Imu, SimulatedRecording
from ur5lib.stand.rig import SETTLE, STEP, build_rig
from ur5lib.stand.trajectories import plan_targets
from ur5lib.timeseries.arrays import Array

KEPT = 5  # last states, from which the controller computes velocities
TOLERANCE = 1.02  # factor of the limits of position and speed, up to which targets may go
FOLLOWING_ERROR = 0.1  # rad; a larger deviation from the target stops the arm


class LiveArm:
    """An arm that follows the commands of its `motion`, step by step.

    It starts at rest where the trajectory of its plan starts; the plan's contacts and warming count
    from there. states: the last states (up to KEPT, WIDTH); time: [s] since the start.
    """

    def __init__(
        self, robot: Robot, plan: SimulatedRecording, truth: Truth, random: np.random.Generator
    ) -> None:
        self.plan, self.rig = plan, build_rig(robot, plan, random)
        self._bare, self._truth = robot, truth
        start = plan_targets(plan.trajectory, robot, np.zeros(1)).q[0]
        self.motion = JointMotion(start)
        self.states: deque[Array] = deque(maxlen=KEPT)
        self.rig.data.qpos, self.rig.data.time = start, -SETTLE * STEP
        for _ in range(SETTLE):
            self._step()

    @property
    def time(self) -> float:
        """Return the time since the start [s]."""
        return float(self.rig.data.time)

    def state(self, name: str) -> Array:
        """Return a quantity of `rig.PARTS` in the last state."""
        return self.states[-1][COLUMNS[name]]

    def warmth(self) -> float:
        """Return the motors' temperature above the usual one [K]."""
        plan = self.plan
        return float(np.interp(self.time, [0.0, plan.seconds], plan.temperature_c)) - USUAL

    def advance(self, steps: int) -> None:
        """Advance by some steps, and write them to the truth."""
        for _ in range(steps):
            self._step()
            self._truth.append(self.states[-1])

    def touch(self, contact: Contact) -> None:
        """Add a contact; its start counts like `time`."""
        self.rig.contacts.add(self.rig.plant, contact)

    def declare(self, payload: Payload | None) -> None:
        """Configure the controller's payload; the arm's true load does not change."""
        mounting = np.deg2rad((self.plan.imu or Imu()).mounting_deg)
        nominal = build_arm(self._bare.carrying(payload), self.rig.model, mounting, STEP)
        data = mujoco.MjData(nominal)
        self.rig = replace(self.rig, nominal=nominal, nominal_data=data, declared=payload)

    def release(self) -> None:
        """Start freedrive, until the next command: gravity compensation only."""
        data = self.rig.data
        self.motion.freedrive(lambda: (data.qpos.copy(), data.qvel.copy()))

    def exceeded(self) -> str:
        """Return in words the limit that the arm exceeds; empty where it exceeds none."""
        target, positions, speeds = self.motion, *self._limits
        for joint in range(6):
            outwards = target.q[joint] * target.qd[joint] > 0
            if outwards and abs(target.q[joint]) > TOLERANCE * positions[joint]:
                return f"position limit of joint {joint + 1}"
            if abs(target.qd[joint]) > TOLERANCE * speeds[joint]:
                return f"speed limit of joint {joint + 1}"
        off = np.abs(target.q - self.state("q"))
        return f"joint {off.argmax() + 1} off its path" if off.max() > FOLLOWING_ERROR else ""

    @cached_property
    def _limits(self) -> tuple[list[float], list[float]]:
        motors = [self._bare.motor(joint) for joint in range(1, 7)]
        return self._bare.position_limits(), [motor.velocity_max for motor in motors]

    def _step(self) -> None:
        row = np.empty(WIDTH)
        self.rig.step(self.motion.step(), self.warmth(), row)
        self.states.append(row)
