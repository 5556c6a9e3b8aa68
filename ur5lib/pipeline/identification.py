"""The arm with its identified models: fitted rotors, and the controller's rigid bodies."""

from collections.abc import Sequence

import numpy as np

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.identification.base_parameters import (
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
from ur5lib.identification.excitation import candidate_motions, check_excitation
from ur5lib.pipeline.records.models import BaseParameter, Identification, Rotors
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.timeseries.arrays import Array

RESOLUTION = 1e-3  # Nm: noise of a torque in the excitation check
SPEED, ACCELERATION = 1.5, 3.0  # rad/s, rad/s²: of the motions that it may suggest
DESCRIPTION = "identified from the controller's torques, physically consistent"

Block = tuple[Array, Array]  # regressors (N, n, P) and torques (N, n) [Nm]


def with_rotors(robot: Robot, rotors: Rotors) -> Robot:
    """Return the arm with the fitted rotor inertias in its chosen model, as "<model>+rotors"."""
    if rotors.value is None:
        return robot
    name = f"{robot.chosen_model}+rotors"
    described = name if name in robot.models else robot.chosen_model
    # A joint that kept still, or whose torque is no rotor's, keeps the inertia that was described.
    fitted = [
        value if value >= 0 else inertia
        for value, inertia in zip(
            rotors.value.inertia.tolist(),
            rigid_bodies(robot, described).rotor_inertia.tolist(),
            strict=True,
        )
    ]
    model = robot.models[described].model_copy(update={"rotor_inertias": tuple(fitted)})
    return robot.with_model(name, model)


def with_identified(
    robot: Robot, gravities: Sequence[list[float] | None], blocks: list[Block]
) -> tuple[Robot, Identification]:
    """Return the arm with the model "identified" from some blocks, and how it was found.

    gravities: of the recordings, which decide what their torques determine.
    Raises RefusalError where there are too few blocks, or none that bodies could explain.
    """
    data = stack(blocks)
    unique = [gravity for k, gravity in enumerate(gravities) if gravity not in gravities[:k]]
    models = [LinkModel(robot.mounted(gravity), robot.chosen_model) for gravity in unique]
    estimate = identify(data, models[0].parameters, prior_width(len(models[0].parameters)))
    parameters = consistent_parameters(estimate)
    model = identified_model(robot, parameters, DESCRIPTION)
    found = identification(models, data, estimate, parameters, blocks)
    return robot.with_model("identified", model), found


def identification(
    models: Sequence[LinkModel],
    data: Stack,
    estimate: InertialEstimate,
    parameters: Array,
    blocks: list[Block],
) -> Identification:
    """Return base parameters, errors with and without consistency, and undetermined parameters."""
    motions = candidate_motions(len(estimate.noise), SPEED, ACCELERATION)
    candidates = {
        name: np.concatenate([model.regressor(*motion) for model in models])
        for name, motion in motions.items()
    }
    base = base_parameters(candidates[list(motions)[-1]])
    excitation = check_excitation(
        data, base, estimate.width, np.full_like(estimate.noise, RESOLUTION), candidates
    )
    values = base.groups @ parameters, estimate.standard_errors(base.groups)
    known = map(bool, estimate.determined(base.groups))
    return Identification(
        noise=estimate.noise,
        parameters=[*map(BaseParameter, base.names(), *values, known, base.groups)],
        mae={
            "without constraint": torque_error(blocks, estimate.parameters),
            "consistent": torque_error(blocks, parameters),
        },
        smallest_eigenvalues={
            "without constraint": smallest_eigenvalues(estimate.parameters),
            "consistent": smallest_eigenvalues(parameters),
        },
        excitation=excitation,
    )
