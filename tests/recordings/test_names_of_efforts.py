"""Arms that measure torques have them in Nm, under their own name, from the file to the tables."""

from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow.parquet as pq
import pytest
from pydantic import ValidationError

from tests.conftest import said
from tests.recordings.test_recordings_of_joints import PERIOD, sensing
from ur5lib.channels import CURRENT, TORQUE
from ur5lib.checks.checked import Checked
from ur5lib.checks.unchecked import unchecked
from ur5lib.recordings.entries import ENTRY
from ur5lib.recordings.intake import Intake, read_and_repair
from ur5lib.records.codes import Found
from ur5lib.records.signals import Signals
from ur5lib.robots.description import Robot, load_robot, robot_of, robot_path
from ur5lib.tables import channel, named, unit

TIME = np.arange(0, 4, PERIOD)
Q = np.sin(TIME[:, None] * np.arange(1, 8)) / 2
TORQUES = 100 * np.cos(TIME[:, None] * np.arange(1, 8))  # beyond what a current may be


def read(folder: Path, arm: Robot, *names: str, **stated: Any) -> Intake:
    """Positions, and channels of efforts under these names, in turn a tenth as large."""
    joints = len(arm.joints)
    efforts = {
        column: values
        for k, name in enumerate(names)
        for column, values in named(TORQUES[:, :joints] / 10**k, name).items()
    }
    table = {"timestamp": TIME} | named(Q[:, :joints], "actual_q") | efforts
    pd.DataFrame(table).to_csv(folder / "run.csv", index=False)
    entry = {"name": "run", "role": "fit", "format": "rtde-csv", "file": "run.csv"}
    entry |= {"folder": str(folder), **stated}
    return read_and_repair(ENTRY.validate_python(entry), arm, 0.1)


@pytest.mark.parametrize(
    "names",
    [
        ("actual_torque",),
        ("actual_current",),
        ("actual_current_as_torque",),
        ("actual_torque", "actual_current", "target_current"),
    ],
)
def test_torques_have_their_own_name_and_unit(names: tuple[str, ...], tmp_path: Path) -> None:
    """Under whatever name the file has them; beside them, currents are left out."""
    found = read(tmp_path, sensing(7), *names)
    np.testing.assert_allclose(channel(found.robot, "actual_torque"), TORQUES, atol=1e-9)
    Signals.from_table(found.robot).write(tmp_path / "signals.parquet")
    columns = [name for name in pq.read_schema(tmp_path / "signals.parquet").names if "_0" in name]
    assert columns == ["actual_q_0", "actual_torque_0"]
    assert unit("actual_torque_0") == "Nm"
    noted = [one for one in found.quality.findings if one.code == Found.TORQUES_BY_ANOTHER_NAME]
    assert len(noted) == (names[0] != "actual_torque")


def test_the_older_name_keeps_the_units_that_a_study_gives_it(tmp_path: Path) -> None:
    signs = [1.0, 1.0, -1.0, 1.0, 1.0, 1.0, 1.0]
    found = read(tmp_path, sensing(7), "actual_current", units={"actual_current": signs})
    torque = channel(found.robot, "actual_torque")
    np.testing.assert_allclose(torque, TORQUES * signs, atol=1e-9)


def test_torques_of_motors_with_currents_are_currents(tmp_path: Path) -> None:
    """Divided by the makers' constants, without a second effort beside them."""
    ur5 = load_robot(robot_path("ur5"))
    signals = Signals.from_table(read(tmp_path, ur5, "actual_torque").robot)
    assert signals.actual_torque is None
    assert signals.effort is signals.actual_current
    np.testing.assert_allclose(
        signals.effort, TORQUES[:, :6] / ur5.maker_torque_constants(), atol=1e-9
    )


def test_what_is_missing_is_called_by_its_name(tmp_path: Path) -> None:
    arm = sensing(7)
    notes = unchecked(Checked(read(tmp_path, arm).robot, arm, None, None, True, cutoff=2.0))
    (missing,) = (one for one in notes if one.code == Found.NO_CURRENTS)
    assert "no actual_torque" in said(missing)
    assert "current" not in said(missing)


def described(**changes: Any) -> dict[str, Any]:
    """A description as by `ur5 describe`, without `effort`."""
    plain = sensing(2).model_dump(mode="json", exclude_none=True)
    del plain["effort"]
    return plain | changes


@pytest.mark.parametrize(
    ("changes", "effort"),
    [
        ({}, "current"),
        ({"drives": {"torques": "motor"}}, "motor_torque"),
        ({"drives": {"torques": "joint"}}, "joint_torque"),
        ({"drives": {"torques": "joint"}, "effort": "torque"}, "joint_torque"),
        ({"effort": "joint_torque"}, "joint_torque"),
    ],
)
def test_older_descriptions_say_what_they_measure(changes: dict[str, Any], effort: str) -> None:
    arm = described(**changes)
    for motor in arm["motors"].values():
        motor["gear_ratio"] = 50.0
    robot = robot_of(arm)
    assert robot.effort == effort
    assert robot.measured == (CURRENT if effort == "current" else TORQUE)
    assert robot.is_counted() == (effort == "motor_torque")


def test_a_constant_of_one_of_all_motors_is_a_measured_torque() -> None:
    arm = described()
    for motor in arm["motors"].values():
        motor["torque_constant"] = 1
    assert robot_of(arm).effort == "torque"
    assert robot_of(arm | {"effort": "current"}).measured == CURRENT


def test_two_sides_of_the_gears_are_refused() -> None:
    with pytest.raises(ValidationError, match="`torques` of `drives`"):
        robot_of(described(drives={"torques": "joint"}, effort="motor_torque"))


def test_terms_of_friction_in_an_older_description_have_no_effect() -> None:
    older = described(friction_terms=["velocity_root"], presliding=1e-4)
    assert robot_of(older) == robot_of(described())
