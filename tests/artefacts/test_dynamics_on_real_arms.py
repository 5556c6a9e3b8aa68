"""The models of the real arms, against what their controllers computed."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.rigid_body import gravity_torque, inverse_dynamics
from ur5lib.recordings.intake import read_and_repair
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.study.model import Recording, TableRecording, ThesisRecording
from ur5lib.tables import channel

TABLE_5_6 = "Movement_No5_Acc_slow_no_disturbance"
COLUMNS = ["time", "actual_q", "actual_qd", "actual_current", "target_current", "target_moment"]


@pytest.fixture(scope="module")
def ur10e() -> Robot:
    return load_robot(robot_path("ur10e"))


def received(recording: Recording, arm: Robot) -> pd.DataFrame:
    """The frames of a recording that the robot sent."""
    table = read_and_repair(recording.model_dump(), arm, max_gap=0.1).robot
    return table[~table["interpolated"].astype(bool)]


def tensor(table: pd.DataFrame, name: str) -> torch.Tensor:
    return torch.from_numpy(channel(table, name))


def test_rotors_explain_what_model_c_leaves(ur5: Robot, thesis_data: Path) -> None:
    """Mean absolute error at the target motion below 0.05 Nm; without rotors up to 1.2 Nm."""
    folder = str(thesis_data / TABLE_5_6)
    recording = ThesisRecording(
        name=TABLE_5_6, robot="ur5", format="thesis-csv", folder=folder, role="fit"
    )
    table = received(recording, ur5)
    motion = [tensor(table, f"target_{name}") for name in ("q", "qd", "qdd")]
    torque = inverse_dynamics(build_arm(ur5, "C+rotors"), *motion)
    error = (tensor(table, "target_moment") - torque).abs().nanmean(0)
    assert len(table) > 3000
    assert (error < 0.05).all(), error


@pytest.mark.parametrize("number", range(1, 6))
def test_gravity_of_the_ur10e_at_rest(ur10e: Robot, ur10e_data: Path, number: int) -> None:
    recording = TableRecording(
        name=f"p{number}",
        robot="ur10e",
        format="table-csv",
        folder=str(ur10e_data),
        file=f"ur-20_01_17-p{number}.csv",
        columns=COLUMNS,
        role="fit",
    )
    table = received(recording, ur10e)
    at_rest = np.abs(channel(table, "actual_qd")).max(1) < 1e-3
    table = table[at_rest]
    torque = gravity_torque(build_arm(ur10e, "maker"), tensor(table, "actual_q"))
    assert at_rest.sum() > 100
    assert (tensor(table, "target_moment") - torque).abs().max() < 0.13
