"""Rotor inertia of each joint, from what rigid links leave of the controller's torque."""

from typing import Any

import numpy as np
import pandas as pd
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.identification import rotor_inertia
from ur5lib.pipeline.carried import told_payload
from ur5lib.pipeline.torque_record import comparable, torque_states
from ur5lib.robots.description import Robot, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import channel, read_table, write_json
from ur5lib.timeseries.arrays import Array


def fit_rotor_inertia(input: Any, output: Any, params: Any) -> None:
    robot = load_robot(input.arm)
    recordings = zip(params.recordings, params.gravities, input.signals, input.motion, strict=True)
    samples = {
        name: rotor_samples(robot.mounted(gravity), read_table(signals), read_table(motion), params)
        for name, gravity, signals, motion in recordings
    }
    known = {name: sample for name, sample in samples.items() if sample is not None}
    summary: dict[str, Any] = {"from": list(known)}
    if known:
        fit = rotor_inertia.fit_rotor_inertia(*zip(*known.values(), strict=True))
        summary |= {"value": fit.value._asdict(), "std_error": fit.std_error._asdict()}
    write_json(summary, output.rotors)


def rotor_samples(
    robot: Robot, signals: pd.DataFrame, motion: pd.DataFrame, params: Any
) -> tuple[Array, Array, Array] | None:
    """The torque that rigid links leave, q̇ and q̈, (N, 6) each, NaN where interpolated.

    The links carry the payload that the controller was told of: `target_moment` contains it.
    """
    if "target_moment_0" not in signals:
        return None
    states, exact = torque_states(signals, motion)
    arm = build_arm(robot.carrying(told_payload(signals)), robot.chosen_model)
    rigid = inverse_dynamics(arm, *map(torch.from_numpy, states))
    samples = np.hstack([channel(signals, "target_moment") - rigid.numpy(), *states[1:]])
    samples = comparable(samples, signals, exact, params.order, params.cutoff_hz)
    residual, qd, qdd = np.hsplit(samples, 3)
    return residual, qd, qdd


if __name__ == "__main__":
    run_step(fit_rotor_inertia, snakemake)  # type: ignore[name-defined]  # noqa: F821
