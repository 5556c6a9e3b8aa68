"""A made-up industrial arm whose links nobody knows: what is wrong with its log or drives is told.

As `ur5 check` and the workflow see it, and no right log is doubted.
"""

import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
import yaml

from benchmarks.harness.abb_like import PERIOD, MadeUpArm, write_files
from tests.conftest import said
from ur5lib.checks.checked import Checked, described_arms
from ur5lib.checks.devices import checked_intake
from ur5lib.checks.stop_signs import stop_signs
from ur5lib.checks.unchecked import unchecked
from ur5lib.errors import InputError
from ur5lib.recordings.entries import ENTRY
from ur5lib.recordings.intake import Intake, read_and_repair
from ur5lib.records.codes import Found
from ur5lib.robots.description import Robot, load_robot, robot_of, robot_path
from ur5lib.robots.from_urdf import robot_from_urdf

SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.thorough) for seed in (1, 2))]
MOTIONS = 3
COLUMNS = ["time", "actual_q", "actual_torque"]
ANGLES = [f"motor_angle_{joint}" for joint in range(1, 7)]
TORQUES = [f"motor_torque_{joint}" for joint in range(1, 7)]
Spoil = Callable[[pd.DataFrame], pd.DataFrame]


class Cell:
    """A folder with an arm's URDF and a log of three motions; description: of its user."""

    def __init__(self, seed: int, folder: Path) -> None:
        self.made, self.folder = MadeUpArm(seed), folder
        write_files(self.made, seed, folder, {"log": (MOTIONS, 0.03)})
        robot, _ = robot_from_urdf(folder / "arm.urdf")
        plain = robot.model_dump(mode="json", exclude_none=True)
        self.description = self.made.as_described(plain)
        self.log = pd.read_csv(folder / "log.csv")

    def arm(self, effort: str = "motor_torque", **drives: Any) -> Robot:
        """Return the arm as described, but for its effort or some of its drives."""
        changed = {"drives": self.description["drives"] | drives, "effort": effort}
        return robot_of(self.description | changed)

    def read(self, spoil: Spoil, arm: Robot, part: int = 0, **stated: Any) -> Intake:
        """Return one motion of a spoilt log, as read and checked; stated: in its entry."""
        table = spoil(self.log.copy())
        in_part = (table["time"] - table["time"].iloc[0]) // PERIOD == part
        table[in_part].to_csv(self.folder / "spoilt.csv", index=False)
        entry = {"name": "spoilt", "role": "fit", "format": "table-csv", "file": "spoilt.csv"}
        entry |= {"folder": str(self.folder), "columns": COLUMNS, **stated}
        return checked_intake(read_and_repair(ENTRY.validate_python(entry), arm, 0.1), arm)

    def stops(self, spoil: Spoil, arm: Robot | None = None, part: int = 0) -> list[str]:
        """Return the stop signs of one motion."""
        arm = arm or self.arm()
        return [said(sign) for sign in stop_signs(checked(self.read(spoil, arm, part), arm))]


def checked(intake: Intake, arm: Robot) -> Checked:
    return Checked(intake.robot, arm, None, None, True, cutoff=2.0)


@pytest.fixture(scope="module", params=SEEDS)
def cell(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Cell:
    return Cell(request.param, tmp_path_factory.mktemp("cell"))


def right(table: pd.DataFrame) -> pd.DataFrame:
    return table


def times(names: Sequence[str], factor: float) -> Spoil:
    """Multiply some columns."""

    def spoil(table: pd.DataFrame) -> pd.DataFrame:
        table[[*names]] *= factor
        return table

    return spoil


def test_a_right_log_is_not_doubted(cell: Cell) -> None:
    arm = cell.arm()
    for part in range(MOTIONS):
        intake = cell.read(right, arm, part)
        assert stop_signs(checked(intake, arm)) == []
        assert {one.code for one in intake.quality.findings} == {Found.NO_VELOCITIES}
        open_ones = {one.code for one in unchecked(checked(intake, arm))}
        assert open_ones.isdisjoint(
            {Found.SIZE_NOT_CHECKED, Found.TORQUES_NOT_CHECKED, Found.NOTHING_CHECKED}
        )


@pytest.mark.parametrize("joint", range(1, 7))
def test_a_torque_of_the_opposite_sign_is_told_by_its_friction(cell: Cell, joint: int) -> None:
    """In most motions; of the others, `ur5 check` says that it cannot tell."""
    told = 0
    for part in range(MOTIONS):
        turned = times(TORQUES[joint - 1 : joint], -1)
        signs = cell.stops(turned, part=part)
        if signs:
            (sign,) = signs
            assert f"reversed on joint {joint};" in sign
            remedy = yaml.safe_load(re.findall(r"`units: (.*?)`", sign)[0])
            mended = cell.read(turned, cell.arm(), part, units=remedy)
            assert stop_signs(checked(mended, cell.arm())) == []
            told += 1
        else:
            arm = cell.arm()
            of_part = unchecked(checked(cell.read(turned, arm, part), arm))
            (note,) = (said(one) for one in of_part if one.code == Found.SIGN_NOT_CHECKED)
            assert str(joint) in note
    assert told > MOTIONS / 2


def test_a_direct_drive_tells_no_sign(cell: Cell) -> None:
    """Its friction may be less than what its links' motion leaves unexplained."""
    arm = cell.arm()
    motors = {name: m.model_copy(update={"gear_ratio": 1.0}) for name, m in arm.motors.items()}
    direct = arm.model_copy(update={"motors": motors})
    turned = cell.read(times(TORQUES, -1), arm)
    assert stop_signs(checked(turned, arm)) != []
    assert stop_signs(checked(turned, direct)) == []
    open_ones = unchecked(checked(turned, direct))
    (note,) = (said(one) for one in open_ones if one.code == Found.SIGN_NOT_CHECKED)
    assert "joints 1, 2, 3, 4, 5, 6 could not" in note


@pytest.mark.parametrize("factor", [1e-3, 1e3])
def test_torques_in_another_unit_are_no_arms_of_that_weight(cell: Cell, factor: float) -> None:
    (sign,) = cell.stops(times(TORQUES, factor))
    assert "times what would hold an arm of 250 kg" in sign


def test_motors_torques_are_not_those_of_the_joints(cell: Cell) -> None:
    (sign,) = cell.stops(right, cell.arm(effort="joint_torque"))
    assert "times what would hold" in sign


@pytest.mark.parametrize("pair", [(2, 3), (1, 2), (4, 5)])
def test_exchanged_torques_are_told_by_the_motion_that_they_follow(
    cell: Cell, pair: tuple[int, int]
) -> None:
    """In most motions; of the others, `ur5 check` says that it cannot tell."""
    names = [TORQUES[joint - 1] for joint in pair]

    def exchanged(table: pd.DataFrame) -> pd.DataFrame:
        table[names] = table[names[::-1]].to_numpy()
        return table

    told, arm = 0, cell.arm()
    for part in range(MOTIONS):
        if signs := cell.stops(exchanged, part=part):
            assert "exchanged" in signs[0] or "reversed" in signs[0]
            told += "of joints {} and {} are exchanged".format(*pair) in signs[0]
        else:
            open_ones = unchecked(checked(cell.read(exchanged, arm, part), arm))
            (note,) = (said(one) for one in open_ones if one.code == Found.COLUMNS_NOT_CHECKED)
            assert f"{pair[0]}-{pair[1]}" in note
    assert told > MOTIONS / 2


@pytest.mark.parametrize("seconds", [-0.1, 0.1])
def test_torques_of_another_clock_are_told(cell: Cell, seconds: float) -> None:
    def late(table: pd.DataFrame) -> pd.DataFrame:
        table[TORQUES] = table[TORQUES].shift(round(seconds / 0.004)).bfill().ffill()
        return table

    (sign,) = cell.stops(late)
    told = re.match(r"actual_torque comes (\d\.\d\d) s (later|earlier)", sign)
    assert told is not None
    assert told[2] == ("later" if seconds > 0 else "earlier")
    # dry friction that reverses gradually is late by itself
    assert float(told[1]) == pytest.approx(abs(seconds), abs=0.021)


def test_a_torque_that_never_changes_is_none(cell: Cell) -> None:
    """As of a drive that was not logged; the same refuses the fit."""
    (sign,) = cell.stops(times(TORQUES[2:3], 0.0))
    assert "on joint 3 while" in sign


def test_exchanged_columns_are_no_torques(cell: Cell) -> None:
    arm = cell.arm()
    exchanged = cell.read(right, arm, columns=["time", "actual_torque", "actual_q"])
    (sign,) = stop_signs(checked(exchanged, arm))
    assert "times what would hold" in said(sign)


def test_an_arm_without_a_weight_does_not_tell_the_unit(cell: Cell) -> None:
    arm = cell.arm().model_copy(update={"weight": None})
    intake = cell.read(times(TORQUES, 1e3), arm)
    assert stop_signs(checked(intake, arm)) == []
    assert Found.SIZE_NOT_CHECKED in {one.code for one in unchecked(checked(intake, arm))}


def test_joints_counted_from_another_home_leave_their_range(cell: Cell) -> None:
    home = np.array(cell.description["drives"]["home_deg"]) + 180.0
    found = cell.read(right, cell.arm(home_deg=home.tolist())).quality.findings
    (warning,) = (one for one in found if one.code == Found.JOINTS_BEYOND_THEIR_RANGE)
    assert warning.severity == "warning"
    assert "correct `home_deg`, `directions`" in said(warning)


def test_an_arm_may_turn_farther_than_others(cell: Cell) -> None:
    """Its own range says how far: joint 6 by 30 turns."""
    gear = cell.description["motors"]["joint_6"]["gear_ratio"]

    def far(table: pd.DataFrame) -> pd.DataFrame:
        table["motor_angle_6"] += 60 * np.pi * gear
        return table

    motors = cell.description["motors"]
    wide = {"motors": motors | {"joint_6": motors["joint_6"] | {"position_max": 400.0}}}
    arm = robot_of(cell.description | wide)
    intake = cell.read(far, arm)
    assert stop_signs(checked(intake, arm)) == []
    with pytest.raises(InputError, match="or the arm's limits"):
        cell.read(far, cell.arm())


def test_torques_logged_now_and_then_are_taken_between(cell: Cell) -> None:
    """Every third row has one, as where topics have rates of their own."""

    def sparse(table: pd.DataFrame) -> pd.DataFrame:
        table.loc[table.index % 3 != 0, TORQUES] = np.nan
        return table

    arm = cell.arm()
    found, whole = cell.read(sparse, arm), cell.read(right, arm)
    assert stop_signs(checked(found, arm)) == []
    assert not found.robot["interpolated"].any()
    names = [f"actual_torque_{joint}" for joint in range(6)]
    rows = found.robot["time"].size
    error = found.robot[names].to_numpy() - whole.robot[names].to_numpy()[:rows]
    assert np.sqrt((error**2).mean()) < 0.1 * whole.robot[names].to_numpy().std()


def test_a_wrong_description_of_another_arm_blocks_none(
    cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Which lies in the project's folder `robots`, beside that of this study."""
    monkeypatch.chdir(cell.folder)
    (cell.folder / "robots").mkdir(exist_ok=True)
    (cell.folder / "robots" / "other.yaml").write_text("name: other\ndrives: 3\n")
    arms = described_arms()
    assert "ur5" in arms
    assert "other" not in arms
    with pytest.raises(InputError, match=r"other.yaml .*`drives` is 3; give a mapping"):
        load_robot(robot_path("other"))
