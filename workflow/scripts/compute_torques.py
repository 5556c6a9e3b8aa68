"""Joint torques of every link model: at the targets, at the measured motion, in closed loop."""

from typing import Any

import pandas as pd
import torch

from ur5lib.dynamics.arm import Arm, build_arm
from ur5lib.dynamics.rigid_body import (
    coriolis_matrix,
    gravity_torque,
    inertia_matrix,
    inverse_dynamics,
)
from ur5lib.robots.description import load_robot
from ur5lib.steps import run_step
from ur5lib.tables import Array, channel, named, read_table, write_table


def compute_torques(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    signals = read_table(input.signals)
    sources = {
        "target": (signals, "target_q target_qd target_qdd"),
        "measured": (read_table(input.motion), "q qd qdd"),
        # in closed loop, a model has the gains that were published for it
        "closed_loop": (read_table(input.closed_loop), "q_{model} qd_{model} qdd_{model}"),
    }
    columns: dict[str, Array] = {}
    for model in robot.models:
        arm = build_arm(robot, model)
        for motion, (table, names) in sources.items():
            states = names.format(model=model).split()
            if all(f"{state}_0" in table for state in states):
                torque = inverse_dynamics(arm, *(tensor(table, state) for state in states))
                columns |= named(torque.numpy(), f"tau_{motion}_{model}")
    motion = read_table(input.motion)
    columns |= momentum(build_arm(robot, robot.fullest_model()), motion)
    times = signals[["time", "segment", "interpolated"]]
    write_table(times.join(pd.DataFrame(columns)), output.torques)


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
