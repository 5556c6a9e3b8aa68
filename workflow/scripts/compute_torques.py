"""Joint torques of every link model, at the target motion and at the measured one."""

from typing import Any

import pandas as pd
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.robots.description import load_robot
from ur5lib.steps import run_step
from ur5lib.tables import Array, channel, named, read_table, write_table

STATES = {
    "target": ("target_q", "target_qd", "target_qdd"),
    "measured": ("q", "qd", "qdd"),
}


def compute_torques(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    tables = {"target": read_table(input.signals), "measured": read_table(input.motion)}
    recorded = {
        motion: [torch.from_numpy(channel(tables[motion], name)) for name in names]
        for motion, names in STATES.items()
        if all(f"{name}_0" in tables[motion] for name in names)
    }
    columns: dict[str, Array] = {}
    for model in robot.models:
        arm = build_arm(robot, model)
        for motion, states in recorded.items():
            torque = inverse_dynamics(arm, *states).numpy()
            columns |= named(torque, f"tau_{motion}_{model}")
    times = tables["target"][["time", "segment", "interpolated"]]
    write_table(times.join(pd.DataFrame(columns)), output.torques)


if __name__ == "__main__":
    run_step(compute_torques, snakemake)  # type: ignore[name-defined]  # noqa: F821
