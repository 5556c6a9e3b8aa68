"""Contacts by each estimate, beside the sensor; which of them are loads, or off the flange."""

from dataclasses import replace

from ur5lib.dynamics.link_model import load_regressor
from ur5lib.force.alarms import Named, all_alarms, detected, false_per_min, not_felt
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.controller import further_or_controller
from ur5lib.force.estimators import LEADING, all_stated
from ur5lib.force.external_torque import JointState
from ur5lib.force.flange_contact import judged_by_torques
from ur5lib.force.force_input import gears
from ur5lib.force.grasp import grasped_load
from ur5lib.force.problem import fmap_problem
from ur5lib.force.residual_model import Residuals
from ur5lib.force.trial_contacts import flange_speed
from ur5lib.records.contacts import Alarm, Detected
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces, FurtherForces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.motion import Motion
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.timeseries.segments import Span


def judge_contacts(
    kinematics: Kinematics,
    signals: Signals,
    motion: Motion,
    premises: Premises,
    currents: Currents,
    forces: Forces,
    sensor: SensorWrenches,
    arm: Robot,
    friction: Friction,
    residuals: Residuals,
    threshold: dict[str, float],
    contact_force_n: float,
    gravity: list[float] | None = None,
    further: FurtherForces | None = None,
) -> dict[str, Detected]:
    """Return the contacts by each estimate that has a threshold, beside the sensor.

    Of the leading one, also whether they are at the flange. arm: as fitted; gravity: in its base
    frame [m/s²], None as described.
    """
    withheld = bool(premises.contradictions.stop_signs or friction.stopped)
    others = further_or_controller(further, arm, signals, withheld)
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
    raised = found[LEADING].raised
    false = false_per_min(raised, sensor, not_felt(raised, at_flange))
    leading = replace(leading, raised=at_flange, false_per_min=false)
    return contacts | {LEADING: leading}


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
