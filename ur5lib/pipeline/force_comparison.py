"""Every estimate of the contact wrench beside the force sensor."""

from dataclasses import replace
from typing import Any

import numpy as np

from ur5lib.force.contact_figures import contact_errors, figures_by_contact
from ur5lib.force.detection import felt
from ur5lib.pipeline.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.table import WRENCH
from ur5lib.pipeline.sensor_reference import SensorReading
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array

Estimates = dict[str, tuple[Array, Array | None]]  # wrench and its standard deviation, (N, 6)


def compared_estimates(kind: str, published: PublishedForces, forces: Forces) -> Estimates:
    """Return the estimates that a kind of reference is compared with."""
    as_printed = kind == "printed"
    source = published.printed if as_printed else published.corrected
    found: Estimates = {name: (wrench, None) for name, wrench in source.items()}
    if not as_printed:
        found |= {name: (wrench, forces.std[name]) for name, wrench in forces.wrench.items()}
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
    sensor: SensorWrenches, published: PublishedForces, forces: Forces
) -> dict[str, Any]:
    """Return what the sensor felt, and errors by kind of reference and estimate, and by contact.

    What is in contact and what is free, the sensor less bias and tool weight says.
    """
    best = sensor.wrench["compensated"]
    force = np.linalg.norm(best[:, :3], axis=1)
    found = {kind: compared_estimates(kind, published, forces) for kind in sensor.wrench}
    reads = felt(force, sensor.time)
    return {
        "felt": None if reads is None else reads._asdict(),
        "errors": {
            kind: {
                name: by_component(
                    figures_by_contact(*estimate, sensor.wrench[kind], force, sensor.period)
                )
                for name, estimate in estimates.items()
            }
            for kind, estimates in found.items()
        },
        "contacts": {
            name: [*contact_errors(wrench[:, :3], best[:, :3], sensor.time)]
            for name, (wrench, _) in found["compensated"].items()
        },
    }


def by_component(figures: dict[str, dict[str, Array]]) -> dict[str, dict[str, dict[str, float]]]:
    """Return figures (6,) with the names of their components, by period."""
    return {
        during: {name: dict(zip(WRENCH, values, strict=True)) for name, values in part.items()}
        for during, part in figures.items()
    }


def band_widths(forces: Forces) -> dict[str, dict[str, float]]:
    """Return the median standard deviation of each estimate, by component."""
    return {
        name: dict(zip(WRENCH, np.nanmedian(std, axis=0).tolist(), strict=True))
        for name, std in forces.std.items()
    }
