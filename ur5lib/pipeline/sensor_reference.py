"""The force sensor's wrench, with which the estimates are compared."""

from dataclasses import asdict
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


def sensor_offset(reading: Array, signals: Signals, rotation: Array, robot: Robot) -> SensorOffset:
    """Return bias and tool weight of a reading (N, 6) [N, Nm]; rotation: R_6 (N, 3, 3)."""
    return fit_offset(reading, rotation, signals.period, np.array(robot.gravity))


def sensor_wrenches(
    signals: Signals,
    by_stamps: Array,
    kinematics: Kinematics,
    robot: Robot,
    offset: SensorOffset,
    bias_window: float,
) -> SensorWrenches:
    """Return the sensor's wrench of the environment on the arm, by kind.

    by_stamps: the reading (N, 6) placed by start stamps alone, as in the thesis; robot: under the
    recording's gravity; bias_window: [s], at the start, free of contact.
    """
    assert signals.force_sensor is not None
    rotation, gravity = kinematics.rotation, np.array(robot.gravity)
    position = np.array(robot.mounting.force_sensor)
    at_start = bias(by_stamps, signals.time, bias_window)

    def at_flange(reading: Array) -> Array:
        return move_to_frame_6(wrench_of_environment(reading, rotation), rotation, position)

    wrenches = {
        "printed": wrench_of_environment(by_stamps, rotation),
        "corrected": at_flange(by_stamps - at_start),
        "compensated": at_flange(signals.force_sensor - offset.reading(rotation, gravity)),
    }
    return SensorWrenches(time=signals.time, segment=signals.segment, wrench=wrenches)


def offset_account(
    offset: SensorOffset, by_stamps: Array, signals: Signals, bias_window: float
) -> dict[str, Any]:
    """Return the offsets subtracted from the reading, for the kinds compensated and corrected."""
    return asdict(offset) | {
        "free": float(offset.free.mean()),
        "start_bias": bias(by_stamps, signals.time, bias_window),
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
