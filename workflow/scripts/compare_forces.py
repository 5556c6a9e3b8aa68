"""Every estimate of the contact wrench against the force sensor: in contact, free, overall."""

from typing import Any

from ur5lib.pipeline.force_comparison import against_sensor, band_widths
from ur5lib.pipeline.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.pipeline.records.kinematics import Kinematics
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.sensor_reference import (
    offset_account,
    sensor_doubts,
    sensor_offset,
    sensor_wrenches,
)
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_json, read_table, write_json
from ur5lib.timeseries.arrays import Array


def compare_forces(input: Any, output: Any, params: Any) -> None:
    signals, kinematics = Signals.read(input.signals), Kinematics.read(input.kinematics)
    published, forces = PublishedForces.read(input.published), Forces.read(input.forces)
    robot, reading = load_robot(input.arm).mounted(params.gravity), signals.force_sensor
    near = kinematics.smallest_singular_value < params.min_singular_value
    summary: dict[str, Any] = {
        "force_sensor": reading is not None,
        "share_near_singularity": float(near.mean()),
        "std": band_widths(forces),
        "errors": {},
    }
    sensor = SensorWrenches(time=signals.time, segment=signals.segment)
    if reading is not None:
        start = read_json(input.quality)["starts"]["force"]
        by_stamps = placed_by_stamps(read_table(input.force), start, signals.time)
        offset = sensor_offset(reading, signals, kinematics.rotation, robot)
        window = params.bias_window_s
        sensor = sensor_wrenches(signals, by_stamps, kinematics, robot, offset, window)
        summary["offset"] = offset_account(offset, by_stamps, signals, window)
        summary |= sensor_doubts(sensor, forces, kinematics.rotation, offset)
        summary |= against_sensor(sensor, published, forces)
    sensor.write(output.sensor)
    write_json(summary, output.summary)


def placed_by_stamps(device: Any, start: Any, time: Array) -> Array:
    """Return the sensor's reading (N, 6) placed by its start stamp alone, as in the thesis."""
    from ur5lib.pipeline.stamps import by_stamps  # slow to import, and most have no sensor

    return by_stamps(device, start, time, "force")
