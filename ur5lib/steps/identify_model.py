"""The link models that torques show: the controller's those of rotors, then of rigid bodies; the
joints' own those of an arm whose links are unknown.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import reason
from ur5lib.identification import rotor_inertia
from ur5lib.identification.base_parameters import (
    PARAMETERS_PER_JOINT,
    InertialEstimate,
    Stack,
    base_parameters,
    identified_model,
    identify,
    prior_width,
    stack,
    torque_error,
)
from ur5lib.identification.consistency import consistent_parameters, smallest_eigenvalues
from ur5lib.identification.current_samples import Smoother, measured_samples
from ur5lib.identification.excitation import candidate_motions, check_excitation
from ur5lib.identification.measured_torques import FittedArm, fit_arm
from ur5lib.identification.torque_rows import MeasuredRun
from ur5lib.records.carried import configured_payload
from ur5lib.records.models import BaseParameter, Identification, Rotors
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, robot_yaml
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import written_bodies
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import Butterworth, zero_phase_lowpass
from ur5lib.timeseries.sampling import differentiate
from ur5lib.timeseries.segments import BLOCK_DURATION, by_segment, unbroken

ROW_STEP = 0.032  # s, between rows of the controller's torques, which have no noise to average
TORQUE_RESOLUTION = 1e-3  # Nm: noise of a torque in the excitation check
SPEED, ACCELERATION = 1.5, 3.0  # rad/s, rad/s²: of the motions that it may suggest
DESCRIPTION = "identified from the controller's torques, physically consistent"
MEASURED_DESCRIPTION = "identified from measured torques, physically consistent"

Block = tuple[Array, Array]  # regressors (N, n, P) and torques (N, n) [Nm]


class IdentifiedModel(NamedTuple):
    """An arm with its fitted models, as YAML and URDF, and how these were found."""

    arm: str
    urdf: str
    rotors: Rotors
    summary: Identification


def identify_model(
    arm: Robot,
    signals: Mapping[str, Signals],
    motion: Mapping[str, Motion],
    gravities: dict[str, list[float] | None],
    lowpass: Butterworth,
    currents: Butterworth,
) -> IdentifiedModel:
    """Return the arm with rotors fitted to the controller's torques, and with the rigid bodies that
    these show; of unknown links, with those that the measured torques of its joints show.

    signals, motion, gravities: of the arm's `fit` recordings; lowpass: of the controller's torques;
    currents: of currents, and of the torques in their place.
    """
    if arm.links == "unknown":
        return with_unknown_links(arm, signals, motion, gravities, Smoother(*currents))
    rotors = fitted_rotors(arm, signals, motion, gravities, lowpass)
    robot = rotor_inertia.with_rotors(arm, rotors)
    blocks = {
        name: [*torque_blocks(robot.mounted(gravities[name]), signals[name], motion[name], lowpass)]
        for name in signals
    }
    each = [block for part in blocks.values() for block in part]
    try:
        robot, found = with_identified(robot, [gravities[name] for name in blocks], each)
    except ValueError as error:  # too little was recorded, or nothing physical explains it
        found = Identification(refused=reason(error))
    found = replace(found, from_=[name for name, part in blocks.items() if part])
    name = "identified" if "identified" in robot.models else robot.chosen_model
    return IdentifiedModel(
        robot_yaml(robot), urdf(robot, written_bodies(robot, name)), rotors, found
    )


def with_unknown_links(
    arm: Robot,
    signals: Mapping[str, Signals],
    motion: Mapping[str, Motion],
    gravities: Mapping[str, list[float] | None],
    smooth: Smoother,
) -> IdentifiedModel:
    """Return the arm with the links, gears and counterbalances that its joints' torques show.

    Where they show none, its links remain unknown.
    """
    runs = [
        run
        for name in signals
        for run in measured_runs(arm.mounted(gravities[name]), name, signals[name], motion[name])
    ]
    try:
        fitted = fit_arm(arm, runs, smooth)
        robot = with_fitted(arm, fitted)
        models = models_under(arm, [gravities[run.samples.name] for run in runs])
        summary = known_bodies(models, fitted.estimate, fitted.parameters, fitted.mae)
    except ValueError as error:
        robot, summary = arm, Identification(refused=reason(error))
    summary = replace(summary, from_=[run.samples.name for run in runs])
    bodies = written_bodies(robot, robot.chosen_model)
    return IdentifiedModel(robot_yaml(robot), urdf(robot, bodies), Rotors(), summary)


def measured_runs(
    robot: Robot, name: str, signals: Signals, motion: Motion
) -> Iterator[MeasuredRun]:
    """Yield a recording with measured torques, less that of the payload told to the controller.

    robot: under the recording's gravity; of currents, its known constants give the torques.
    """
    model, states = LinkModel(robot, robot.chosen_model), (motion.q, motion.motor_qd, motion.qdd)
    loaded = LinkModel(robot.carrying(configured_payload(signals)), robot.chosen_model)
    load = loaded.inverse_dynamics(*states) - model.inverse_dynamics(*states)
    samples = measured_samples(name, signals, motion, robot, load)
    if samples is not None:
        torque = robot.maker_torque_constants() * samples.current
        bare = replace(samples, current=torque - load)
        yield MeasuredRun(bare, motion.qdd, model.regressor)


def with_fitted(arm: Robot, fitted: FittedArm) -> Robot:
    """Return the arm with fitted links in place of its placeholders, and what else was found."""
    model = identified_model(arm, fitted.parameters, MEASURED_DESCRIPTION)
    return arm.model_copy(
        update={
            "links": "fitted",
            "masses": model.masses,
            "models": {"identified": model},
            "chosen_model": "identified",
            "balanced_joints": fitted.balanced,
        }
    )


def fitted_rotors(
    arm: Robot,
    signals: Mapping[str, Signals],
    motion: Mapping[str, Motion],
    gravities: Mapping[str, list[float] | None],
    lowpass: Butterworth,
) -> Rotors:
    """Return each joint's rotor inertia, from the controller's torque less that of rigid links."""
    each = {
        name: rotor_samples(arm.mounted(gravities[name]), signals[name], motion[name], lowpass)
        for name in signals
    }
    samples = {name: sample for name, sample in each.items() if sample is not None}
    if not samples:
        return Rotors()
    fit = rotor_inertia.fit_rotor_inertia(*zip(*samples.values(), strict=True))
    return Rotors([*samples], fit.value, fit.std_error)


def with_identified(
    robot: Robot, gravities: Sequence[list[float] | None], blocks: list[Block]
) -> tuple[Robot, Identification]:
    """Return the arm with the model "identified" from some blocks, and how it was found.

    gravities: of the recordings, which decide what their torques determine.
    Raises RefusalError where there are too few blocks, or none that bodies could explain.
    """
    data = stack(blocks)
    models = models_under(robot, gravities)
    estimate = identify(data, models[0].parameters, prior_width(len(models[0].parameters)))
    parameters = consistent_parameters(estimate)
    model = identified_model(robot, parameters, DESCRIPTION)
    found = identification(models, data, estimate, parameters, blocks)
    return robot.with_model("identified", model), found


def models_under(robot: Robot, gravities: Sequence[list[float] | None]) -> list[LinkModel]:
    """Return an arm under each of several gravities, once each."""
    unique = [gravity for k, gravity in enumerate(gravities) if gravity not in gravities[:k]]
    return [LinkModel(robot.mounted(gravity), robot.chosen_model) for gravity in unique]


def identification(
    models: Sequence[LinkModel],
    data: Stack,
    estimate: InertialEstimate,
    parameters: Array,
    blocks: list[Block],
) -> Identification:
    """Return base parameters, errors with and without consistency, and undetermined parameters."""
    values = {"without constraint": estimate.parameters, "consistent": parameters}
    mae = {name: torque_error(blocks, value) for name, value in values.items()}
    candidates = candidate_regressors(models)
    base = base_parameters([*candidates.values()][-1])
    excitation = check_excitation(
        data, base, estimate.width, np.full_like(estimate.noise, TORQUE_RESOLUTION), candidates
    )
    return replace(known_bodies(models, estimate, parameters, mae), excitation=excitation)


def candidate_regressors(models: Sequence[LinkModel]) -> dict[str, Array]:
    """Return the regressors (N, n, P) of motions that may be suggested, under all gravities."""
    joints = len(models[0].parameters) // PARAMETERS_PER_JOINT
    return {
        name: np.concatenate([model.regressor(*motion) for model in models])
        for name, motion in candidate_motions(joints, SPEED, ACCELERATION).items()
    }


def known_bodies(
    models: Sequence[LinkModel],
    estimate: InertialEstimate,
    parameters: Array,
    mae: dict[str, Array],
) -> Identification:
    """Return base parameters, errors and definiteness of an estimate, and of bodies near it."""
    base = base_parameters([*candidate_regressors(models).values()][-1])
    values = base.groups @ parameters, estimate.standard_errors(base.groups)
    known = map(bool, estimate.determined(base.groups))
    return Identification(
        noise=estimate.noise,
        parameters=[*map(BaseParameter, base.names(), *values, known, base.groups)],
        mae=mae,
        smallest_eigenvalues={
            "without constraint": smallest_eigenvalues(estimate.parameters),
            "consistent": smallest_eigenvalues(parameters),
        },
    )


def torque_states(signals: Signals, motion: Motion) -> tuple[tuple[Array, Array, Array], bool]:
    """Return q, q̇, q̈ (N, 6) that go with `target_moment`, and whether they are its exact targets.

    Where targets were not recorded, the measured motion of the motors: the controller knows rotors
    and rigid links, but no vibration between them.
    """
    q, qd, qdd = signals.target_q, signals.target_qd, signals.target_qdd
    if q is None or qd is None or qdd is None:
        motor_qdd = by_segment(differentiate, motion.motor_qd, motion.segment, signals.period)
        return (motion.q, motion.motor_qd, motor_qdd), False
    return (q, qd, qdd), True


def comparable(rows: Array, signals: Signals, exact: bool, design: Butterworth) -> Array:
    """Return rows (N, M) of torques and regressors, NaN where a frame was interpolated.

    Unless the states are exact, all are low-passed alike: measured accelerations already are.
    """
    if not exact:
        rate = 1 / signals.period
        rows = by_segment(zero_phase_lowpass, rows, signals.segment, rate, *design)
    return np.where(signals.interpolated[:, None], np.nan, rows)


def rotor_samples(
    robot: Robot, signals: Signals, motion: Motion, design: Butterworth
) -> tuple[Array, Array, Array] | None:
    """Return the torque that rigid links leave, q̇ and q̈, (N, 6) each, NaN where interpolated.

    robot: under the recording's gravity; its links carry the payload that the controller was given:
    `target_moment` contains it. None where that was not recorded.
    """
    if signals.target_moment is None:
        return None
    states, exact = torque_states(signals, motion)
    model = LinkModel(robot.carrying(configured_payload(signals)), robot.chosen_model)
    residual = signals.target_moment - model.inverse_dynamics(*states)
    samples = comparable(np.hstack([residual, *states[1:]]), signals, exact, design)
    residual, qd, qdd = np.hsplit(samples, 3)
    return residual, qd, qdd


def torque_blocks(
    robot: Robot, signals: Signals, motion: Motion, design: Butterworth
) -> Iterator[Block]:
    """Yield regressors and the controller's torques [Nm], a block each two seconds.

    The torques are those of the bare arm: a payload that the controller was given is taken off.
    Nothing where `target_moment` was not recorded.
    """
    if signals.target_moment is None:
        return
    states, exact = torque_states(signals, motion)
    bare = LinkModel(robot, robot.chosen_model)
    loaded = LinkModel(robot.carrying(configured_payload(signals)), robot.chosen_model)
    load = loaded.inverse_dynamics(*states) - bare.inverse_dynamics(*states)
    regressor = bare.regressor(*states)
    joints, parameters = regressor.shape[1:]
    rows = np.hstack([regressor.reshape(len(regressor), -1), signals.target_moment - load])
    rows = comparable(rows, signals, exact, design)
    every = max(1, round(ROW_STEP / signals.period))
    for part in unbroken(signals.segment, (signals.time // BLOCK_DURATION).astype(np.int64)):
        chosen = rows[part][::every]
        yield chosen[:, :-joints].reshape(-1, joints, parameters), chosen[:, -joints:]
