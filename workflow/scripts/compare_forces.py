"""Every estimate of the contact wrench against the force sensor: in contact, free, overall."""

from typing import Any

from ur5lib.pipeline.carried import Carried
from ur5lib.pipeline.sensor_comparison import (
    SensorReading,
    band_widths,
    beside_sensor,
    compared_estimates,
    sensor_wrenches,
)
from ur5lib.recordings.quality import Quality
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.force_errors import Compared
from ur5lib.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, load_robot
from ur5lib.signals.clock import SettledClock
from ur5lib.tables import read_record, read_table, write_json


def compare_forces(input: Any, output: Any, params: Any) -> None:
    signals, kinematics = Signals.read(input.signals), Kinematics.read(input.kinematics)
    published, forces = PublishedForces.read(input.published), Forces.read(input.forces)
    near = float((kinematics.smallest_singular_value < params.min_singular_value).mean())
    is_sensed, widths = signals.force_sensor is not None, band_widths(forces)
    found = Compared(force_sensor=is_sensed, share_near_singularity=near, std=widths)
    sensor = SensorWrenches(time=signals.time, segment=signals.segment)
    if is_sensed:
        robot = load_robot(input.arm).mounted(params.gravity).with_force_sensor(*params.mounting)
        reading = read_sensor(input, robot, signals, kinematics, params.bias_window_s)
        sensor = sensor_wrenches(robot, signals, reading, kinematics.rotation)
        estimates = compared_estimates(robot, signals, reading, published, forces)
        found = beside_sensor(found, reading, sensor, estimates, kinematics.rotation)
    sensor.write(output.sensor)
    write_json(found, output.summary)


def read_sensor(
    input: Any, robot: Robot, signals: Signals, kinematics: Kinematics, window: float
) -> SensorReading:
    """Return the reading of the arm's own sensor, or of one with a clock of its own."""
    # slow to import, and most recordings have no sensor
    from ur5lib.pipeline.sensor_reading import by_own_clock, moved_tool, sensor_reading

    moved = moved_tool(robot, kinematics, Motion.read(input.motion))
    start = read_record(Quality, input.quality).starts.get("force")
    if start is None:
        whole = signals.ft_raw_wrench is not None  # else, the controller takes its tool off
        tool = read_record(Carried, input.load).payload if whole else None
        return sensor_reading(robot, signals, moved, window, tool=tool)
    clock_std = read_record(dict[str, SettledClock], input.clocks)["force"].end_std
    return by_own_clock(robot, signals, moved, window, clock_std, read_table(input.force), start)
