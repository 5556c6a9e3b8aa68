"""Contacts by each estimate, compared with the sensor; loads, and contacts off the flange."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from operator import attrgetter

import numpy as np

from ur5lib.dynamics.link_model import load_regressor
from ur5lib.force.alarms import (
    Alarm,
    Alarms,
    Named,
    all_alarms,
    detections,
    fixed_thresholds,
    raised,
)
from ur5lib.force.before_wrist import unseen_before_wrist
from ur5lib.force.contact_place import sensed_place
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.controller import further_or_controller
from ur5lib.force.estimators import LEADING, all_stated
from ur5lib.force.external_torque import JointState
from ur5lib.force.fates import contact_rows, with_fates
from ur5lib.force.flange_contact import judged_by_torques
from ur5lib.force.force_input import gears
from ur5lib.force.grasp import grasped_load
from ur5lib.force.problem import Problem, fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.force.sensed_contact import FREE_ROLES
from ur5lib.force.trial_contacts import flange_speed
from ur5lib.force.while_shut import usual_limits
from ur5lib.records.contact_place import ContactPlace, PlaceRow
from ur5lib.records.contacts import ContactError, Contacts
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.force_errors import Compared
from ur5lib.records.forces import Forces, FurtherForces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.opened import Opened
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot
from ur5lib.timeseries.segments import Span, inside_spans

PLACE_ERROR = 0.05  # m


class Inputs(Opened):
    """What is read of a recording."""

    role: str
    gravity: list[float] | None
    kinematics: Kinematics
    signals: Signals
    motion: Motion
    premises: Premises
    currents: Currents
    prediction: Prediction
    forces: Forces
    further: FurtherForces | None
    sensor: SensorWrenches
    compared: Compared


@step("recording", "contacts.json")
def judge_contacts(
    recording: Inputs,
    arm: Robot,
    friction: Friction,
    residuals: Residuals,
    threshold: dict[str, float],
    contact_force_n: float | None,
) -> Contacts:
    """Return the contacts by each estimate that has a threshold, compared with the sensor.

    For the leading estimate, also whether they are at the flange. arm: as fitted. The role of the
    recording decides whether anything touches the arm.
    """
    premises, kinematics, motion = recording.premises, recording.kinematics, recording.motion
    forces, sensor = recording.forces, recording.sensor
    withheld = bool(premises.contradictions.stop_signs or friction.stopped)
    others = further_or_controller(recording.further, arm, recording.signals, withheld)
    found = all_alarms(all_stated(forces, others.corrected), threshold)
    loads = load_finder(recording, arm.mounted(recording.gravity), friction, residuals)
    speed = flange_speed(kinematics.jacobian, motion.qd)
    alarms = {name: raised(own, sensor, motion.q, speed, loads) for name, own in found.items()}
    problem = fmap_problem(motion, recording.currents, residuals)
    is_free = recording.role in FREE_ROLES and not recording.prediction.is_loaded
    places, limits = [], usual_limits(forces)
    if problem is not None and LEADING in alarms:
        prior = ContactPrior.of(arm, contact_force_n, premises.place)
        alarms[LEADING] = judged_by_torques(arm, problem, forces, prior, alarms[LEADING])
        if not is_free:
            change = force_change(problem, kinematics, prior, premises.place, found[LEADING], arm)
            places.append(place_row(premises.place, change, sensor, kinematics))
            where = prior, premises.place, threshold[LEADING]
            limits |= unseen_before_wrist(problem, kinematics, arm, *where)
    return Contacts(
        errors=[*errors_with_fates(recording.compared.contacts, alarms)],
        detections=[
            replace(row, **limits) if name == LEADING else row
            for name, own in found.items()
            for row in detections(name, own, alarms[name], sensor, threshold[name])
        ],
        fixed_thresholds=[
            row for name, own in found.items() for row in fixed_thresholds(name, own, sensor)
        ],
        contacts=[row for name, own in alarms.items() for row in contact_rows(name, own, is_free)],
        places=places,
    )


def force_change(
    problem: Problem,
    kinematics: Kinematics,
    prior: ContactPrior,
    place: ContactPlace,
    own: Alarms,
    arm: Robot,
) -> float | None:
    """Return the mean change [N] of the force in alarms if contacts are PLACE_ERROR farther away.

    None without an alarm.
    """
    inside = inside_spans(own.raised, len(own.evidence))
    if not inside.any():
        return None
    used = kinematics.anew(problem.rows)
    farther = place.farther(PLACE_ERROR).on(used.rotation)
    moved = problem.solve(used.jacobian, prior, farther, arm).wrench
    return float(np.nanmean(np.linalg.norm((moved - own.wrench)[inside, :3], axis=1)))


def place_row(
    place: ContactPlace, change: float | None, sensor: SensorWrenches, kinematics: Kinematics
) -> PlaceRow:
    """Return where contacts are assumed, and where a sensor shows them."""
    x, y, z = place.point
    row = PlaceRow(
        source=place.source, x_m=x, y_m=y, z_m=z, within_m=place.within, force_change_n=change
    )
    if "compensated" not in sensor.wrench:
        return row
    sensed = sensed_place(sensor.wrench["compensated"], kinematics.rotation)
    if sensed is None:
        return row
    (x, y, z), within = sensed[0].tolist(), sensed[1]
    return replace(row, sensed_x_m=x, sensed_y_m=y, sensed_z_m=z, sensed_within_m=within)


def errors_with_fates(
    errors: Iterable[ContactError], alarms: Mapping[str, Sequence[Alarm]]
) -> Iterator[ContactError]:
    """Yield the errors of contacts by estimate, each with its fate (found, missed or merged) if the
    estimate raises alarms.
    """
    for name, rows in groupby(errors, key=attrgetter("estimate")):
        own = [*rows]
        yield from with_fates(own, alarms[name]) if name in alarms else own


def load_finder(recording: Inputs, robot: Robot, friction: Friction, residuals: Residuals) -> Named:
    """Return a function of an alarm's span and the alarm, which returns the alarm: as a grasped
    load with its mass if it is one, else unchanged.

    robot: under the recording's gravity.
    """
    motion, currents, forces = recording.motion, recording.currents, recording.forces
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
