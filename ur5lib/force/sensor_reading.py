"""A force sensor's reading, and the part of it from bias, weight and inertia of its tool."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation

from ur5lib.force.sensor import SensorOffset, fit_offset, initial_bias
from ur5lib.force.sensor_drift import force_drift
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.motion import Motion
from ur5lib.records.sensor_offset import OffsetAccount
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Payload, Robot
from ur5lib.robots.end_effector import ToolMotion, expected_values, tool_motion
from ur5lib.timeseries.arrays import Array, Six

MAX_CENTER_DISTANCE = 0.3  # m; a tool's centre of mass is at most this far away
# The tool's centre of mass, at which its acceleration counts, is found in this many rounds.
CENTER_ROUNDS = 2


@dataclass(frozen=True)
class SensorReading:
    """A force sensor's reading and what is subtracted from it, in axes of frame 6, on the robot's
    clock.

    wrench: the reading (N, 6) [N, Nm]; untouched: the reading without contact (N, 6), from bias,
    weight and inertia of its tool; offset: bias and tool; placed: the reading as in the thesis, if
    on its own clock timed by start stamps alone; start_bias: (6,), mean of `placed` at the start;
    own_clock: whether the sensor has one; each: samples per reading of the sensor; pull_at,
    clock_std, inertia, drift, drift_std: as in `OffsetAccount`.
    """

    wrench: Array
    untouched: Array
    offset: SensorOffset
    pull_at: Array
    clock_std: float
    inertia: Six | None
    placed: Array
    start_bias: Array
    own_clock: bool
    each: float
    drift: Array
    drift_std: Array

    def account(self) -> OffsetAccount:
        """Return what is subtracted from the reading, to be written."""
        names = ("pull_at", "clock_std", "inertia", "start_bias", "drift", "drift_std")
        known = {name: getattr(self, name) for name in names}
        return OffsetAccount(**vars(self.offset) | known | {"free": float(self.offset.free.mean())})


class OwnClock(NamedTuple):
    """A sensor's reading on its own clock, and that clock.

    placed: the reading by start stamps alone (N, 6), axes of the sensor; std: error of the clock
    [s]; step: the sensor's sampling period [s].
    """

    placed: Array
    std: float
    step: float


def sensor_reading(
    robot: Robot,
    signals: Signals,
    moved: ToolMotion,
    bias_window: float,
    tool: Payload | None = None,
    own: OwnClock | None = None,
) -> SensorReading:
    """Return the reading of a force sensor, with its tool placed by a first fit.

    moved: motion of the tool; bias_window: [s], at the start, free of contact; tool: the body
    behind the sensor, for its moments of inertia; without it they are neglected; own: None for a
    sensor on the robot's clock.
    """
    assert signals.force_sensor is not None
    clock_std, values = own.std if own else 0.0, in_frame_6(signals.force_sensor, robot)

    def expected(motion: Array) -> Array:
        return expected_values(motion, signals.segment, signals.period, clock_std)

    moment = np.zeros_like(values)
    if tool is not None:  # n = ... - I α - ω × I ω
        moment[:, 3:] = -expected(moved.gyration(tool.inertia))
    origin = place = np.array(robot.mounting.force_sensor)
    pull = expected(moved.pull_at(place))
    for _ in range(CENTER_ROUNDS):
        offset = fit_offset(values - moment, pull, signals.period)
        place = origin + within_reach(offset.center())
        pull = expected(moved.pull_at(place))
    placed = in_frame_6(own.placed, robot) if own else values
    untouched = offset.reading(pull) + moment
    drift, drift_std = force_drift((values - untouched)[:, :3], pull, signals.time, signals.period)
    return SensorReading(
        values,
        untouched,
        offset,
        place,
        clock_std,
        None if tool is None else tool.inertia,
        placed,
        start_bias=initial_bias(placed, signals.time, bias_window),
        own_clock=own is not None,
        each=max(1.0, own.step / signals.period) if own else 1.0,
        drift=drift,
        drift_std=drift_std,
    )


def in_frame_6(reading: Array, robot: Robot) -> Array:
    """Return a sensor's reading (N, 6) in the axes of frame 6, by its mounting."""
    turn = robot.mounting.force_sensor_turn_deg
    if not any(turn):
        return reading

    axes = Rotation.from_rotvec(turn, degrees=True).as_matrix()
    return (reading.reshape(-1, 2, 3) @ axes.T).reshape(-1, 6)


def within_reach(center: Array) -> Array:
    """Return a tool's centre of mass (3,) [m], each coordinate limited to MAX_CENTER_DISTANCE; zero
    where unknown.
    """
    return np.nan_to_num(center).clip(-MAX_CENTER_DISTANCE, MAX_CENTER_DISTANCE)


def moved_tool(robot: Robot, kinematics: Kinematics, motion: Motion) -> ToolMotion:
    """Return the motion of a body fixed to frame 6; robot: under the recording's gravity."""
    return tool_motion(
        kinematics.rotation, kinematics.jacobian, motion.qd, motion.qdd, np.array(robot.gravity)
    )
