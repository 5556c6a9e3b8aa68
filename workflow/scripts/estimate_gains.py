"""The joints in closed loop, with published gains and with those that the recording tells."""

from collections.abc import Mapping
from dataclasses import asdict
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

from ur5lib.identification import closed_loop
from ur5lib.identification.closed_loop import Tracking
from ur5lib.robots.description import Robot, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import channel, named, period, read_table, write_json, write_table
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.segments import by_segment

TOLD = ["target_q", "target_qd", "target_qdd"]
DONE = ["actual_q", "actual_qd"]

Gains = tuple[Array, Array]


def estimate_gains(input: Any, output: Any, params: Any) -> None:
    signals, robot = read_table(input.signals), load_robot(input.arm)
    columns: dict[str, Array] = {}
    summary: dict[str, Any] = {}
    if all(f"{name}_0" in signals for name in TOLD + DONE):
        recorded = {name: channel(signals, name) for name in TOLD + DONE}
        segment = signals["segment"].to_numpy()
        tracking = Tracking(**recorded, segment=segment, period=period(signals))
        joints = closed_loop.estimate_gains(tracking)
        noise = np.stack([joint.noise for joint in joints])
        sets = published(robot)
        costs = {name: closed_loop.tracking_cost(tracking, *sets[name], noise) for name in sets}
        summary = {"joints": list(map(asdict, joints)), "published": costs}
        columns = simulated(tracking, sets | {"estimated": best(joints)})
    write_table(signals[["time", "segment"]].join(pd.DataFrame(columns)), output.closed_loop)
    write_json(summary, output.gains)


def published(robot: Robot) -> dict[str, Gains]:
    """Gains K0 [1/s²] and K1 [1/s] by the model they were published for, (6,) each."""
    return {
        name: (np.array(gains.position), np.array(gains.velocity))
        for name, gains in robot.closed_loop_gains.items()
    }


def best(joints: list[closed_loop.JointGains]) -> Gains:
    """The gains of least cost: a point in their ranges, good for a simulation."""
    position = np.array([joint.position.best for joint in joints])
    return position, np.array([joint.velocity.best for joint in joints])


def simulated(tracking: Tracking, sets: Mapping[str, Gains]) -> dict[str, Array]:
    """Columns of q̂, q̂̇ and q̂̈ under each set of gains."""
    targets = np.hstack([tracking.target_q, tracking.target_qd, tracking.target_qdd])

    def simulate(told: Array, gains: Gains) -> Array:
        q, qd, qdd = np.hsplit(told, 3)
        return np.hstack(closed_loop.simulate_closed_loop(q, qd, qdd, tracking.period, *gains))

    columns: dict[str, Array] = {}
    for name, gains in sets.items():
        states = by_segment(partial(simulate, gains=gains), targets, tracking.segment)
        for state, values in zip(("q", "qd", "qdd"), np.hsplit(states, 3), strict=True):
            columns |= named(values, f"{state}_{name}")
    return columns


if __name__ == "__main__":
    run_step(estimate_gains, snakemake)  # type: ignore[name-defined]  # noqa: F821
