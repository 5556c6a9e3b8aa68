"""Contacts by each estimate: alarms, comparison with the sensor, smallest detectable force."""

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np

from ur5lib.force.detection import (
    TOUCH,
    Span,
    alarms,
    compare,
    contacts,
    force_alarms,
    is_free,
    pushes_above,
    raised_live,
    receiver_curve,
)
from ur5lib.force.external_torque import MOVING
from ur5lib.force.grasp import grasped_load
from ur5lib.force.residual_model import ResidualModel
from ur5lib.pipeline.force_input import gears
from ur5lib.pipeline.records.currents import Currents, LoadRegressor
from ur5lib.pipeline.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import marked

CLASSES = [TOUCH, 5.0, 10.0, 15.0]  # N, that a contact reaches by the sensor
CLAIMED = 10.0  # N, from which on the thesis calls its detection along z reliable (Section 6)

Kind = Callable[[Span], dict[str, Any]]


class Alarms(NamedTuple):
    """What one estimate raises.

    evidence: (N,), log-odds of contact, or the size of a force [N]; raised: its alarms; wrench,
    std: (N, 6) [N, Nm], NaN where no deviation is stated.
    """

    evidence: Array
    raised: list[Span]
    wrench: Array
    std: Array


def alarms_by_odds(forces: Forces, name: str, threshold: float) -> Alarms:
    """Return the alarms of an estimate that states odds of contact."""
    odds = forces.log_odds[name]
    return Alarms(odds, alarms(odds, threshold), forces.wrench[name], forces.std[name])


def alarms_by_size(wrench: Array, threshold: float) -> Alarms:
    """Return the alarms of an estimate that states a force alone; threshold: [N]."""
    size = np.nan_to_num(np.linalg.norm(wrench[:, :3], axis=1))
    return Alarms(size, force_alarms(size, threshold), wrench, np.full_like(wrench, np.nan))


def all_alarms(
    forces: Forces, published: PublishedForces, thresholds: Mapping[str, float]
) -> dict[str, Alarms]:
    """Return the alarms of every estimate that the recording has and a threshold is known of."""
    return {
        name: alarms_by_odds(forces, name, threshold)
        for name, threshold in thresholds.items()
        if name in forces.log_odds
    } | {
        name: alarms_by_size(published.corrected[name], threshold)
        for name, threshold in thresholds.items()
        if name in published.corrected
    }


def detected(
    found: Mapping[str, Alarms],
    sensor: SensorWrenches,
    thresholds: Mapping[str, float],
    kind: Kind,
) -> dict[str, Any]:
    """Return the alarms of each estimate and their comparison with the sensor, for detection.json.

    kind: whether an alarm is a contact or a load.
    """
    count, period, time = len(sensor.time), sensor.period, sensor.time
    summary: dict[str, Any] = {}
    for name, own in found.items():
        summary[name] = {
            "threshold": thresholds[name],
            "raised": [strongest(span, time, own) | kind(span) for span in own.raised],
            "alarms_per_min": len(own.raised) / (count * period / 60),
            "time_in_alarm": float(marked(own.raised, count).mean()),
            "axes": {axis: by_axis(own, sensor, i) for i, axis in enumerate("xyz")},
        }
        if "compensated" in sensor.wrench:
            summary[name] |= against_sensor(own, sensor)
    return summary


def causally(
    forces: Forces, sensor: SensorWrenches, thresholds: Mapping[str, float]
) -> dict[str, Any] | None:
    """Return the alarms raised from past samples only, and their comparison with the sensor."""
    if forces.causal_log_odds is None or "causal" not in thresholds:
        return None
    raised = raised_live(forces.causal_log_odds, thresholds["causal"])
    found = {"alarms_per_min": len(raised) / (len(sensor.time) * sensor.period / 60)}
    if "compensated" in sensor.wrench:
        found |= counted(raised, sensed_force(sensor), sensor.period)
    return found


def by_axis(own: Alarms, sensor: SensorWrenches, axis: int) -> dict[str, Any]:
    """Return how an estimate does with the fixed threshold that the thesis claims, on one axis.

    time_above: share of the recording; pushes: that reach the threshold at the sensor, if there is
    one; found: of these.
    """
    force = own.wrench[:, axis]
    figures: dict[str, Any] = {
        "force": CLAIMED,
        "time_above": float(np.mean(np.nan_to_num(np.abs(force)) >= CLAIMED)),
    }
    if "compensated" not in sensor.wrench:
        return figures
    sensed = sensor.wrench["compensated"][:, axis]
    pushes, found = pushes_above(force, sensed, CLAIMED, sensor.period)
    return figures | {"pushes": pushes, "found": found}


def load_finder(
    currents: Currents,
    forces: Forces,
    regressor: LoadRegressor,
    model: ResidualModel | None,
) -> Kind:
    """Return a function that decides whether a contact is a grasped load, and estimates its mass.

    model: of the external torque.
    """
    per_load = regressor.load_regressor
    external, background = currents.external_torque, forces.background
    if external is None or background is None or per_load is None or model is None:
        return lambda _: {"kind": "contact"}
    torque = external - background
    if (known_gears := gears(currents)) is not None:
        torque, _ = known_gears.contact_torque(torque)
    spread = model.doubt * model.spread[MOVING]

    def kind(span: Span) -> dict[str, Any]:
        part = slice(*span)
        known = torque[part], per_load[part], spread
        load = grasped_load(*known, forces.period)
        if load is None:
            return {"kind": "contact"}
        return {"kind": "load", "load_mass": load.mass, "load_mass_std": load.std_error}

    return kind


def strongest(span: Span, time: Array, own: Alarms) -> dict[str, Any]:
    """Return start and end of an alarm [s], and the largest force in it, with deviations [N]."""
    part = slice(*span)
    force, std, seconds = own.wrench[part, :3], own.std[part, :3], time[part]
    peak = int(np.argmax(np.nan_to_num(np.linalg.norm(force, axis=1))))
    return {
        "start": float(seconds[0]),
        "end": float(seconds[-1]),
        "peak": float(seconds[peak]),
        "force": force[peak],
        "force_std": std[peak],
    }


def against_sensor(own: Alarms, sensor: SensorWrenches) -> dict[str, Any]:
    """Return contacts that the sensor saw, by the force they reach, and how the alarms match."""
    force, step = sensed_force(sensor), sensor.period
    free, count = is_free(force, step), len(force)
    wrong, right = receiver_curve(own.evidence, force >= TOUCH)
    in_alarm = marked(own.raised, count)[free]
    return counted(own.raised, force, step) | {
        "free_time_in_alarm": float(in_alarm.mean()) if free.any() else None,
        "roc_area": float(np.trapezoid(right, wrong)),
    }


def sensed_force(sensor: SensorWrenches) -> Array:
    """Return the magnitude (N,) [N] of the force at the sensor."""
    return np.linalg.norm(sensor.wrench["compensated"][:, :3], axis=1)


def counted(raised: list[Span], force: Array, step: float) -> dict[str, Any]:
    """Return how alarms match the contacts at the sensor; force: (N,) [N]; step: [s]."""
    any_contact = compare(raised, contacts(force), step)
    return {
        "classes": [by_class(least, force, raised, step) for least in CLASSES],
        "precision": any_contact.precision(),
        "false_per_min": any_contact.false / (len(force) * step / 60),
        "extra": any_contact.extra,
    }


def by_class(least: float, force: Array, raised: list[Span], step: float) -> dict[str, Any]:
    """Return how many contacts that reach a force are found, each by its own alarm, and when.

    force: (N,) [N], of the sensor; step: [s].
    """
    strong = contacts(force, least)
    found = compare(raised, strong, step)
    return {
        "force": least,
        "contacts": found.contacts,
        "found": found.found,
        "recall": found.recall(),
        "median_delay": median(found.delays),
    }


def median(delays: Array) -> float | None:
    """Return the median delay [s], None where there is none."""
    return float(np.median(delays)) if len(delays) else None
