"""Joint torques of every link model: at the targets, at the measured motion, in closed loop."""

from typing import Any

import numpy as np
import pandas as pd
import torch

from ur5lib.dynamics.arm import Arm, build_arm
from ur5lib.dynamics.rigid_body import (
    coriolis_matrix,
    gravity_torque,
    inertia_matrix,
    inverse_dynamics,
)
from ur5lib.pipeline.carried import Carried, carried
from ur5lib.robots.description import Payload, Robot, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import channel, named, read_table, write_json, write_table
from ur5lib.timeseries.arrays import Array


def compute_torques(input: Any, output: Any, params: Any) -> None:
    robot, signals = load_robot(input.arm).mounted(params.gravity), read_table(input.signals)
    motion, closed_loop = read_table(input.motion), read_table(input.closed_loop)
    declared = Payload.model_validate_json(params.payload) if params.payload else None
    load = carried(declared, signals)
    columns = model_torques(robot.carrying(load.told), signals, motion, closed_loop)
    columns |= named(payload_torque(robot, load, motion), "payload_torque")
    columns |= momentum(build_arm(robot.carrying(load.payload), robot.fullest_model()), motion)
    times = signals[["time", "segment", "interpolated"]]
    write_table(times.join(pd.DataFrame(columns)), output.torques)
    write_json(account(load), output.summary)


def model_torques(
    robot: Robot, signals: pd.DataFrame, motion: pd.DataFrame, closed_loop: pd.DataFrame
) -> dict[str, Array]:
    """Torques of every model with what the controller was told of, as `target_moment` has them."""
    sources = {
        "target": (signals, "target_q target_qd target_qdd"),
        "measured": (motion, "q qd qdd"),
        # in closed loop, a model has the gains that were published for it
        "closed_loop": (closed_loop, "q_{model} qd_{model} qdd_{model}"),
    }
    columns: dict[str, Array] = {}
    for model in robot.models:
        arm = build_arm(robot, model)
        for source, (table, names) in sources.items():
            states = names.format(model=model).split()
            if all(f"{state}_0" in table for state in states):
                columns |= named(torques(arm, table, states), f"tau_{source}_{model}")
    return columns


def payload_torque(robot: Robot, load: Carried, motion: pd.DataFrame) -> Array:
    """What the payload adds at the measured motion, (N, 6) [Nm], beyond what was told of it."""
    if load.payload == load.told:
        return np.zeros((len(motion), 6))
    arms = (
        build_arm(robot.carrying(payload), robot.fullest_model())
        for payload in (load.payload, load.told)
    )
    true, told = (torques(arm, motion, ["q", "qd", "qdd"]) for arm in arms)
    return true - told


def torques(arm: Arm, table: pd.DataFrame, states: list[str]) -> Array:
    """Inverse dynamics (N, 6) [Nm] at a table's position, velocity and acceleration."""
    return inverse_dynamics(arm, *(tensor(table, state) for state in states)).numpy()


def account(load: Carried) -> dict[str, Any]:
    """The payload, who says so (study, rtde, none), and what the controller was told of."""
    payloads = {"payload": load.payload, "told": load.told}
    plain = {name: payload and payload.model_dump() for name, payload in payloads.items()}
    return plain | {"source": load.source}


def momentum(arm: Arm, motion: pd.DataFrame) -> dict[str, Array]:
    """Generalised momentum D q̇, and C^T q̇ and g, which change it: of the measured motion."""
    q, qd = tensor(motion, "q"), tensor(motion, "qd")
    terms = {
        "momentum": inertia_matrix(arm, q) @ qd[..., None],
        "coriolis_torque": coriolis_matrix(arm, q, qd).mT @ qd[..., None],
        "gravity_torque": gravity_torque(arm, q)[..., None],
    }
    columns: dict[str, Array] = {}
    for name, values in terms.items():
        columns |= named(values[..., 0].numpy(), name)
    return columns


def tensor(table: pd.DataFrame, name: str) -> torch.Tensor:
    """A channel (N, 6)."""
    return torch.from_numpy(channel(table, name))


if __name__ == "__main__":
    run_step(compute_torques, snakemake)  # type: ignore[name-defined]  # noqa: F821
