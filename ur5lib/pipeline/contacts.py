"""Contacts by each estimate: alarms, comparison with the sensor, smallest detectable force."""

from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import Any

import numpy as np

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
from ur5lib.pipeline.force_estimates import Problem
from ur5lib.pipeline.records.currents import Currents, LoadRegressor
from ur5lib.pipeline.records.forces import Forces, SensorWrenches
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import marked

CLASSES = [TOUCH, 5.0, 10.0, 15.0]  # N, that a contact reaches by the sensor
TRIALS, LEAST, MOST = 40, 2.0, 60.0  # pushes in each direction, N

Kind = Callable[[Span], dict[str, Any]]


def detected(
    forces: Forces, sensor: SensorWrenches, thresholds: Mapping[str, float], kind: Kind
) -> dict[str, Any]:
    """Return the alarms of each estimate and their comparison with the sensor, for detection.json.

    kind: whether an alarm is a contact or a load.
    """
    summary: dict[str, Any] = {}
    for name, threshold in thresholds.items():
        if name not in forces.log_odds:
            continue
        odds = forces.log_odds[name]
        raised = alarms(odds, threshold)
        summary[name] = {
            "threshold": threshold,
            "raised": [strongest(span, forces, name) | kind(span) for span in raised],
            "alarms_per_min": len(raised) / (len(odds) * forces.period / 60),
            "time_in_alarm": float(marked(raised, len(odds)).mean()),
        }
        if "compensated" in sensor.wrench:
            live = forces.causal_log_odds.get(name)
            causal = None if live is None else raised_live(live, threshold)
            summary[name] |= against_sensor(odds, raised, causal, sensor)
    return summary


def load_finder(
    currents: Currents,
    forces: Forces,
    regressor: LoadRegressor,
    residuals: Mapping[str, Any],
    prior: ContactPrior,
) -> Kind:
    """Return a function that decides whether a contact is a grasped load, and estimates its mass.

    residuals: residuals.json.
    """
    per_load = regressor.load_regressor
    if currents.external_torque is None or forces.background is None or per_load is None:
        return lambda _: {"kind": "contact"}
    torque = currents.external_torque - forces.background
    spread = ResidualModel.from_dict(residuals["tau_ext"]).spread[MOVING]

    def kind(span: Span) -> dict[str, Any]:
        part = slice(*span)
        known = torque[part], per_load[part], spread
        load = grasped_load(*known, forces.period, prior.efficiency)
        if load is None:
            return {"kind": "contact"}
        return {"kind": "load", "load_mass": load.mass, "load_mass_std": load.std_error}

    return kind


def strongest(span: Span, forces: Forces, name: str) -> dict[str, Any]:
    """Return start and end of an alarm [s], and the largest force in it, with deviations [N]."""
    part = slice(*span)
    force, std = forces.wrench[name][part, :3], forces.std[name][part, :3]
    peak = int(np.argmax(np.nan_to_num(np.linalg.norm(force, axis=1))))
    time = forces.time[part]
    return {
        "start": float(time[0]),
        "end": float(time[-1]),
        "peak": float(time[peak]),
        "force": force[peak],
        "force_std": std[peak],
    }


def against_sensor(
    odds: Array, raised: list[Span], causal: list[Span] | None, sensor: SensorWrenches
) -> dict[str, Any]:
    """Return contacts that the sensor saw, by the force they reach, and how the alarms match them.

    causal: the alarms that are raised while the recording runs, None where that is not known.
    """
    force, step = np.linalg.norm(sensor.wrench["compensated"][:, :3], axis=1), sensor.period
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
    """Return how many contacts that reach a force are found, each by its own alarm, and when.

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
    """Return the median delay [s], None where there is none."""
    return float(np.median(delays)) if len(delays) else None


def smallest_forces(
    problem: Problem, jacobian: Array, prior: ContactPrior, threshold: float, raised: list[Span]
) -> dict[str, Any]:
    """Return the force that F̂ᵐᵃᵖ finds with 95 % probability, pushes put onto a free motion.

    jacobian: (N, 6, 6); raised: the alarms without any push.
    """
    one, used = problem.input, jacobian[problem.rows]

    def log_odds_of(pushed: Array) -> Array:
        own = one.with_torque(one.torque + pushed, one.states)
        return Problem(own, problem.model).solve(used, prior).log_odds

    tried = np.random.default_rng(0).permutation(np.geomspace(LEAST, MOST, TRIALS))
    found = {}
    for axis, direction in zip("xyz", np.eye(6)[:3], strict=True):
        pushes = jacobian, direction, tried, one.period, threshold, raised
        found[axis] = asdict(smallest_force(tried, try_pushes(log_odds_of, *pushes)))
    return found
