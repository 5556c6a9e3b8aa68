"""Every estimate of the contact wrench beside the force sensor."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from ur5lib.force.contact_figures import contact_errors, figures_by_contact
from ur5lib.pipeline.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.pipeline.records.signals import Signals
from ur5lib.pipeline.records.table import WRENCH
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


def is_sensors_own(robot: Robot, signals: Signals, starts: Mapping[str, Any]) -> bool:
    """Return whether the controller's force is the very sensor that it would be compared with.

    starts: of the devices with a clock of their own. So it is with the sensor in an arm's wrist,
    unless its raw reading was recorded.
    """
    return robot.wrist_sensor and signals.ft_raw_wrench is None and starts.get("force") is None


def without_controllers_own(published: PublishedForces) -> PublishedForces:
    """Return the published estimates without the controller's own."""
    others = {"F", "F*"}
    return replace(
        published,
        printed={name: published.printed[name] for name in others & {*published.printed}},
        corrected={name: published.corrected[name] for name in others & {*published.corrected}},
    )


def against_sensor(
    sensor: SensorWrenches, published: PublishedForces, forces: Forces
) -> dict[str, Any]:
    """Return errors by kind of reference and estimate, and contact by contact.

    What is in contact and what is free, the sensor less bias and tool weight says.
    """
    best = sensor.wrench["compensated"]
    force = np.linalg.norm(best[:, :3], axis=1)
    found = {kind: compared_estimates(kind, published, forces) for kind in sensor.wrench}
    return {
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
