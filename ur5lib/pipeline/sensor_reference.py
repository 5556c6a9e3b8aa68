"""The force sensor's wrench, with which the estimates are compared."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ur5lib.force.mounting import mounting_doubt, opposite_axes
from ur5lib.force.sensor import (
    SensorOffset,
    bias,
    fit_offset,
    move_to_frame_6,
    offset_doubt,
    wrench_of_environment,
)
from ur5lib.pipeline.records.forces import Forces, SensorWrenches
from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array


@dataclass(frozen=True)
class SensorReading:
    """A force sensor's reading (N, 6) [N, Nm], axes of frame 6, on the robot's clock.

    by_stamps: the same, placed by start stamps alone, as in the thesis, None for a sensor without a
    clock of its own; pull: (N, 3) [m/s²], on each kilogram of its tool; offset: without contact.
    """

    values: Array
    by_stamps: Array | None
    pull: Array
    offset: SensorOffset

    @property
    def placed(self) -> Array:
        """Return the reading as it is placed in the thesis, where it has a clock of its own."""
        return self.values if self.by_stamps is None else self.by_stamps


def device_reading(
    robot: Robot, signals: Signals, kinematics: Kinematics, by_stamps: Array
) -> SensorReading:
    """Return the reading of a sensor with a clock of its own.

    Its tool's inertia is left out: no clock is known well enough for it.
    """
    assert signals.force_sensor is not None
    values, placed = (in_frame_6(part, robot) for part in (signals.force_sensor, by_stamps))
    pull = weight_per_kilogram(robot, kinematics)
    return SensorReading(values, placed, pull, fit_offset(values, pull, signals.period))


def in_frame_6(reading: Array, robot: Robot) -> Array:
    """Return a sensor's reading (N, 6) in the axes of frame 6, by its mounting."""
    turn = robot.mounting.force_sensor_turn_deg
    if not any(turn):
        return reading
    from scipy.spatial.transform import Rotation  # slow to import, and few are turned

    axes = Rotation.from_rotvec(turn, degrees=True).as_matrix()
    return (reading.reshape(-1, 2, 3) @ axes.T).reshape(-1, 6)


def weight_per_kilogram(robot: Robot, kinematics: Kinematics) -> Array:
    """Return R_6ᵀ g (N, 3) [m/s²]; robot: under the recording's gravity."""
    return np.array(robot.gravity) @ kinematics.rotation


def sensor_wrenches(
    robot: Robot,
    signals: Signals,
    reading: SensorReading,
    kinematics: Kinematics,
    bias_window: float,
) -> SensorWrenches:
    """Return the sensor's wrench of the environment on the arm, by kind.

    robot: under the recording's gravity; bias_window: [s], at the start, free of contact.
    """
    rotation, position = kinematics.rotation, np.array(robot.mounting.force_sensor)

    def at_flange(free: Array) -> Array:
        return move_to_frame_6(wrench_of_environment(free, rotation), rotation, position)

    at_start = bias(reading.placed, signals.time, bias_window)
    wrenches = {
        "printed": wrench_of_environment(reading.placed, rotation),
        "corrected": at_flange(reading.placed - at_start),
        "compensated": at_flange(reading.values - reading.offset.reading(reading.pull)),
    }
    if reading.by_stamps is None:
        del wrenches["printed"]
    return SensorWrenches(time=signals.time, segment=signals.segment, wrench=wrenches)


def offset_account(reading: SensorReading, signals: Signals, bias_window: float) -> dict[str, Any]:
    """Return the offsets subtracted from the reading, for the kinds compensated and corrected."""
    offset = reading.offset
    return asdict(offset) | {
        "free": float(offset.free.mean()),
        "start_bias": bias(reading.placed, signals.time, bias_window),
    }


def sensor_doubts(
    sensor: SensorWrenches, forces: Forces, rotation: Array, offset: SensorOffset
) -> dict[str, str | None]:
    """Return whether the sensor contradicts the estimate from currents or the weight of its tool,
    and whether its bias may be a push.
    """
    opposite = []
    if "Fmap" in forces.wrench:
        measured, estimated = sensor.wrench["compensated"], forces.wrench["Fmap"]
        opposite = opposite_axes(measured[:, :3], estimated[:, :3], rotation)
    return {
        "offset_doubt": offset_doubt(offset),
        "mounting_doubt": mounting_doubt(offset, opposite),
    }
