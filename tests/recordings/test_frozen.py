"""A channel that repeats one value while the arm moves is no data; rounded and resting ones are."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.conftest import said
from tests.entries import read_and_check
from tests.synthetic import PERIOD, poor_log
from ur5lib.channels import columns
from ur5lib.recordings.frames import repair_frames
from ur5lib.records.codes import Found
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.tables import channel

SINCE, UNTIL = 10.0, 13.0  # s
FROZEN = slice(round(SINCE / PERIOD), round(UNTIL / PERIOD))


@pytest.fixture
def log() -> pd.DataFrame:
    """At rest in the last 5 of 30 s, in steps of encoders and converters."""
    made = poor_log(load_robot(robot_path("ur5")), 30, seed=1)
    made[columns("actual_q")] = channel(made, "actual_q").round(5)
    made[columns("actual_current")] = channel(made, "actual_current").round(3)
    return made


def repaired(log: pd.DataFrame) -> tuple[pd.DataFrame, list[str]]:
    """The table, and what is said of its frozen channels."""
    table, _, findings = repair_frames(log.copy(), 0.008, 0.1, "log.csv")
    return table, [said(one) for one in findings if one.code == Found.FROZEN_CHANNEL]


@pytest.mark.parametrize("column", ["actual_current_1", "actual_q_4"])
def test_the_rows_of_a_frozen_joint_are_a_gap(log: pd.DataFrame, column: str) -> None:
    log.loc[FROZEN, column] = log[column][FROZEN.start]
    table, (sentence,) = repaired(log)
    assert column in sentence
    assert "from 10 s on, for 3 s" in sentence
    assert not table["time"].between(SINCE + 0.1, UNTIL - 0.1).any()
    assert table["time"].max() > 29


def test_frozen_velocities_are_left_out(log: pd.DataFrame) -> None:
    log.loc[FROZEN.start :, "actual_qd_2"] = log["actual_qd_2"][FROZEN.start]
    table, (sentence,) = repaired(log)
    assert "actual_qd_2" in sentence
    assert "actual_qd_0" not in table
    assert len(table) == len(log)


def test_an_arm_without_power_that_is_led_by_hand_has_no_currents(log: pd.DataFrame) -> None:
    log.loc[FROZEN, columns("actual_current")] = 0.0
    assert repaired(log)[1] == []


@pytest.mark.parametrize("seconds", [SINCE, 0.5])
def test_a_force_that_is_zero_from_some_moment_on_ends_there(
    log: pd.DataFrame, tmp_path: Path, seconds: float
) -> None:
    force = np.random.default_rng(0).normal(3, 0.1, (len(log), 6)).round(3)
    force[-round(seconds / PERIOD) :] = 0.0
    log[columns("ft")] = force
    log.rename(columns={"time": "timestamp"}).to_csv(tmp_path / "run.csv", index=False)
    entry = {"name": "run", "robot": "ur5", "format": "rtde-csv", "folder": str(tmp_path)}
    intake = read_and_check(entry | {"file": "run.csv"}, load_robot(robot_path("ur5")), 0.1)
    codes = [one.code for one in intake.quality.findings]
    assert (Found.FROZEN_CHANNEL in codes) == (seconds > 1)
    if seconds > 1:
        assert intake.sensors["force"]["time"].max() == pytest.approx(30 - seconds, abs=0.1)
    assert len(intake.robot) == len(log)


@pytest.mark.parametrize("digits", [1, 2, 3])
def test_rounded_and_held_values_are_data(log: pd.DataFrame, digits: int) -> None:
    """Of a joint at a steady pace, too, and of a driver that rounds slow motion to rest."""
    steady = np.clip(log["time"] - 5, 0, 10)
    log["actual_q_5"] = (0.3 * steady).round(digits + 1)
    log["actual_qd_5"] = np.where((steady > 0) & (steady < 10), 0.3, 0.0)
    log["actual_qd_0"] = log["actual_qd_0"].where(log["actual_qd_0"].abs() > 0.1, 0.0)
    currents = columns("actual_current")
    log[currents] = channel(log, "actual_current").round(digits)
    log[currents] = np.repeat(channel(log, "actual_current")[::25], 25, axis=0)
    assert repaired(log)[1] == []
