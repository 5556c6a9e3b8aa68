"""Every estimate of the contact wrench against the force sensor: in contact, free, overall."""

from typing import Any

from ur5lib.pipeline.force_comparison import against_sensor, band_widths, comparable
from ur5lib.pipeline.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.motion import Motion
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.sensor_reference import (
    SensorReading,
    offset_account,
    sensor_doubts,
    sensor_wrenches,
)
from ur5lib.robots.description import Payload, load_robot
from ur5lib.signals.clock import SettledClock
from ur5lib.tables import read_json, read_record, read_table, write_json


def compare_forces(input: Any, output: Any, params: Any) -> None:
    signals, kinematics = Signals.read(input.signals), Kinematics.read(input.kinematics)
    published, forces = PublishedForces.read(input.published), Forces.read(input.forces)
    near = kinematics.smallest_singular_value < params.min_singular_value
    summary: dict[str, Any] = {
        "force_sensor": signals.force_sensor is not None,
        "share_near_singularity": float(near.mean()),
        "std": band_widths(forces),
        "errors": {},
    }
    sensor = SensorWrenches(time=signals.time, segment=signals.segment)
    if signals.force_sensor is not None:
        robot = load_robot(input.arm).mounted(params.gravity).with_force_sensor(*params.mounting)
        reading, window = read_sensor(input, robot, signals, kinematics), params.bias_window_s
        sensor = sensor_wrenches(robot, signals, reading, kinematics, window)
        summary["offset"] = offset_account(reading, signals, window)
        summary |= sensor_doubts(sensor, forces, kinematics.rotation, reading.offset)
        published = comparable(robot, signals, reading, published)
        summary |= against_sensor(sensor, published, forces)
    sensor.write(output.sensor)
    write_json(summary, output.summary)


def read_sensor(input: Any, robot: Any, signals: Signals, kinematics: Kinematics) -> SensorReading:
    """Return the reading of the arm's own sensor, or of one with a clock of its own."""
    # slow to import, and most recordings have no sensor
    from ur5lib.pipeline.sensor_reading import moved_tool, sensor_reading
    from ur5lib.pipeline.stamps import by_stamps

    moved = moved_tool(robot, kinematics, Motion.read(input.motion))
    start = read_json(input.quality)["starts"].get("force")
    if start is None:
        known = read_json(input.load)["payload"]
        whole = known and signals.ft_raw_wrench is not None  # the controller takes its tool off
        return sensor_reading(robot, signals, moved, tool=Payload(**known) if whole else None)
    placed = by_stamps(read_table(input.force), start, signals.time, "force")
    clock_std = read_record(dict[str, SettledClock], input.clocks)["force"].end_std
    return sensor_reading(robot, signals, moved, clock_std, placed)
