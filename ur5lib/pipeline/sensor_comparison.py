"""The force sensor's wrench, and every estimate of the contact wrench beside it."""

from dataclasses import dataclass, replace

import numpy as np

from ur5lib.force.contact_figures import contact_errors, figures_by_contact
from ur5lib.force.detection import felt
from ur5lib.force.sensor import (
    SensorOffset,
    bias,
    mounting_doubt,
    move_to_frame_6,
    offset_doubt,
    opposite_axes,
    sensed,
    wrench_of_environment,
)
from ur5lib.pipeline.records.dynamics import Kinematics
from ur5lib.pipeline.records.force_errors import Compared, OffsetAccount
from ur5lib.pipeline.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.table import WRENCH
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

Estimates = dict[str, tuple[Array, Array | None]]  # wrench and its standard deviation, (N, 6)


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


def with_offset(
    found: Compared,
    reading: SensorReading,
    signals: Signals,
    bias_window: float,
    sensor: SensorWrenches,
    forces: Forces,
    rotation: Array,
) -> Compared:
    """Return a comparison with the offsets subtracted from the reading, for the kinds compensated
    and corrected, and doubts about them and the sensor's mounting.
    """
    own, opposite = reading.offset, []
    if "Fmap" in forces.wrench:
        measured, estimated = sensor.wrench["compensated"], forces.wrench["Fmap"]
        opposite = opposite_axes(measured[:, :3], estimated[:, :3], rotation)
    at_start = bias(reading.placed, signals.time, bias_window)
    account = vars(own) | {"free": float(own.free.mean()), "start_bias": at_start}
    return replace(
        found,
        offset=OffsetAccount(**account),
        offset_doubt=offset_doubt(own),
        mounting_doubt=mounting_doubt(own, opposite),
    )


def compared_estimates(kind: str, published: PublishedForces, forces: Forces) -> Estimates:
    """Return the estimates that a kind of reference is compared with."""
    as_printed = kind == "printed"
    source = published.printed if as_printed else published.corrected
    found: Estimates = {name: (wrench, None) for name, wrench in source.items()}
    if not as_printed:
        found |= {name: (wrench, forces.std.get(name)) for name, wrench in forces.wrench.items()}
    return found


def comparable(
    robot: Robot, signals: Signals, reading: SensorReading, published: PublishedForces
) -> PublishedForces:
    """Return the published estimates that are not the sensor itself.

    With a sensor in the arm's wrist, the controller's own force F^u is this sensor's reading; only
    its raw reading, or another sensor with a clock of its own, is compared with it.
    """
    other = signals.ft_raw_wrench is not None or reading.by_stamps is not None
    if other or not robot.wrist_sensor:
        return published
    return replace(
        published,
        printed={name: wrench for name, wrench in published.printed.items() if name != "Fu"},
        corrected={name: wrench for name, wrench in published.corrected.items() if name != "Fu"},
    )


def against_sensor(
    found: Compared, sensor: SensorWrenches, published: PublishedForces, forces: Forces
) -> Compared:
    """Return a comparison with what the sensor felt, and the errors beside it.

    What is in contact and what is free follows from the sensor less bias and tool weight. Beside a
    sensor without moments, forces alone are compared.
    """
    best = sensor.wrench["compensated"]
    columns = sensed(best)
    force = np.linalg.norm(best[:, :3], axis=1)
    compared = {kind: compared_estimates(kind, published, forces) for kind in sensor.wrench}
    return replace(
        found,
        felt=felt(force, sensor.time),
        errors={
            kind: {
                name: by_component(
                    figures_by_contact(
                        wrench[:, columns],
                        None if std is None else std[:, columns],
                        sensor.wrench[kind][:, columns],
                        force,
                        sensor.period,
                    )
                )
                for name, (wrench, std) in estimates.items()
            }
            for kind, estimates in compared.items()
        },
        contacts={
            name: [*contact_errors(wrench[:, :3], best[:, :3], sensor.time)]
            for name, (wrench, _) in compared["compensated"].items()
        },
    )


def by_component(figures: dict[str, dict[str, Array]]) -> dict[str, dict[str, dict[str, float]]]:
    """Return figures, (6,) or of the force (3,), with the names of their components, by period."""
    return {
        during: {name: dict(zip(WRENCH, values, strict=False)) for name, values in part.items()}
        for during, part in figures.items()
    }


def band_widths(forces: Forces) -> dict[str, dict[str, float]]:
    """Return the median standard deviation of each estimate, by component."""
    return {
        name: dict(zip(WRENCH, np.nanmedian(std, axis=0).tolist(), strict=True))
        for name, std in forces.std.items()
    }
