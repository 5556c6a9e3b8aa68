"""The rigid-body model behind the controller's torque, as one more model of the arm."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd
import torch

from ur5lib.dynamics.arm import Arm, build_arm
from ur5lib.dynamics.regressor import regressor
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.identification.base_parameters import (
    BaseParameters,
    Estimate,
    Stack,
    base_parameters,
    identify,
    prior_width,
    stack,
    torque_error,
)
from ur5lib.identification.consistency import consistent, smallest_eigenvalues
from ur5lib.identification.excitation import Motion, candidate_motions, check_excitation
from ur5lib.identification.identified_model import identified_model, robot_yaml
from ur5lib.pipeline.carried import told_payload
from ur5lib.pipeline.torque_record import comparable, torque_states
from ur5lib.robots.description import Robot, load_robot
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.urdf import urdf
from ur5lib.steps import run_step
from ur5lib.tables import channel, period, read_json, read_table, write_json, write_text
from ur5lib.timeseries.arrays import Array

BLOCK, STEP = 2.0, 0.032  # s: errors of one block are correlated; of a block, a sample each step
RESOLUTION = 1e-3  # Nm: what the excitation check takes a torque to be good to
SPEED, ACCELERATION = 1.5, 3.0  # rad/s, rad/s²: of the motions that it may suggest


def identify_model(input: Any, output: Any, params: Any) -> None:
    robot = with_rotors(load_robot(input.arm), read_json(input.rotors))
    recordings = zip(params.recordings, params.gravities, input.signals, input.motion, strict=True)
    blocks = {
        name: list(
            torque_blocks(robot.mounted(gravity), read_table(signals), read_table(motion), params)
        )
        for name, gravity, signals, motion in recordings
    }
    known = [block for part in blocks.values() for block in part]
    summary: dict[str, Any] = {"from": [name for name, part in blocks.items() if part]}
    try:
        robot, found = with_identified(robot, params.gravities, known)
        summary |= found
    except ValueError as error:  # too little was recorded, or nothing physical explains it
        summary["refused"] = str(error)
    name = "identified" if "identified" in robot.models else robot.chosen_model
    write_text(robot_yaml(robot), output.arm)
    write_text(urdf(robot, rigid_bodies(robot, name)), output.urdf)
    write_json(summary, output.summary)


def with_rotors(robot: Robot, rotors: Any) -> Robot:
    """The arm with the fitted rotor inertias in its chosen model, as "<model>+rotors"."""
    if not rotors["from"]:
        return robot
    name = f"{robot.chosen_model}+rotors"
    described = robot.models.get(name, robot.models[robot.chosen_model])
    # A joint that kept still, or whose torque is no rotor's, keeps the inertia that was described.
    fitted = [
        inertia if value is None or value < 0 else value
        for value, inertia in zip(rotors["value"]["inertia"], described.rotor_inertias, strict=True)
    ]
    return robot.with_model(name, described.model_copy(update={"rotor_inertias": tuple(fitted)}))


def with_identified(
    robot: Robot, gravities: list[list[float] | None], blocks: list[tuple[Array, Array]]
) -> tuple[Robot, dict[str, Any]]:
    """The arm with the model "identified" from some blocks, and the account of how.

    gravities: of the recordings, which decide what their torques can tell.
    Raises ValueError where there are too few blocks, or none that bodies could explain.
    """
    data = stack(blocks)
    arms = [build_arm(robot.mounted(gravity), robot.chosen_model) for gravity in unique(gravities)]
    estimate = identify(data, arms[0].parameters.numpy(), prior_width())
    parameters = consistent(estimate)
    description = "identified from the controller's torques, physically consistent"
    model = identified_model(robot, parameters, description)
    found = account(arms, data, estimate, parameters, blocks)
    return robot.with_model("identified", model), found


def unique(gravities: list[list[float] | None]) -> list[list[float] | None]:
    """Each gravity once."""
    return [gravity for k, gravity in enumerate(gravities) if gravity not in gravities[:k]]


def torque_blocks(
    robot: Robot, signals: pd.DataFrame, motion: pd.DataFrame, params: Any
) -> Iterator[tuple[Array, Array]]:
    """Regressors (n, 6, 66) and the controller's torques (n, 6), a block for each two seconds.

    The torques are those of the bare arm: a payload that the controller was told of is taken off.
    """
    if "target_moment_0" not in signals:
        return
    states, exact = torque_states(signals, motion)
    bare, loaded = (
        build_arm(arm, robot.chosen_model) for arm in (robot, robot.carrying(told_payload(signals)))
    )
    tensors = [torch.from_numpy(state) for state in states]
    load = inverse_dynamics(loaded, *tensors) - inverse_dynamics(bare, *tensors)
    columns = regressor(bare, *tensors).numpy().reshape(len(signals), -1)
    rows = np.hstack([columns, channel(signals, "target_moment") - load.numpy()])
    rows = comparable(rows, signals, exact, params.order, params.cutoff_hz)
    block = signals["time"] // BLOCK
    for _, part in signals.groupby(["segment", block], sort=False).indices.items():
        chosen = rows[part[:: max(1, round(STEP / period(signals)))]]
        yield chosen[:, :-6].reshape(-1, 6, 66), chosen[:, -6:]


def account(
    arms: list[Arm],
    data: Stack,
    estimate: Estimate,
    parameters: Array,
    blocks: list[tuple[Array, Array]],
) -> dict[str, Any]:
    """What was found: base parameters, what consistency costs, and what no recording tells."""
    motions = candidate_motions(SPEED, ACCELERATION)
    candidates = {
        name: np.concatenate([columns_of(arm, motion) for arm in arms])
        for name, motion in motions.items()
    }
    base = base_parameters(candidates[list(motions)[-1]])
    excitation = check_excitation(data, base, estimate.width, np.full(6, RESOLUTION), candidates)
    return {
        "noise": estimate.noise,
        "parameters": parameter_rows(base, estimate, parameters),
        "mae": {
            "without constraint": torque_error(blocks, estimate.parameters),
            "consistent": torque_error(blocks, parameters),
        },
        "smallest_eigenvalues": {
            "without constraint": smallest_eigenvalues(estimate.parameters),
            "consistent": smallest_eigenvalues(parameters),
        },
        "excitation": asdict(excitation),
    }


def columns_of(arm: Arm, motion: Motion) -> Array:
    """The regressor (N, 6, 66) of a motion."""
    q, qd, qdd = map(torch.from_numpy, motion)
    return regressor(arm, q, qd, qdd).numpy()


def parameter_rows(
    base: BaseParameters, estimate: Estimate, parameters: Array
) -> list[dict[str, Any]]:
    """Each base parameter: the sum that it is, its value, standard error, whether data tell it.

    weights: (66,) of the arm's parameters π in that sum.
    """
    return [
        {"parameter": name, "value": value, "std_error": std, "determined": bool(told)}
        | {"weights": weights}
        for name, weights, value, std, told in zip(
            base.names(),
            base.groups,
            base.groups @ parameters,
            estimate.standard_errors(base.groups),
            estimate.determined(base.groups),
            strict=True,
        )
    ]


if __name__ == "__main__":
    run_step(identify_model, snakemake)  # type: ignore[name-defined]  # noqa: F821
