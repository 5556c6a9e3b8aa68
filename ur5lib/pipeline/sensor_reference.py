"""The force sensor's wrench, with which the estimates are compared."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from ur5lib.errors import Remark
from ur5lib.force.sensor import (
    SensorOffset,
    bias,
    mounting_doubt,
    move_to_frame_6,
    offset_doubt,
    opposite_axes,
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

    untouched: the part of bias, weight and inertia of its tool (N, 6); offset: bias and tool;
    by_stamps: the reading placed by start stamps alone, as in the thesis, None for a sensor without
    a clock of its own.
    """

    values: Array
    untouched: Array
    offset: SensorOffset
    by_stamps: Array | None

    @property
    def placed(self) -> Array:
        """Return the reading as it is placed in the thesis, where it has a clock of its own."""
        return self.values if self.by_stamps is None else self.by_stamps


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
        "compensated": at_flange(reading.values - reading.untouched),
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
) -> dict[str, Remark | None]:
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
