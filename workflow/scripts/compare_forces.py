"""Every estimate of the contact wrench against the force sensor: in contact, free, overall."""

from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.force.contact_figures import contact_errors, figures_by_contact
from ur5lib.force.mounting import mounting_doubt, opposite_axes
from ur5lib.force.sensor import (
    SensorOffset,
    bias,
    fit_offset,
    move_to_frame_6,
    offset_doubt,
    wrench_of_environment,
)
from ur5lib.robots.description import Robot, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import (
    WRENCH,
    channel,
    labelled,
    labelled_channel,
    period,
    read_json,
    read_table,
    write_json,
    write_table,
)
from ur5lib.timeseries.arrays import Array

SENSOR = [f"ft_{quantity}{axis}" for quantity in "ft" for axis in "xyz"]
NEW = ["Fmap", "least_squares", "observer", "repeat"]


def compare_forces(input: Any, output: Any, params: Any) -> None:
    signals, kinematics = read_table(input.signals), read_table(input.kinematics)
    published, forces = read_table(input.published), read_table(input.forces)
    robot = load_robot(input.arm).mounted(params.gravity)
    summary: dict[str, Any] = {
        "force_sensor": "ft_fx" in signals,
        "share_near_singularity": share_below(kinematics, params.min_singular_value),
        "std": band_widths(forces),
        "errors": {},
    }
    columns: dict[str, Array] = {}
    if "ft_fx" in signals:
        rotation = channel(kinematics, "R6", 9).reshape(-1, 3, 3)
        by_stamps = as_printed(input, signals)
        references, offset = sensor_wrenches(signals, by_stamps, rotation, robot, params)
        summary["offset"] = account(offset, by_stamps, signals, params)
        summary["offset_doubt"] = offset_doubt(offset)
        summary["mounting_doubt"] = doubt(references["compensated"], forces, rotation, offset)
        summary |= against_sensor(references, signals, published, forces)
        for kind, reference in references.items():
            columns |= labelled(reference, kind, WRENCH)
    write_table(signals[["time", "segment"]].join(pd.DataFrame(columns)), output.sensor)
    write_json(summary, output.summary)


def as_printed(input: Any, signals: pd.DataFrame) -> Array:
    """The sensor's reading (N, 6) placed by start stamps alone, as in the thesis."""
    from ur5lib.signals.clocks import clock_from_stamps  # slow to import; most recordings
    from ur5lib.signals.resampling import resample  # have no sensor

    start = read_json(input.quality)["starts"]["force"]
    stamps = clock_from_stamps(start["seconds"], start["std"])
    read = resample(read_table(input.force), stamps, signals["time"].to_numpy())
    return read[SENSOR].to_numpy()


def sensor_wrenches(
    signals: pd.DataFrame, by_stamps: Array, rotation: Array, robot: Robot, params: Any
) -> tuple[dict[str, Array], SensorOffset]:
    """What the sensor says, the environment acting on the arm, and what it says without contact.

    printed: the raw reading; corrected: less its mean at the start, both by start stamps alone;
    compensated: by the best clock, less bias and tool weight, from all samples free of contact. The
    last two at the origin of frame 6.
    """
    reading, gravity = signals[SENSOR].to_numpy(), np.array(robot.gravity)
    offset = fit_offset(reading, rotation, period(signals), gravity)
    position = np.array(robot.mounting.force_sensor)
    references = {"printed": wrench_of_environment(by_stamps, rotation)}
    for kind, read in (
        ("corrected", by_stamps - start_bias(by_stamps, signals, params)),
        ("compensated", reading - offset.reading(rotation, gravity)),
    ):
        wrench = wrench_of_environment(read, rotation)
        references[kind] = move_to_frame_6(wrench, rotation, position)
    return references, offset


def account(
    offset: SensorOffset, by_stamps: Array, signals: pd.DataFrame, params: Any
) -> dict[str, Any]:
    """What was taken off the reading: of kind compensated, and of kind corrected (start_bias)."""
    return asdict(offset) | {
        "free": float(offset.free.mean()),
        "start_bias": start_bias(by_stamps, signals, params),
    }


def start_bias(reading: Array, signals: pd.DataFrame, params: Any) -> Array:
    return bias(reading, signals["time"].to_numpy(), params.bias_window_s)


def doubt(sensor: Array, forces: pd.DataFrame, rotation: Array, offset: SensorOffset) -> str | None:
    """Whether the sensor contradicts the estimate from currents, or the weight of its tool."""
    opposite = []
    if "Fmap_Fx" in forces:
        estimate = labelled_channel(forces, "Fmap", WRENCH)
        opposite = opposite_axes(sensor[:, :3], estimate[:, :3], rotation)
    return mounting_doubt(offset, opposite)


def estimates(
    kind: str, published: pd.DataFrame, forces: pd.DataFrame
) -> dict[str, tuple[Array, Array | None]]:
    """Wrench and standard deviation of every estimate that a reference is compared with."""
    source = "printed" if kind == "printed" else "corrected"
    found: dict[str, tuple[Array, Array | None]] = {
        name: (labelled_channel(published, f"{source}_{name}", WRENCH), None)
        for name in ("Fu", "F", "F*")
        if f"{source}_{name}_Fx" in published
    }
    if kind != "printed":
        for name in NEW:
            if f"{name}_Fx" in forces:
                std = labelled_channel(forces, f"{name}_std", WRENCH)
                found[name] = labelled_channel(forces, name, WRENCH), std
    return found


def against_sensor(
    references: dict[str, Array],
    signals: pd.DataFrame,
    published: pd.DataFrame,
    forces: pd.DataFrame,
) -> dict[str, Any]:
    """Errors by kind of reference and estimate, and contact by contact.

    What is in contact and what is free, the sensor less bias and tool weight says.
    """
    best = references["compensated"]
    force, step = np.linalg.norm(best[:, :3], axis=1), period(signals)
    known = {kind: estimates(kind, published, forces) for kind in references}
    return {
        "errors": {
            kind: {
                name: by_component(figures_by_contact(*estimate, references[kind], force, step))
                for name, estimate in found.items()
            }
            for kind, found in known.items()
        },
        "contacts": {
            name: [*contact_errors(wrench[:, :3], best[:, :3], signals["time"].to_numpy())]
            for name, (wrench, _) in known["compensated"].items()
        },
    }


def by_component(figures: dict[str, dict[str, Array]]) -> dict[str, dict[str, dict[str, float]]]:
    """Figures (6,) with the names of their components, by period."""
    return {
        during: {name: dict(zip(WRENCH, values, strict=True)) for name, values in part.items()}
        for during, part in figures.items()
    }


def band_widths(forces: pd.DataFrame) -> dict[str, dict[str, float]]:
    """Median standard deviation of each new estimate, by component."""
    return {
        name: {c: float(forces[f"{name}_std_{c}"].median()) for c in WRENCH}
        for name in NEW
        if f"{name}_Fx" in forces
    }


def share_below(kinematics: pd.DataFrame, least: float) -> float:
    """Share of the samples near a singularity of the Jacobian."""
    return float((kinematics["sigma_min"] < least).mean())


if __name__ == "__main__":
    run_step(compare_forces, snakemake)  # type: ignore[name-defined]  # noqa: F821
