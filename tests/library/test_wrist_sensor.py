"""The arm's own force sensor, from the columns of RTDE."""

import numpy as np
import pandas as pd
import pytest

from tests.conftest import said
from ur5lib.recordings.intake import with_wrist_sensor
from ur5lib.recordings.quality import Finding
from ur5lib.recordings.sensors import FORCE_CHANNELS
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.robots.statics import link_frames
from ur5lib.tables import named
from ur5lib.timeseries.arrays import Array

ARM = load_robot(robot_path("ur5e"))
RANDOM = np.random.default_rng(1)
Q, WRENCH = RANDOM.uniform(-1, 1, (50, 6)), RANDOM.normal(size=(50, 6))


def table(**channels: Array) -> pd.DataFrame:
    columns: dict[str, Array] = {}
    for name, values in {"actual_q": Q, **channels}.items():
        columns |= named(values, name)
    return pd.DataFrame({"time": 0.002 * np.arange(50), **columns})


def test_the_raw_reading_is_taken_as_it_is() -> None:
    findings: list[Finding] = []
    robot = with_wrist_sensor(table(ft_raw_wrench=WRENCH), ARM, False, findings)
    np.testing.assert_array_equal(robot[FORCE_CHANNELS], WRENCH)
    assert [(one.device, one.severity) for one in findings] == [("force", "note")]


def test_the_controller_s_force_is_turned_into_the_flange_s_axes() -> None:
    """Only where the raw reading is missing."""
    robot = with_wrist_sensor(table(actual_TCP_force=WRENCH), ARM, False, [])
    rotation = link_frames(ARM, Q)[0][:, 6]
    back = np.einsum("nij,nhj->nhi", rotation, robot[FORCE_CHANNELS].to_numpy().reshape(-1, 2, 3))
    np.testing.assert_allclose(back.reshape(-1, 6), WRENCH, atol=1e-12)
    both = table(actual_TCP_force=WRENCH, ft_raw_wrench=2 * WRENCH)
    raw = with_wrist_sensor(both, ARM, False, [])
    np.testing.assert_array_equal(raw[FORCE_CHANNELS], 2 * WRENCH)


@pytest.mark.parametrize("name", ["ft_raw_wrench", "actual_TCP_force"])
def test_a_constant_is_no_sensor(name: str) -> None:
    silent = table(**{name: np.zeros((50, 6))})
    findings: list[Finding] = []
    assert with_wrist_sensor(silent, ARM, False, findings) is silent
    assert not findings


def test_an_arm_without_a_wrist_sensor_has_none() -> None:
    """The controller of a CB3 estimates actual_TCP_force from currents."""
    estimated = table(actual_TCP_force=WRENCH)
    assert with_wrist_sensor(estimated, load_robot(robot_path("ur5")), False, []) is estimated


def test_another_sensor_that_the_study_names_comes_first() -> None:
    findings: list[Finding] = []
    robot = with_wrist_sensor(table(ft_raw_wrench=WRENCH), ARM, True, findings)
    assert not {*FORCE_CHANNELS} & {*robot}
    assert "another force sensor" in said(findings[0])
