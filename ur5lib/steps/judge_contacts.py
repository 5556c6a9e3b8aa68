"""Contacts by each estimate: alarms, comparison with the sensor, smallest detectable force."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5lib.dynamics.link_model import load_regressor
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.detection import (
    CONTACT_FORCE,
    TOUCH_FORCE,
    Span,
    alarms,
    compare,
    contacts,
    force_alarms,
    is_free,
    pushes_above,
    receiver_curve,
)
from ur5lib.force.estimators import LEADING, Stated, all_stated
from ur5lib.force.external_torque import JointState, finite_rows
from ur5lib.force.flange_contact import (
    MAX_CONTACT_SAMPLES,
    MIN_PROBABILITY_ELSEWHERE,
    flange_probability,
    place_jacobian,
    places,
)
from ur5lib.force.force_input import ForceInput, gears
from ur5lib.force.gate import TorqueVariances, diagonal
from ur5lib.force.grasp import grasped_load
from ur5lib.force.problem import Problem, fmap_problem
from ur5lib.force.published import published_or_controller
from ur5lib.force.residual_model import Residuals
from ur5lib.force.trial_contacts import flange_speed
from ur5lib.records.contacts import Alarm, Causal, Detected, ForceClass, Matched, OnAxis
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces, LiveForces, PublishedForces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array, Labels
from ur5lib.timeseries.segments import inside_spans, runs

FORCE_CLASSES = [TOUCH_FORCE, CONTACT_FORCE, 10.0, 15.0]  # N, that a contact reaches by the sensor
RELIABLE_FORCE_OF_THESIS = 10.0  # N; along z, detection is reliable from there on (Section 6)

Named = Callable[[Span, Alarm], Alarm]


class Alarms(NamedTuple):
    """What one estimate raises.

    evidence: (N,), log-odds of contact, or the size of a force [N]; raised: its alarms; wrench,
    std: (N, 6) [N, Nm], NaN where no deviation is stated.
    """

    evidence: Array
    raised: list[Span]
    wrench: Array
    std: Array


def judge_contacts(
    kinematics: Kinematics,
    signals: Signals,
    motion: Motion,
    premises: Premises,
    currents: Currents,
    forces: Forces,
    live: LiveForces,
    sensor: SensorWrenches,
    arm: Robot,
    friction: Friction,
    residuals: Residuals,
    threshold: dict[str, float],
    contact_force_n: float,
    gravity: list[float] | None = None,
    published: PublishedForces | None = None,
) -> dict[str, Detected]:
    """Return the contacts by each estimate that has a threshold, beside the sensor.

    Of the leading one, also whether they are at the flange, and what the live estimator states.
    arm: as fitted; gravity: in its base frame [m/s²], None as described.
    """
    withheld = bool(premises.contradictions.stop_signs or friction.stopped)
    others = published_or_controller(published, arm, signals, withheld)
    found = all_alarms(all_stated(forces, others.corrected), threshold)
    loads = load_finder(arm.mounted(gravity), motion, currents, forces, friction, residuals)
    contacts = detected(
        found, sensor, motion.q, flange_speed(kinematics.jacobian, motion.qd), threshold, loads
    )
    problem = fmap_problem(motion, currents, residuals)
    if problem is None or LEADING not in contacts:
        return contacts
    prior, leading = ContactPrior(force=contact_force_n), contacts[LEADING]
    at_flange = judged_by_torques(arm, problem, forces.time, prior, leading.raised)
    leading = replace(leading, raised=at_flange, causal=causally(live, sensor))
    return contacts | {LEADING: leading}


def alarms_of(estimate: Stated, threshold: float) -> Alarms:
    """Return the alarms of an estimate: by its odds of contact, where it states a force alone by
    the size of this, of which the threshold then is [N].
    """
    wrench, std, odds = estimate
    std = np.full_like(wrench, np.nan) if std is None else std
    if odds is not None:
        return Alarms(odds, alarms(odds, threshold), wrench, std)
    size = np.nan_to_num(np.linalg.norm(wrench[:, :3], axis=1))
    return Alarms(size, force_alarms(size, threshold), wrench, std)


def all_alarms(
    estimates: Mapping[str, Stated], thresholds: Mapping[str, float]
) -> dict[str, Alarms]:
    """Return the alarms of every estimate that the recording has and a threshold is known of."""
    return {
        name: alarms_of(estimates[name], threshold)
        for name, threshold in thresholds.items()
        if name in estimates
    }


def detected(
    found: Mapping[str, Alarms],
    sensor: SensorWrenches,
    q: Array,
    speed: Array,
    thresholds: Mapping[str, float],
    named: Named,
) -> dict[str, Detected]:
    """Return the alarms of each estimate, and their comparison with the sensor.

    q: (N, n) [rad]; speed: of the flange (N,) [m/s]; named: returns an alarm with its kind, a
    contact or a load.
    """
    return {
        name: Detected(
            **vars(matched(own.raised, sensor)),
            threshold=thresholds[name],
            raised=[
                replace(
                    named(span, strongest(span, sensor.time, q, own)),
                    flange_speed=float(speed[slice(*span)].mean()),
                )
                for span in own.raised
            ],
            time_in_alarm=float(inside_spans(own.raised, len(sensor.time)).mean()),
            axes={axis: by_axis(own, sensor, i) for i, axis in enumerate("xyz")},
            free_time_in_alarm=free_time_in_alarm(own, sensor),
            roc_area=roc_area(own, sensor),
        )
        for name, own in found.items()
    }


def causally(live: LiveForces, sensor: SensorWrenches) -> Causal | None:
    """Return the contacts that the live estimator states, and their comparison with the sensor."""
    if live.contact is None or live.known is None:
        return None
    found = matched([(first, last) for first, last in runs(live.contact).tolist()], sensor)
    return Causal(**vars(found), unknown=float(1 - live.known.mean()))


def by_axis(own: Alarms, sensor: SensorWrenches, axis: int) -> OnAxis:
    """Return how an estimate does with the fixed threshold that the thesis claims, on one axis."""
    force = own.wrench[:, axis]
    above = float(np.mean(np.nan_to_num(np.abs(force)) >= RELIABLE_FORCE_OF_THESIS))
    if "compensated" not in sensor.wrench:
        return OnAxis(RELIABLE_FORCE_OF_THESIS, above)
    sensed = sensor.wrench["compensated"][:, axis]
    return OnAxis(
        RELIABLE_FORCE_OF_THESIS,
        above,
        *pushes_above(force, sensed, RELIABLE_FORCE_OF_THESIS, sensor.period),
    )


def load_finder(
    robot: Robot,
    motion: Motion,
    currents: Currents,
    forces: Forces,
    friction: Friction,
    residuals: Residuals,
) -> Named:
    """Return a function that decides whether an alarm is a grasped load, and estimates its mass.

    robot: under the recording's gravity.
    """
    external, background = currents.external_torque, forces.background
    model = residuals.tau_ext
    if external is None or background is None or model is None or not friction.from_:
        return lambda _, alarm: alarm
    torque = external - background
    if (known_gears := gears(currents)) is not None:
        torque, _ = known_gears.contact_torque(torque)
    spread = model.doubt * model.spread[JointState.MOVING]

    def named(span: Span, alarm: Alarm) -> Alarm:
        part = slice(*span)
        per_load = load_regressor(
            robot, robot.fullest_model(), motion.q[part], motion.qd[part], motion.qdd[part]
        )
        load = grasped_load(torque[part], per_load, spread, forces.period)
        if load is None:
            return alarm
        return replace(alarm, kind="load", load_mass=load.mass, load_mass_std=load.std_error)

    return named


def strongest(span: Span, time: Array, q: Array, own: Alarms) -> Alarm:
    """Return an alarm with the largest force in it; time: (N,) [s], q: (N, n) [rad]."""
    first, last = span
    peak = peak_of(span, own)
    times = float(time[first]), float(time[last - 1]), float(time[peak])
    return Alarm(*times, own.wrench[peak, :3], own.std[peak, :3], q[peak])


def peak_of(span: Span, own: Alarms) -> int:
    """Return the sample of the largest force in an alarm."""
    force = own.wrench[slice(*span), :3]
    return span[0] + int(np.argmax(np.nan_to_num(np.linalg.norm(force, axis=1))))


def free_time_in_alarm(own: Alarms, sensor: SensorWrenches) -> float | None:
    """Return the share of the samples without contact that are in alarm, None without a sensor."""
    if (force := sensed_force(sensor)) is None:
        return None
    free = is_free(force, sensor.period)
    return float(inside_spans(own.raised, len(force))[free].mean()) if free.any() else None


def roc_area(own: Alarms, sensor: SensorWrenches) -> float | None:
    """Return the area under the receiver's curve by sample, None without a sensor."""
    if (force := sensed_force(sensor)) is None:
        return None
    wrong, right = receiver_curve(own.evidence, force >= TOUCH_FORCE)
    return float(np.trapezoid(right, wrong))


def sensed_force(sensor: SensorWrenches) -> Array | None:
    """Return the magnitude (N,) [N] of the force at the sensor, None without one."""
    if "compensated" not in sensor.wrench:
        return None
    return np.linalg.norm(sensor.wrench["compensated"][:, :3], axis=1)


def matched(raised: list[Span], sensor: SensorWrenches) -> Matched:
    """Return how many alarms are raised, and how they match the contacts at a sensor."""
    step = sensor.period
    minutes = len(sensor.time) * step / 60
    if (force := sensed_force(sensor)) is None:
        return Matched(alarms_per_min=len(raised) / minutes)
    any_contact = compare(raised, contacts(force), step)
    return Matched(
        alarms_per_min=len(raised) / minutes,
        classes=[by_class(least, force, raised, step) for least in FORCE_CLASSES],
        precision=any_contact.precision(),
        false_per_min=any_contact.false / minutes,
        extra=any_contact.extra,
    )


def by_class(least: float, force: Array, raised: list[Span], step: float) -> ForceClass:
    """Return how many contacts that reach a force are found, each by its own alarm, and when.

    force: (N,) [N], of the sensor; step: [s].
    """
    found = compare(raised, contacts(force, least), step)
    late = float(np.median(found.delays)) if len(found.delays) else None
    return ForceClass(least, found.contacts, found.found, found.recall(), late, found.merged)


def judged_by_torques(
    robot: Robot, problem: Problem, time: Array, prior: ContactPrior, raised: list[Alarm]
) -> list[Alarm]:
    """Return alarms of F̂ᵐᵃᵖ with whether they are off the flange; time: (N,) [s].

    Loads, and contacts in which no torque is known, stay as they are.
    """
    return [
        replace(own, off_flange=is_off_flange(robot, problem, time, prior, own)) for own in raised
    ]


def is_off_flange(
    robot: Robot, problem: Problem, time: Array, prior: ContactPrior, alarm: Alarm
) -> bool:
    """Return whether the torques of a contact exclude that it is on the last link or a tool."""
    run, model = problem
    rows = middle_half(run, time, alarm.start, alarm.end)
    if alarm.kind != "contact" or not len(rows):
        return False
    noise = TorqueVariances.of(run.states[rows], model, prior, run.load_std()[rows])
    spread = diagonal(noise.spread + noise.hidden)
    frames = link_frames(robot, run.q[rows])
    levers = {
        link: [place_jacobian(*frames, link, place) for place in along]
        for link, along in places(*frames).items()
    }
    return (
        1 - flange_probability(run.torque[rows], levers, spread, prior.sizes)
        >= MIN_PROBABILITY_ELSEWHERE
    )


def middle_half(run: ForceInput, time: Array, start: float, end: float) -> Labels:
    """Return at most MAX_CONTACT_SAMPLES rows of known torque in the middle half of a contact [s].

    The low-pass blurs its ends.
    """
    quarter = (end - start) / 4
    inside = (time >= start + quarter) & (time <= end - quarter)
    rows = np.flatnonzero(inside & finite_rows(run.torque) & finite_rows(run.q))
    return rows[:: max(1, len(rows) // MAX_CONTACT_SAMPLES)]
