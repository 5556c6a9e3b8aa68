"""Judge a recording: beside its force sensor, by its contacts, as rows of the study's tables."""

from dataclasses import replace
from typing import NamedTuple

from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.estimators import LEADING
from ur5lib.force.problem import fmap_problem, unusual_friction
from ur5lib.force.trial_contacts import flange_speed
from ur5lib.records.contacts import Detected
from ur5lib.records.force_errors import Compared
from ur5lib.records.forces import SensorWrenches
from ur5lib.records.gains import GainSummary
from ur5lib.records.judgement import Judgement, Rows
from ur5lib.records.quality import UNUSUAL_FRICTION, Finding
from ur5lib.steps.evidence import Evidence
from ur5lib.steps.judge_contacts import (
    all_alarms,
    causally,
    detected,
    judged_by_torques,
    load_finder,
)
from ur5lib.steps.judge_sensor import compare_with_sensor, published_forces
from ur5lib.steps.predict_currents import slower_than_fit
from ur5lib.thesis.published_constants import PublishedConstants
from ur5lib.thesis.reference import Published, read_reference
from ur5lib.tidy import files, forces, friction, models, motion, written


class JudgedRecording(NamedTuple):
    """What shows how right the estimates of a recording are."""

    sensor: SensorWrenches
    judgement: Judgement


def judge_recording(evidence: Evidence) -> JudgedRecording:
    """Return a recording's forces beside its sensor, and its rows of the tables."""
    sensor, beside_sensor = compare_with_sensor(evidence)
    published = Published(read_reference(evidence.reference).printed, evidence.recording)
    contacts = detect_contacts(evidence, sensor)
    rows = {
        **of_files(evidence),
        **of_motion(evidence, published),
        **of_currents(evidence, published),
        **of_forces(evidence, published, beside_sensor, contacts),
    }
    found = findings_of(evidence, beside_sensor)
    judgement = Judgement(rows, found, beside_sensor.offset)
    return JudgedRecording(sensor, judgement)


def detect_contacts(evidence: Evidence, sensor: SensorWrenches) -> dict[str, Detected]:
    """Return the contacts by each estimate, beside the sensor.

    Of the leading one, also whether they are at the flange, and what the live estimator states.
    """
    forces, currents, thresholds = evidence.forces, evidence.currents, evidence.threshold
    alarms = all_alarms(forces, published_forces(evidence), thresholds)
    moved = evidence.motion.q, flange_speed(evidence.kinematics.jacobian, evidence.motion.qd)
    contacts = detected(alarms, sensor, *moved, thresholds, load_finder(evidence))
    problem = fmap_problem(evidence.motion, currents, evidence.residuals)
    if problem is None or LEADING not in contacts:
        return contacts
    prior = ContactPrior(force=evidence.contact_force_n)
    found = contacts[LEADING]
    at_flange = judged_by_torques(evidence.arm, problem, forces.time, prior, found.raised)
    found = replace(found, raised=at_flange, causal=causally(evidence.live, sensor))
    return contacts | {LEADING: found}


def findings_of(evidence: Evidence, beside_sensor: Compared) -> list[Finding]:
    """Return the findings about the recording's files, clocks and sensor."""
    contradictions, cutoff = evidence.premises.contradictions, evidence.currents_lowpass.cutoff
    slower = slower_than_fit(evidence.signals, evidence.friction, cutoff)
    share = unusual_friction(evidence.motion, evidence.currents, evidence.residuals)
    unusual = [Finding("robot", UNUSUAL_FRICTION, "warning", 1, {"share": share})]
    doubts = [*contradictions.findings, *slower, *(unusual if share is not None else [])]
    contradictions = replace(contradictions, findings=doubts)
    clocks = evidence.alignment.clocks
    return files.findings(evidence.quality, contradictions, clocks, beside_sensor)


def of_files(evidence: Evidence) -> dict[str, Rows]:
    """Return the rows about the recording's files."""
    quality, clocks = evidence.quality, evidence.alignment.clocks
    return written(
        recordings=files.recordings(quality, evidence.signals),
        files=files.files(quality),
        account=files.account(quality),
        clocks=files.clocks(clocks),
    )


def of_motion(evidence: Evidence, published: Published) -> dict[str, Rows]:
    """Return the rows about motion and link models."""
    signals, loop = evidence.signals, evidence.closed_loop
    gains = evidence.gains or GainSummary()
    return written(
        torque_mae=models.torque_mae(signals, evidence.torques, loop, published),
        closed_loop_mae=motion.closed_loop_mae(loop, signals, published) if loop else (),
        gains=motion.gains(gains),
        published_gains=motion.published_gains(gains),
    )


def of_currents(evidence: Evidence, published: Published) -> dict[str, Rows]:
    """Return the rows about currents and the load that they show."""
    constants = evidence.constants or PublishedConstants()
    return written(
        current_rmse=friction.current_rmse(evidence.prediction),
        payload=friction.payload(evidence.prediction),
        published_constants=friction.published_constants(constants, published),
    )


def of_forces(
    evidence: Evidence,
    published: Published,
    beside_sensor: Compared,
    contacts: dict[str, Detected],
) -> dict[str, Rows]:
    """Return the rows about forces and contacts."""
    return written(
        force_mae=forces.force_mae(beside_sensor, published),
        contact_errors=forces.contact_errors(beside_sensor),
        sensed=forces.sensed(beside_sensor),
        detection=forces.detection(contacts),
        fixed_threshold=forces.fixed_threshold(contacts),
        contacts=forces.contacts(contacts),
    )
