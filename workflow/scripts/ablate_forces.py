"""What each part of the force estimate is worth in contact: its error with that part left out."""

from dataclasses import replace
from typing import Any

import numpy as np

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.sensed_contacts import contacts, in_contact
from ur5lib.force.wrench_estimate import Ablation, estimate_wrench
from ur5lib.pipeline.force_run import force_run
from ur5lib.steps import run_step
from ur5lib.tables import (
    WRENCH,
    channel,
    labelled_channel,
    period,
    read_json,
    read_table,
    write_json,
)
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import coverage, interval_score, mean_absolute_error


def ablate_forces(input: Any, output: Any, params: Any) -> None:
    sensor, forces = read_table(input.sensor), read_table(input.forces)
    summary: dict[str, Any] = {}
    if "compensated_Fx" in sensor and "Fmap_Fx" in forces:
        reference = labelled_channel(sensor, "compensated", WRENCH)[:, :3]
        found = variants(input, params, np.linalg.norm(reference, axis=1))
        for name in ("least_squares", "repeat"):
            if f"{name}_Fx" in forces:
                wrench, std = (
                    labelled_channel(forces, part, WRENCH) for part in (name, f"{name}_std")
                )
                found[name] = wrench, std
        summary = {name: figures(wrench, std, reference) for name, (wrench, std) in found.items()}
    write_json(summary, output.ablation)


def variants(input: Any, params: Any, force: Array) -> dict[str, tuple[Array, Array]]:
    """Wrench and standard deviation of F̂ᵐᵃᵖ, whole and with one part left out or replaced."""
    motion = read_table(input.motion)
    run = force_run(read_table(input.currents), motion, "tau_ext")
    jacobian = channel(read_table(input.kinematics), "J", 36).reshape(-1, 6, 6)
    model = ResidualModel.from_dict(read_json(input.residuals)["tau_ext"])
    prior, touched = ContactPrior(force=params.contact_force_n), np.zeros(len(force), bool)
    for span in contacts(force):
        touched[slice(*span)] = True
    told = {
        "whole": (prior, Ablation()),
        "contacts by the sensor": (prior, Ablation(contacts=touched)),
        "no background": (prior, Ablation(background=False)),
        "usual contact": (prior, Ablation(learning=False)),
        "efficiency of 1": (replace(prior, efficiency=1.0), Ablation()),
    }
    assert run is not None
    problem = run.torque, jacobian, run.states, run.segment, period(motion), model
    estimates = {
        name: estimate_wrench(*problem, own, run.doubt, ablation)
        for name, (own, ablation) in told.items()
    }
    return {name: (own.wrench, own.std) for name, own in estimates.items()}


def figures(wrench: Array, std: Array, reference: Array) -> dict[str, Array]:
    """Error, coverage and interval score (3,) in contact, by the sensor's force (N, 3)."""
    where = in_contact(np.linalg.norm(reference, axis=1)) & np.isfinite(wrench).all(axis=1)
    part = wrench[where, :3], std[where, :3], reference[where]
    return {
        "mae": mean_absolute_error(part[0], part[2]),
        "coverage95": coverage(*part),
        "interval_score95": interval_score(*part),
    }


if __name__ == "__main__":
    run_step(ablate_forces, snakemake)  # type: ignore[name-defined]  # noqa: F821
