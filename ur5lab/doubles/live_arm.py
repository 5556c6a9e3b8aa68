"""The simulated arm, advanced as time passes, and its motion under URScript's commands."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import count
from typing import BinaryIO

import mujoco
import numpy as np

from ur5lab.doubles.true_states import STATE_TYPE
from ur5lib.robots.description import Payload, Robot
from ur5lib.stand.controller_channels import VELOCITY_WINDOW
from ur5lib.stand.friction import USUAL_TEMPERATURE
from ur5lib.stand.plan import Contact, SimulatedRecording
from ur5lib.stand.rig import (
    SETTLING_STEPS,
    STEP,
    Target,
    arm_in_mujoco,
    as_rows,
    build_rig,
    step_times,
)
from ur5lib.stand.trajectories import leg, plan_targets
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.profiles import duration

STANDSTILL = np.zeros(6)
STATES_KEPT = VELOCITY_WINDOW + 1  # the controller computes velocities from this many last states
LIMIT_TOLERANCE = 1.02  # targets may reach this multiple of the limits of position and speed
MAX_FOLLOWING_ERROR = 0.1  # rad; a larger deviation from the target stops the arm


class LiveArm:
    """An arm that follows the commands of its `motion`, step by step.

    It starts at rest where the trajectory of its plan starts; the plan's contacts and warming count
    from there. states: the last states (STATES_KEPT,); position_limits: of its joints, to
    either side [rad].
    """

    def __init__(
        self, robot: Robot, plan: SimulatedRecording, truth: BinaryIO, random: np.random.Generator
    ) -> None:
        """Put the arm at rest at the plan's start; truth: file to which all states are written."""
        self.plan, self.rig = plan, build_rig(robot, plan, random)
        self._bare, self._truth = robot, truth
        self.position_limits = [high for _, high in robot.position_limits()]
        self._velocity_limits = robot.velocity_limits()
        start = plan_targets(plan.trajectory, robot, np.zeros(1)).q[0]
        self.motion = TargetGenerator(start)
        self.states = np.zeros(STATES_KEPT, STATE_TYPE)
        self._rows = as_rows(self.states)
        self.rig.data.qpos, self.rig.data.time = start, -SETTLING_STEPS * STEP
        for _ in range(SETTLING_STEPS):
            self._step()

    @property
    def time(self) -> float:
        """Return the time since the start [s]."""
        return float(self.rig.data.time)

    def advance(self, steps: int) -> None:
        """Advance by some steps, and write them to the truth."""
        for _ in range(steps):
            self._step()
            self._truth.write(self.states[-1].tobytes())
        self._truth.flush()

    def touch(self, contact: Contact) -> None:
        """Add a contact; its start is counted from the arm's start, like `time`."""
        self.rig.contacts.add(self.rig.plant, contact)

    def declare(
        self, mass: float, center: Sequence[float], inertia: Sequence[float] = (0.0,) * 6
    ) -> None:
        """Configure the controller's payload; the arm's true load does not change.

        mass: [kg], 0 for none; center: its centre [m], inertia: [kg m²], as RTDE has them.
        """
        body = {"mass": mass, "center_of_mass": (*center,), "inertia": (*inertia,)}
        payload = Payload.model_validate(body) if mass else None
        nominal = arm_in_mujoco(self._bare.carrying(payload), self.rig.model, self.plan.imu)
        data = mujoco.MjData(nominal)
        self.rig = replace(self.rig, nominal=nominal, nominal_data=data, declared=payload)

    def release(self) -> None:
        """Start freedrive, until the next command: gravity compensation only."""
        data = self.rig.data
        self.motion.freedrive(lambda: (data.qpos.copy(), data.qvel.copy()))

    def exceeded(self) -> str:
        """Return in words the limit that the arm exceeds, "" if it exceeds none."""
        target = self.motion
        for joint in range(6):
            outwards = target.q[joint] * target.qd[joint] > 0
            if outwards and abs(target.q[joint]) > LIMIT_TOLERANCE * self.position_limits[joint]:
                return f"position limit of joint {joint + 1}"
            if abs(target.qd[joint]) > LIMIT_TOLERANCE * self._velocity_limits[joint]:
                return f"speed limit of joint {joint + 1}"
        off = np.abs(target.q - self.states["q"][-1])
        return f"joint {off.argmax() + 1} off its path" if off.max() > MAX_FOLLOWING_ERROR else ""

    def _step(self) -> None:
        warmth = float(self.plan.temperature(self.time)) - USUAL_TEMPERATURE
        self._rows[:-1] = self._rows[1:]
        self.rig.step(self.motion.step(), warmth, self._rows[-1])


class TargetGenerator:
    """The target angles of the joints under one command at a time.

    q, qd, qdd: the present targets (6,) [rad, rad/s, rad/s²]; moving: whether a command has not
    ended. Commands raise ValueError where a speed, an acceleration or a time is not positive.
    """

    def __init__(self, q: Array) -> None:
        """Start at rest; q: the angles there (6,) [rad]."""
        self.q, self.qd, self.qdd = q, STANDSTILL, STANDSTILL
        self._rows: Iterator[Target] = iter(())
        self.moving = False
        self._goal, self._rate, self._gain = q, 0.0, 0.0
        self._kind = ""

    def step(self) -> Target:
        """Advance by one step, and return its targets."""
        row = next(self._rows, None)
        if row is None:
            self.moving, self._kind = False, ""
            row = self.q, STANDSTILL, STANDSTILL
        self.q, self.qd, self.qdd = row
        return row

    def movej(self, goal: Array, speed: float, acceleration: float) -> None:
        """Move to the angles `goal` (6,) [rad]; joints start and stop together.

        speed [rad/s], acceleration [rad/s²]: of the joint with the longest travel.
        """
        _expect_positive(speed, acceleration)
        self._start("movej", self._movej_targets(goal, speed, acceleration))

    def stopj(self, deceleration: float) -> None:
        """Brake all joints; deceleration [rad/s²]: of the fastest one."""
        _expect_positive(deceleration)
        self._start("stopj", self._braking_targets(deceleration))

    def servoj(self, goal: Array, lookahead: float) -> None:
        """Follow the angles `goal` (6,) [rad], which may be renewed at any time.

        lookahead [s]: how far the arm lags behind a goal of constant speed.
        """
        _expect_positive(lookahead)
        self._goal, self._rate = goal, 2 / lookahead
        if self._kind != "servoj":
            self._start("servoj", self._servoj_targets())

    def speedj(self, speeds: Array, acceleration: float) -> None:
        """Move at joint speeds (6,) [rad/s], which may be renewed; acceleration [rad/s²]."""
        _expect_positive(acceleration)
        self._goal, self._gain = speeds, acceleration
        if self._kind != "speedj":
            self._start("speedj", self._speedj_targets())

    def freedrive(self, actual: Callable[[], tuple[Array, Array]]) -> None:
        """Follow the joints wherever they are pushed, as in freedrive.

        actual: returns their angles and speeds (6,) [rad, rad/s].
        """
        self._start("freedrive", ((*actual(), STANDSTILL) for _ in count()))

    def _start(self, kind: str, rows: Iterator[Target]) -> None:
        self._kind, self._rows, self.moving = kind, rows, True

    def _braking_targets(self, deceleration: float) -> Iterator[Target]:
        """Yield targets that slow down all joints alike, which keeps the arm on its path."""
        q, qd = self.q, self.qd
        seconds = np.abs(qd).max() / deceleration
        for k in range(1, int(np.ceil(seconds / STEP)) + 1):
            passed = min(k * STEP, seconds)
            remaining = 1 - passed / seconds
            yield q + qd * (1 + remaining) / 2 * passed, qd * remaining, -qd / seconds

    def _movej_targets(self, goal: Array, speed: float, acceleration: float) -> Iterator[Target]:
        yield from self._braking_targets(acceleration)
        if (goal == self.q).all():
            return
        seconds = duration(goal - self.q, speed, acceleration)[2]
        time = step_times(int(np.ceil(seconds / STEP)) + 1)[1:]
        move = leg(time, self.q, goal, speed, acceleration)
        yield from zip(*move, strict=True)

    def _servoj_targets(self) -> Iterator[Target]:
        """Yield targets that approach the goal like a critically damped spring, with a delay of
        2/rate.
        """
        while True:
            qdd = self._rate * (self._rate * (self._goal - self.q) - 2 * self.qd)
            qd = self.qd + STEP * qdd
            yield self.q + STEP * qd, qd, qdd

    def _speedj_targets(self) -> Iterator[Target]:
        while True:
            missing = self._goal - self.qd
            largest = np.abs(missing).max()
            qd = self.qd + missing * min(1.0, self._gain * STEP / largest if largest else 1.0)
            yield self.q + STEP * qd, qd, (qd - self.qd) / STEP


def _expect_positive(*values: float) -> None:
    if not all(0 < value < np.inf for value in values):
        raise ValueError("speeds, accelerations and times must be positive")
