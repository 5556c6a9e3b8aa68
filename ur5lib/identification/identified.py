"""Rigid bodies by torques: base parameters, errors, excitation."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from ur5lib.identification.base_parameters import (
    PARAMETERS_PER_JOINT,
    InertialEstimate,
    Stack,
    base_parameters,
    torque_error,
)
from ur5lib.identification.consistency import smallest_eigenvalues
from ur5lib.identification.controllers_torques import Block
from ur5lib.identification.excitation import candidate_motions, check_excitation
from ur5lib.records.models import BaseParameter, Identification
from ur5lib.timeseries.arrays import Array

TORQUE_RESOLUTION = 1e-3  # Nm: noise of a torque in the excitation check
SPEED, ACCELERATION = 1.5, 3.0  # rad/s, rad/s²; limits of suggested motions


class RigidLinks(Protocol):
    """An arm's links under one gravity, as `dynamics.link_model.LinkModel`."""

    @property
    def parameters(self) -> Array:
        """Return the inertial parameters π (P,) of τ = Y π."""

    def regressor(self, q: Array, qd: Array, qdd: Array) -> Array:
        """Return Y (N, n, P) of τ = Y π."""


def identification(
    models: Sequence[RigidLinks],
    data: Stack,
    estimate: InertialEstimate,
    parameters: Array,
    blocks: list[Block],
) -> Identification:
    """Return base parameters, torque errors without and with physical consistency, and what is
    undetermined.
    """
    values = {"without constraint": estimate.parameters, "consistent": parameters}
    mae = {name: torque_error(blocks, value) for name, value in values.items()}
    candidates = candidate_regressors(models)
    base = base_parameters([*candidates.values()][-1])
    excitation = check_excitation(
        data, base, estimate.width, np.full_like(estimate.noise, TORQUE_RESOLUTION), candidates
    )
    return replace(known_bodies(models, estimate, parameters, mae), excitation=excitation)


def candidate_regressors(models: Sequence[RigidLinks]) -> dict[str, Array]:
    """Return the regressors (N, n, P) of candidate motions by name, joined over all gravities."""
    joints = len(models[0].parameters) // PARAMETERS_PER_JOINT
    return {
        name: np.concatenate([model.regressor(*motion) for model in models])
        for name, motion in candidate_motions(joints, SPEED, ACCELERATION).items()
    }


def known_bodies(
    models: Sequence[RigidLinks],
    estimate: InertialEstimate,
    parameters: Array,
    mae: dict[str, Array],
) -> Identification:
    """Return base parameters, their errors, and the least eigenvalues of the unconstrained estimate
    and of the consistent parameters π (P,).
    """
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
