"""The mass on the flange beyond the arm's model and known payload, from motor currents alone."""

from dataclasses import asdict
from typing import Any

import numpy as np
import pandas as pd
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.regressor import regressor
from ur5lib.identification import payload
from ur5lib.identification.currents import fit_for
from ur5lib.identification.samples import smoothed_moving
from ur5lib.pipeline.current_record import current_record, smoother
from ur5lib.robots.description import Robot, load_robot
from ur5lib.robots.urdf import link_tail
from ur5lib.steps import run_step
from ur5lib.tables import channel, named, read_json, read_table, write_json, write_table
from ur5lib.timeseries.arrays import Array

LINK_6 = slice(50, 54)  # of π: mass and first moments; a payload is a part of link 6


def estimate_payload(input: Any, output: Any, params: Any) -> None:
    robot, friction = load_robot(input.arm).mounted(params.gravity), read_json(input.friction)
    signals, motion, torques = map(read_table, (input.signals, input.motion, input.torques))
    model = robot.fullest_model()
    record = current_record(params.recording, signals, motion, torques, model)
    summary: dict[str, Any] = {}
    columns: dict[str, Array] = {}
    if record is not None and friction["from"]:
        states = [torch.from_numpy(channel(motion, name)) for name in ("q", "qd", "qdd")]
        per_load = load_regressor(regressor(build_arm(robot, model), *states).numpy(), robot)
        columns = named(per_load.reshape(len(per_load), -1), "load_regressor")
        smooth = smoother(params.order, params.cutoff_hz)
        if smoothed_moving(record, smooth).any():  # at rest, friction hides a load
            fit = fit_for(params.recording, friction)
            summary = asdict(payload.estimate_payload(fit, record, per_load, smooth))
    write_table(motion[["time", "segment"]].join(pd.DataFrame(columns)), output.regressor)
    write_json(summary, output.payload)


def load_regressor(columns: Array, robot: Robot) -> Array:
    """Torque (N, 6, 4) per mass [kg] and first moments [kg m] of a load, as payloads: in frame 6.

    columns: Y of τ = Y π, (N, 6, 66), whose moments of link 6 are about its joint: h = m t + R h₆,
    with the constant transform R, t from there to frame 6.
    """
    rotation, tail = link_tail(robot.denavit_hartenberg[5])
    mass, moments = np.split(columns[:, :, LINK_6], [1], axis=2)
    return np.concatenate([mass + moments @ tail[:, None], moments @ rotation], axis=2)


if __name__ == "__main__":
    run_step(estimate_payload, snakemake)  # type: ignore[name-defined]  # noqa: F821
