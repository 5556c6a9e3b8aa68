"""The recordings of a built study as runs: for the fit, with a force sensor, without contact."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.finished import StudyFiles
from ur5lib.force.controller import controller_estimate
from ur5lib.force.force_input import Gears, force_input
from ur5lib.identification.current_samples import current_record
from ur5lib.identification.currents import (
    breakaway_torque,
    friction_current,
    load_loss,
    torque_constants,
)
from ur5lib.identification.samples import path_of
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.currents import Currents
from ur5lib.records.dynamics import Kinematics, Torques
from ur5lib.records.forces import Forces, FurtherForces, SensorWrenches
from ur5lib.records.friction import Friction
from ur5lib.records.measured import Measured
from ur5lib.records.motion import Motion
from ur5lib.records.prediction import Prediction
from ur5lib.records.premises import Premises
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot
from ur5lib.study.model import Recording
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.trajectories import group_by_path
from ur5rivals.momentum import momentum_rate
from ur5rivals.run import Estimate, FittedArm, Run

JOINT_COUNT = 6  # of arms that the estimators support
RECORDS: tuple[type[Any], ...] = (Signals, Motion, Torques, Kinematics, Currents, Premises)


class Predicted(AlignedRecording):
    """What estimators learn from, and are scored on."""

    kinematics: Kinematics
    currents: Currents
    prediction: Prediction
    premises: Premises


@dataclass(frozen=True)
class StudyArm:
    """The runs of one arm without an undeclared load.

    fit: contact-free, of the role `fit`; sensed: of the role `contact`, with a force sensor; free:
    contact-free, of the role `validate`, which no fit has seen.
    """

    study: str
    robot: str
    fit: list[Run]
    sensed: list[Run]
    free: list[Run]


def read_arms(folder: Path) -> list[StudyArm]:
    """Return the arms of a built study that estimators can learn from and be scored on.

    Raises InputError where it is not built, or has no such arm.
    """
    if not (folder / "configuration.yaml").is_file():
        raise InputError(f"{folder} is not built; `ur5 run` its study, or name another")
    study = StudyFiles(folder)
    entries = study.configuration().recordings
    names = dict.fromkeys(entry.arm.known_as for entry in entries)
    arms = [read_arm(study, entries, name) for name in names]
    usable = [arm for arm in arms if arm.fit and (arm.sensed or arm.free)]
    if not usable:
        raise InputError(
            f"{folder}: no arm of six joints has recordings with currents of the role `fit`, and "
            "others of the role `validate`, or `contact` with a force sensor; add them"
        )
    return usable


def read_arm(study: StudyFiles, entries: Sequence[Recording], name: str) -> StudyArm:
    """Return the runs of an arm, with common labels of their paths."""
    robot, friction = study.arm(name), study.parameters(Friction, name, "friction")
    cutoff = study.configuration().settings.lowpass.currents.cutoff_hz
    six = len(robot.joints) == JOINT_COUNT
    own = [entry for entry in entries if six and entry.arm.known_as == name and not entry.at_rest]
    used = [
        (entry.role, run)
        for entry in own
        if (run := read_run(study, entry, robot, friction, cutoff)) is not None
    ]
    roles, runs = [role for role, _ in used], label_paths([run for _, run in used])
    free = [run for role, run in zip(roles, runs, strict=True) if role != "contact"]
    runs = [replace(run, repeats=repeats_of(run, free)) for run in runs]
    by_role = {
        role: [run for other, run in zip(roles, runs, strict=True) if other == role]
        for role in ("fit", "contact", "validate")
    }
    sensed = [run for run in by_role["contact"] if run.sensor is not None]
    return StudyArm(study.folder.name, name, by_role["fit"], sensed, by_role["validate"])


def repeats_of(run: Run, free: Sequence[Run]) -> tuple[Run, ...]:
    """Return the other contact-free runs along a run's path; their own repeats exclude this run."""
    same = [other for other in free if other.path == run.path and other.name != run.name]
    return tuple(
        replace(run_of_path, repeats=tuple(other for other in same if other is not run_of_path))
        for run_of_path in same
    )


def read_run(
    study: StudyFiles, entry: Recording, arm: Robot, fitted: Friction, cutoff: float
) -> Run | None:
    """Return a recording, None if its external torque is unknown or its load is undeclared.

    cutoff: of the currents' low-pass [Hz].
    """
    name, robot = entry.name, arm.mounted(entry.known_gravity())
    recording = opened(study, name)
    signals, motion, currents = recording.signals, recording.motion, recording.currents
    record = current_record(recording, robot)
    if record is None or currents.external_torque is None or recording.prediction.is_loaded:
        return None
    fit = fitted.fit_for(name)
    constant = torque_constants(fit)
    assert currents.predicted is not None
    torque = constant * (currents.predicted - record.current)
    premises = recording.premises
    bare = robot.mounted([0, 0, 0])
    weightless = LinkModel(bare.carrying(premises.load.payload), robot.fullest_model())
    return Run(
        name=name,
        path=0,
        period=motion.period,
        segment=motion.segment,
        states=force_input(motion, currents.external_torque, currents, cutoff).states,
        q=motion.q,
        qd=motion.qd,
        qdd=motion.qdd,
        model=record.torque,
        friction=constant * currents.predicted - record.torque,
        jacobian=recording.kinematics.jacobian,
        torque=torque,
        smoothed=currents.external_torque,
        momentum=weightless.momentum(motion.q, motion.qd),
        rate=momentum_rate(weightless, motion.q, motion.qd, motion.qdd, torque),
        breakaway=breakaway_torque(fit),
        gears=Gears(
            record.torque, load_loss(fit, record), constant * friction_current(fit, record)
        ),
        position_error=None if signals.target_q is None else signals.target_q - signals.actual_q,
        measured=Measured.of(signals),
        arm=FittedArm(robot, fitted, premises.load.payload, premises.place),
        ready=ready_estimates(study, name, robot, signals),
        sensor=study.record(SensorWrenches, name, "sensor").wrench.get("compensated"),
    )


def opened(study: StudyFiles, name: str) -> Predicted:
    """Return a recording of a built study, with the files of its results as records."""
    loads = {kind.__name__.lower(): partial(study.record, kind, name) for kind in RECORDS}
    loads["prediction"] = partial(study.record, Prediction, name, "currents")
    return Predicted(loads, name=name)


def ready_estimates(
    study: StudyFiles, name: str, robot: Robot, signals: Signals
) -> dict[str, Estimate]:
    """Return the study's estimates, and the published ones as corrected; in a study without
    published values, only the controller's in place of the latter.
    """
    forces = study.record(Forces, name)
    published: Mapping[str, Array] = controller_estimate(robot, signals)
    if (study.folder / "recordings" / name / "published_forces.parquet").exists():
        published = study.record(FurtherForces, name, "published_forces").corrected
    return {name: Estimate(wrench) for name, wrench in published.items()} | {
        name: Estimate(wrench, forces.std.get(name)) for name, wrench in forces.wrench.items()
    }


def label_paths(runs: list[Run]) -> list[Run]:
    """Return the runs with the labels of their trajectories."""
    passed = [path_of(run.q, run.qd, run.period) for run in runs]
    labels = group_by_path(passed) if runs else np.empty(0, int)
    return [replace(run, path=int(label)) for run, label in zip(runs, labels, strict=True)]
