"""Currents without a sign are told, and currents of one sign that hold an arm are right."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.command import Command
from tests.conftest import said
from tests.synthetic import PERIOD, poor_log
from ur5lib.channels import columns
from ur5lib.checks.checked import Checked
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.records.codes import Found
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import channel

CURRENTS = columns("actual_current")


def reported(log: pd.DataFrame, arm: str) -> list[str]:
    table = log.assign(segment=0, interpolated=False)
    checked = Checked(table, load_robot(robot_path(arm)), None, None, True, cutoff=2.0)
    return [said(sign) for sign in stop_signs(checked)]


@pytest.mark.parametrize("arm", ["ur3", "ur5", "ur16e"])
@pytest.mark.parametrize("sign", [1, -1])
def test_currents_without_a_sign_are_told(arm: str, sign: int) -> None:
    log = poor_log(load_robot(robot_path(arm)), 30, seed=1)
    assert reported(log, arm) == []
    log[CURRENTS] = sign * log[CURRENTS].abs()
    (sentence,) = reported(log, arm)
    assert "without a sign" in sentence


def test_joints_that_hold_the_arm_have_currents_of_one_sign() -> None:
    """Joints 2 and 3 alone turn, to and fro against friction, of an arm that is stretched."""
    arm = load_robot(robot_path("ur5"))
    log = poor_log(arm, 30, seed=1, speed=0.15)
    log[[f"actual_qd_{k}" for k in (0, 3, 4, 5)]] = 0.0
    log[[f"actual_q_{k}" for k in (0, 3, 4, 5)]] = 0.0
    holds = gravity_torque(arm, arm.chosen_model, channel(log, "actual_q"))
    torque = holds + 4 * np.tanh(channel(log, "actual_qd") / 0.01)
    log[CURRENTS] = torque / arm.maker_torque_constants()
    assert (np.ptp(np.sign(log[["actual_current_1", "actual_current_2"]]), axis=0) == 0).all()
    assert reported(log, "ur5") == []


def test_sizes_prove_no_opposite_sign(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command
) -> None:
    monkeypatch.chdir(tmp_path)
    log = poor_log(load_robot(robot_path("ur5")), 30, seed=2)
    log[CURRENTS] = np.abs(log[CURRENTS])
    log[:: round(0.04 / PERIOD)].to_csv("run.csv", index=False)
    run_ur5("import", "run.csv", "--robot", "ur5", "--output", "mine.yaml")
    assert "opposite" not in Path("mine.yaml").read_text()
    assert "without its sign" in Path("mine.yaml").read_text()
    assert Found.COLUMNS_NOT_USED.words in run_ur5("check", "mine.yaml", "run").line
