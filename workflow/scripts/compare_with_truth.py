"""Estimates from simulated recordings beside the truth: the only step that is given it."""

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.kinematics import acceleration
from ur5lib.dynamics.rigid_body import inverse_dynamics
from ur5lib.report import truth_table
from ur5lib.report.truth_table import COLUMNS, JOINTS, Row
from ur5lib.robots.description import Payload, Robot, load_robot
from ur5lib.steps import run_step
from ur5lib.tables import channel, period, read_json, read_table, write_csv
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.lowpass import inner_lowpass
from ur5lib.timeseries.segments import by_segment

Truths = Mapping[str, Any]
EACH_RECORDING = ("clocks", "motion", "accelerations", "forces", "truth", "truth_summary")
EACH_ARM = ("described", "fitted", "rotors", "identification", "calibration", "friction")


def compare_with_truth(input: Any, output: Any, params: Any) -> None:
    truths = dict(zip(params.recordings, map(read_json, input.truth_summary), strict=True))
    arms = {robot: paths(input, EACH_ARM, k) for k, robot in enumerate(params.robots)}
    rows = [
        {"robot": robot} | row
        for robot, files in arms.items()
        for row in arm_rows(files, {n: t for n, t in truths.items() if t["robot"] == robot})
    ]
    for k, (name, truth) in enumerate(truths.items()):
        known = {"recording": name, "robot": truth["robot"]}
        files = paths(input, EACH_RECORDING, k) | arms[truth["robot"]]
        rows += [known | row for row in recording_rows(files, truth, params)]
    write_csv(pd.DataFrame(rows, columns=COLUMNS), output.truth)


def paths(input: Any, names: tuple[str, ...], index: int) -> dict[str, str]:
    """The files of one recording or one arm, as far as the rule has them."""
    return {name: input.get(name)[index] for name in names if input.get(name)}


def arm_rows(files: Mapping[str, str], truths: Truths) -> Iterator[Row]:
    """Of what was fitted to several recordings, where one truth stands behind them all."""
    rotors, identification = read_json(files["rotors"]), read_json(files["identification"])
    calibration = read_json(files["calibration"]).get("all", {"from": []})
    friction = read_json(files["friction"]) if "friction" in files else {"from": []}
    robot = load_robot(files["described"])
    comparisons: list[tuple[Mapping[str, Any], Callable[[Any], Any], Callable[..., Any]]] = [
        (rotors, partial(true_rotors, robot), truth_table.rotor_rows),
        (identification, partial(true_parameters, robot), truth_table.parameter_rows),
        (calibration, lambda truth: truth["plan"]["imu"], truth_table.imu_rows),
        (friction, true_friction, truth_table.friction_rows),
    ]
    for found, part, rows in comparisons:
        truth = shared(truths, found["from"], part)
        if truth is not None:
            yield from rows(found, truth)


def shared(truths: Truths, recordings: list[str], part: Callable[[Any], Any]) -> Any:
    """A part of the truth that recordings have in common, None where they have not."""
    if not recordings or not set(recordings) <= set(truths):
        return None
    parts = [part(truths[name]) for name in recordings]
    return parts[0] if all(np.array_equal(one, parts[0]) for one in parts) else None


def true_friction(truth: Mapping[str, Any]) -> dict[str, Any]:
    """Torque constants and friction that were simulated."""
    constant = truth["drive"]["torque_constant"]
    return {"drive": {"torque_constant": constant}, "friction": truth["friction"]}


def true_robot(robot: Robot, truth: Mapping[str, Any]) -> Robot:
    """The arm as it was simulated: under its gravity, with what it carried."""
    for name in ("payload", "undeclared_payload"):
        payload = truth["plan"][name]
        robot = robot.carrying(payload and Payload.model_validate(payload))
    return robot.mounted(truth["gravity"])


def true_rotors(robot: Robot, truth: Mapping[str, Any]) -> Any:
    return robot.models[truth["model"]].rotor_inertias


def true_parameters(robot: Robot, truth: Mapping[str, Any]) -> Array:
    """π (66,) of the simulated model, without a payload: the controller's is known."""
    return build_arm(robot, truth["model"]).parameters.numpy()


def recording_rows(files: Mapping[str, str], truth: Mapping[str, Any], params: Any) -> list[Row]:
    motion, accelerations, forces = (
        read_table(files[name]) for name in ("motion", "accelerations", "forces")
    )
    true = at_times(read_table(files["truth"]), motion["time"].to_numpy())
    felt = true_acceleration(load_robot(files["described"]), true, motion, params)
    return [
        *truth_table.clock_rows(read_json(files["clocks"]), truth),
        *truth_table.joint_acceleration_rows(motion, true),
        *truth_table.end_effector_rows(accelerations, felt),
        *torque_rows(load_robot(files["fitted"]), truth, true),
        *truth_table.wrench_rows(forces, true),
    ]


def at_times(truth: pd.DataFrame, time: Array) -> pd.DataFrame:
    """The truth at times (N,) [s], NaN where there was none."""
    own = truth["time"].to_numpy()
    columns = {
        name: np.interp(time, own, column, left=np.nan, right=np.nan)
        for name, column in truth.items()
    }
    return pd.DataFrame(columns | {"time": time})


def true_acceleration(robot: Robot, true: pd.DataFrame, motion: pd.DataFrame, params: Any) -> Array:
    """Of the end effector at the IMU's place (N, 6), low-passed as its estimates are."""
    q, qd, qdd = states(true)
    point = torch.tensor(robot.mounting.imu, dtype=torch.float64)
    arm = build_arm(robot, robot.chosen_model)
    lowpass = partial(
        inner_lowpass, rate=1 / period(motion), order=params.order, cutoff=params.cutoff_hz
    )
    exact = acceleration(arm, q, qd, qdd, point=point).numpy()
    return by_segment(lowpass, exact, motion["segment"].to_numpy())


def torque_rows(robot: Robot, truth: Mapping[str, Any], true: pd.DataFrame) -> Iterator[Row]:
    """RMSE of models' torques at the true motion, against what the simulated arm took."""
    motor, friction, contact = (channel(true, f"tau_{p}") for p in ("motor", "friction", "contact"))
    carrying = true_robot(robot, truth)
    for model in (name for name in (robot.chosen_model, "identified") if name in robot.models):
        torque = inverse_dynamics(build_arm(carrying, model), *states(true)).numpy()
        rigid = motor - friction + contact
        for row in truth_table.errors("torque", JOINTS, ["Nm"] * 6, rigid, torque):
            yield row | {"method": f"Model {model}"}


def states(true: pd.DataFrame) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    q, qd, qdd = (torch.from_numpy(channel(true, name)) for name in ("q", "qd", "qdd"))
    return q, qd, qdd


if __name__ == "__main__":
    run_step(compare_with_truth, snakemake)  # type: ignore[name-defined]  # noqa: F821
