"""Link models by torques: rotors and then rigid bodies by the controller's torques; of an arm with
unknown links, by the joints' measured torques.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import reason
from ur5lib.identification.base_parameters import (
    identified_model,
    identify,
    prior_width,
    stack,
)
from ur5lib.identification.consistency import consistent_parameters
from ur5lib.identification.controllers_torques import (
    Block,
    CommandedRun,
    rotor_samples,
    torque_blocks,
)
from ur5lib.identification.current_samples import ZeroPhaseLowpass, measured_samples
from ur5lib.identification.identified import identification, known_bodies
from ur5lib.identification.measured_torques import FittedArm, fit_arm
from ur5lib.identification.rotor_inertia import fitted_rotors, with_rotors
from ur5lib.identification.torque_rows import MeasuredRun
from ur5lib.records.carried import configured_payload
from ur5lib.records.models import Identification, Rotors
from ur5lib.records.motion import Motion
from ur5lib.records.signals import Signals
from ur5lib.records.step import step
from ur5lib.robots.description import Robot, robot_yaml
from ur5lib.robots.exports import urdf
from ur5lib.robots.inertia import written_bodies
from ur5lib.timeseries.lowpass import Butterworth

DESCRIPTION = "identified from the controller's torques, physically consistent"
MEASURED_DESCRIPTION = "identified from measured torques, physically consistent"


class IdentifiedModel(NamedTuple):
    """An arm with its fitted models, as YAML and URDF, and the results of the fits."""

    arm: str
    urdf: str
    rotors: Rotors
    summary: Identification


@step(
    "arm",
    "arm.yaml urdf=arm.urdf rotors=rotor_inertia.json summary=identification.json",
    recordings="fit",
    arm="described",
    lowpass="motion_lowpass",
    currents="lowpass",
)
def identify_model(
    arm: Robot,
    signals: Mapping[str, Signals],
    motion: Mapping[str, Motion],
    gravities: dict[str, list[float] | None],
    lowpass: Butterworth,
    currents: Butterworth,
) -> IdentifiedModel:
    """Return the arm with rotors and rigid bodies fitted to the controller's torques.

    For an arm with unknown links, they are fitted to its joints' measured torques. signals, motion,
    gravities: of the arm's `fit` recordings; lowpass: of the controller's torques; currents:
    low-pass of currents or measured torques.
    """
    if arm.links == "unknown":
        return with_unknown_links(arm, signals, motion, gravities, ZeroPhaseLowpass(*currents))

    def run(name: str) -> CommandedRun:
        return commanded(arm.mounted(gravities[name]), signals[name], motion[name])

    rotors = fitted_rotors({name: rotor_samples(run(name), lowpass) for name in signals})
    robot = with_rotors(arm, rotors)
    blocks = {name: [*torque_blocks(run(name), lowpass)] for name in signals}
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
    smooth: ZeroPhaseLowpass,
) -> IdentifiedModel:
    """Return the arm with links, rotors and counterbalances fitted to its joints' torques.

    If the torques determine no links, these remain unknown.
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
    """Yield the recording as a run with measured torques, less the torque of the payload set in the
    controller; nothing without torques or currents.

    robot: under the recording's gravity; currents become torques by its torque constants.
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
    """Return the arm with fitted links in place of placeholders, and with the joints on which a
    spring or a counterbalance was found.
    """
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


def commanded(robot: Robot, signals: Signals, motion: Motion) -> CommandedRun:
    """Return a recording as a run with the controller's torques, and with functions for those of
    the arm's rigid links; robot: under the recording's gravity.
    """
    bare = LinkModel(robot, robot.chosen_model)
    loaded = LinkModel(robot.carrying(configured_payload(signals)), robot.chosen_model)
    known = bare.inverse_dynamics, loaded.inverse_dynamics, bare.regressor
    return CommandedRun(signals, motion, *known)


def with_identified(
    robot: Robot, gravities: Sequence[list[float] | None], blocks: list[Block]
) -> tuple[Robot, Identification]:
    """Return the arm with the model "identified" fitted to some blocks, and the identification.

    gravities: of the recordings, which decide what their torques determine. Raises RefusalError
    where there are too few blocks, or no bodies explain them.
    """
    data = stack(blocks)
    models = models_under(robot, gravities)
    estimate = identify(data, models[0].parameters, prior_width(len(models[0].parameters)))
    parameters = consistent_parameters(estimate)
    model = identified_model(robot, parameters, DESCRIPTION)
    found = identification(models, data, estimate, parameters, blocks)
    return robot.with_model("identified", model), found


def models_under(robot: Robot, gravities: Sequence[list[float] | None]) -> list[LinkModel]:
    """Return the chosen link model of an arm under each distinct gravity."""
    unique = [gravity for k, gravity in enumerate(gravities) if gravity not in gravities[:k]]
    return [LinkModel(robot.mounted(gravity), robot.chosen_model) for gravity in unique]
