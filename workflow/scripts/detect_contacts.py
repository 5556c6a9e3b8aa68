"""Contacts by each estimate: alarms, what the sensor says of them, the smallest force found."""

from collections.abc import Callable
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.detection import (
    Span,
    alarms,
    compare,
    raised_live,
    receiver_curve,
    smallest_force,
    try_pushes,
)
from ur5lib.force.external_torque import MOVING
from ur5lib.force.grasp import grasped_load
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.sensed_contacts import TOUCH, contacts, is_free
from ur5lib.force.wrench_estimate import estimate_wrench
from ur5lib.pipeline.force_run import force_run
from ur5lib.steps import run_step
from ur5lib.tables import channel, labelled_channel, period, read_json, read_table, write_json
from ur5lib.timeseries.arrays import Array, Mask

CLASSES = [TOUCH, 5.0, 10.0, 15.0]  # N, that a contact reaches by the sensor
AXES = ["Fx", "Fy", "Fz"]
TRIALS, LEAST, MOST = 40, 2.0, 60.0  # pushes in each direction, N


def detect_contacts(input: Any, output: Any, params: Any) -> None:
    forces, sensor = read_table(input.forces), read_table(input.sensor)
    thresholds = read_json(input.threshold)
    summary: dict[str, Any] = {}
    kind = load_finder(input, forces, params)
    for name, threshold in thresholds.items():
        if f"log_odds_{name}" not in forces:
            continue
        odds = forces[f"log_odds_{name}"].to_numpy()
        raised = alarms(odds, threshold)
        minutes = len(odds) * period(forces) / 60
        summary[name] = {
            "threshold": threshold,
            "raised": [strongest(span, forces, name) | kind(span) for span in raised],
            "alarms_per_min": len(raised) / minutes,
            "time_in_alarm": float(marked(raised, len(odds)).mean()),
        }
        if "compensated_Fx" in sensor:
            live = f"causal_log_odds_{name}"
            causal = raised_live(forces[live].to_numpy(), threshold) if live in forces else None
            summary[name] |= against_sensor(odds, raised, causal, sensor)
    if params.role == "validate" and "Fmap" in summary:
        threshold = thresholds["Fmap"]
        raised = alarms(forces["log_odds_Fmap"].to_numpy(), threshold)
        summary["Fmap"]["smallest_force_95"] = smallest_forces(input, threshold, raised, params)
    write_json(summary, output.detection)


def load_finder(input: Any, forces: pd.DataFrame, params: Any) -> Callable[[Span], dict[str, Any]]:
    """What says of a contact whether it is a load that was grasped, and of which mass."""
    currents, regressor = read_table(input.currents), read_table(input.regressor)
    if "tau_ext_0" not in currents or "tau_background_0" not in forces:
        return lambda _: {"kind": "contact"}
    torque = channel(currents, "tau_ext") - channel(forces, "tau_background")
    per_load = channel(regressor, "load_regressor", 24).reshape(-1, 6, 4)
    model = ResidualModel.from_dict(read_json(input.residuals)["tau_ext"])
    prior, step = ContactPrior(force=params.contact_force_n), period(forces)

    def kind(span: Span) -> dict[str, Any]:
        part = slice(*span)
        known = torque[part], per_load[part], model.spread[MOVING]
        load = grasped_load(*known, step, prior.efficiency)
        if load is None:
            return {"kind": "contact"}
        return {"kind": "load", "load_mass": load.mass, "load_mass_std": load.std_error}

    return kind


def strongest(span: Span, forces: pd.DataFrame, name: str) -> dict[str, Any]:
    """Start and end of an alarm [s], and the largest force in it, with standard deviations [N]."""
    during = forces.iloc[slice(*span)]
    wrench, std = (labelled_channel(during, part, AXES) for part in (name, f"{name}_std"))
    peak = int(np.argmax(np.nan_to_num(np.linalg.norm(wrench, axis=1))))
    time = during["time"].to_numpy()
    return {
        "start": float(time[0]),
        "end": float(time[-1]),
        "peak": float(time[peak]),
        "force": wrench[peak],
        "force_std": std[peak],
    }


def against_sensor(
    odds: Array, raised: list[Span], causal: list[Span] | None, sensor: pd.DataFrame
) -> dict[str, Any]:
    """Contacts that the sensor saw, by the force they reach, and what the alarms make of them.

    causal: the alarms that are raised while the recording runs, None where that is not known.
    """
    force = np.linalg.norm(labelled_channel(sensor, "compensated", AXES), axis=1)
    step = period(sensor)
    free = is_free(force, step)
    any_contact = compare(raised, contacts(force), step)
    wrong, right = receiver_curve(odds, force >= TOUCH)
    return {
        "classes": [by_class(least, force, raised, causal, step) for least in CLASSES],
        "precision": any_contact.precision(),
        "false_per_min": any_contact.false / (len(odds) * step / 60),
        "extra": any_contact.extra,
        "free_time_in_alarm": float(marked(raised, len(odds))[free].mean()) if free.any() else None,
        "roc_area": float(np.trapezoid(right, wrong)),
    }


def by_class(
    least: float, force: Array, raised: list[Span], causal: list[Span] | None, step: float
) -> dict[str, Any]:
    """How many of the contacts that reach a force are found, each by an alarm of its own, and when.

    force: (N,) [N], of the sensor; step: [s].
    """
    strong = contacts(force, least)
    found = compare(raised, strong, step)
    live = None if causal is None else compare(causal, strong, step).delays
    return {
        "force": least,
        "contacts": found.contacts,
        "found": found.found,
        "recall": found.recall(),
        "median_delay": median(found.delays),
        "causal_delay": None if live is None else median(live),
    }


def median(delays: Array) -> float | None:
    return float(np.median(delays)) if len(delays) else None


def marked(stretches: list[Span], count: int) -> Mask:
    """Samples (N,) inside any of the stretches."""
    inside = np.zeros(count, bool)
    for span in stretches:
        inside[slice(*span)] = True
    return inside


def smallest_forces(
    input: Any, threshold: float, raised: list[Span], params: Any
) -> dict[str, Any]:
    """The force that F̂ᵐᵃᵖ finds with 95 % probability, pushes put onto a contact-free motion."""
    motion = read_table(input.motion)
    run = force_run(read_table(input.currents), motion, "tau_ext")
    if run is None:
        return {}
    jacobian = channel(read_table(input.kinematics), "J", 36).reshape(-1, 6, 6)
    model = ResidualModel.from_dict(read_json(input.residuals)["tau_ext"])
    prior = ContactPrior(force=params.contact_force_n)
    step = period(motion)

    def log_odds_of(pushed: Array) -> Array:
        problem = run.torque + pushed, jacobian, run.states, run.segment, step
        estimate = estimate_wrench(*problem, model, prior, run.doubt)
        return estimate.log_odds

    forces = np.geomspace(LEAST, MOST, TRIALS)
    tried = np.random.default_rng(0).permutation(forces)
    found = {}
    for axis, direction in zip("xyz", np.eye(6)[:3], strict=True):
        seen = try_pushes(log_odds_of, jacobian, direction, tried, step, threshold, raised)
        found[axis] = asdict(smallest_force(tried, seen))
    return found


if __name__ == "__main__":
    run_step(detect_contacts, snakemake)  # type: ignore[name-defined]  # noqa: F821
