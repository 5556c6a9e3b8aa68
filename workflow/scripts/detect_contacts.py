"""Contacts by each estimate: alarms, comparison with the sensor, smallest detectable force."""

from dataclasses import replace
from typing import Any

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.residual_model import Residuals
from ur5lib.pipeline.contacts import all_alarms, causally, detected, load_finder
from ur5lib.pipeline.flange_contacts import judged_by_torques
from ur5lib.pipeline.force_estimates import fmap_problem
from ur5lib.pipeline.observability import by_axis, pushed
from ur5lib.records.currents import Currents, LoadRegressor
from ur5lib.records.dynamics import Kinematics
from ur5lib.records.forces import Forces, PublishedForces, SensorWrenches
from ur5lib.records.motion import Motion
from ur5lib.robots.description import load_robot
from ur5lib.tables import read_record, write_json

TRIALS = 120  # pushes


def detect_contacts(input: Any, output: Any, params: Any) -> None:
    forces, sensor = Forces.read(input.forces), SensorWrenches.read(input.sensor)
    currents = Currents.read(input.currents)
    thresholds = read_record(dict[str, float], input.threshold)
    regressor = LoadRegressor.read(input.regressor)
    residuals = read_record(Residuals, input.residuals)
    prior = ContactPrior(force=params.contact_force_n)
    named = load_finder(currents, forces, regressor, residuals.tau_ext)
    found = all_alarms(forces, PublishedForces.read(input.published), thresholds)
    summary = detected(found, sensor, thresholds, named)
    motion = Motion.read(input.motion)
    problem = fmap_problem(motion, currents, residuals)
    if problem is not None and (fmap := summary.get("Fmap")):
        known = load_robot(input.arm), problem, motion.time, prior
        fmap = replace(
            fmap,
            raised=judged_by_torques(*known, fmap.raised),
            causal=causally(forces, sensor, thresholds),
        )
        if params.tries:
            jacobian = Kinematics.read(input.kinematics).jacobian
            trials = pushed(
                problem, jacobian, prior, fmap.threshold, forces.log_odds["Fmap"], TRIALS
            )
            fmap = replace(fmap, smallest_force_95=[*by_axis(trials)])
        summary["Fmap"] = fmap
    write_json(summary, output.detection)
