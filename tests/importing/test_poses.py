"""A pose in any form is no joint angles and no efforts, and tells the arm by its kinematics."""

from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

from tests.importing.test_import_cases import driven, motion
from ur5lib.importing.contents import UserStatement
from ur5lib.importing.files import ImportedRecording, import_files
from ur5lib.records.account import NOTHING, AccountRow
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array

Turn = Callable[[Rotation], Array]
RATE, SECONDS = 50.0, 12.0
TOOL = np.array([0.03, -0.01, 0.12])  # m, in the last frame
FORMS: dict[str, tuple[Sequence[str], float, Turn, str]] = {  # names, units in a metre, form
    "Fanuc": (
        [*"XYZWPR"], 1e3, lambda turn: turn.as_euler("xyz", degrees=True), "W, P, R) in deg",
    ),
    "KUKA": ([*"XYZABC"], 1e3, lambda turn: turn.as_euler("ZYX", degrees=True), "in deg"),
    "RPY": (
        ["x", "y", "z", "roll", "pitch", "yaw"], 1.0, lambda turn: turn.as_euler("xyz"),
        "W, P, R) in rad",
    ),
    "vector": (["x", "y", "z", "rx", "ry", "rz"], 1.0, Rotation.as_rotvec, "vector in rad"),
    "wxyz": (
        ["x", "y", "z", "qw", "qx", "qy", "qz"], 1.0, Rotation.as_quat, "quaternion",
    ),
    "ROS": (
        [*(f"pose.position.{a}" for a in "xyz"), *(f"pose.orientation.{a}" for a in "xyzw")],
        1.0, Rotation.as_quat, "quaternion x, y, z, w",
    ),
    "list": ([f"ee_state_{k}" for k in range(6)], 1.0, Rotation.as_rotvec, "vector in rad"),
    "list mm": (
        [f"tcp_pose_{k}" for k in range(6)], 1e3,
        lambda turn: turn.as_rotvec(degrees=True), "vector in deg",
    ),
    "list of seven": ([f"pose_{k}" for k in range(7)], 1.0, Rotation.as_quat, "x, y, z, w"),
    "nameless": ([], 1.0, Rotation.as_rotvec, "vector in rad"),
    "nameless mm": ([], 1e3, lambda turn: turn.as_euler("xyz", degrees=True), "in deg"),
}  # fmt: skip


@pytest.fixture(scope="module")
def arm() -> Robot:
    return load_robot(robot_path("ur5e"))


@pytest.fixture(scope="module")
def moved(arm: Robot) -> tuple[Array, Array, Array, Array]:
    """Time (N,), angles, velocities and currents (N, 6) of an arm that swings all its joints."""
    random = np.random.default_rng(5)
    time = np.arange(0, SECONDS, 1 / RATE)
    q, qd, qdd = motion(arm, time, random)
    return time, q, qd, driven(arm, q, qd, qdd, None, random)["actual_current"]


def rows_of_pose(arm: Robot, q: Array, form: str, tool: bool = False) -> Array:
    """The pose (N, 6) or (N, 7) of the flange, or of a tool that is turned on it."""
    _, per_metre, as_columns, _ = FORMS[form]
    frames, origin = link_frames(arm, q)
    turn = Rotation.from_matrix(frames[:, -1])
    position = origin[:, -1] + (turn.apply(TOOL) if tool else 0.0)
    turned = turn * Rotation.from_rotvec([0.0, 0.4, 0.2]) if tool else turn
    rotation = as_columns(turned)
    if form == "wxyz":
        rotation = rotation[:, [3, 0, 1, 2]]
    return np.hstack([per_metre * position, rotation])


def imported(
    path: Path, moved: Sequence[Array], form: str, pose: Array, told: str, velocities: bool
) -> ImportedRecording:
    """The import of a log of motion, pose and currents."""
    time, q, qd, currents = moved
    names = FORMS[form][0]
    rates = [qd] if velocities else []
    rows = np.column_stack([time, q, *rates, pose, currents])
    quantities = ["joint_position", *(["joint_velocity"] if velocities else [])]
    columns = [f"{n}_{k}" for n in quantities for k in range(6)]
    header = ["time", *columns, *names, *(f"joint_current_{k}" for k in range(6))]
    table = pd.DataFrame(rows, columns=header if names else None)
    table.to_csv(path, index=False, header=bool(names), float_format="%.6f")
    (one,) = import_files([path], UserStatement(told))
    return one


def told_of(one: ImportedRecording, subject: str) -> list[AccountRow]:
    return [row for row in one.account if row.subject == subject]


def check_channels(one: ImportedRecording, names: Sequence[str], velocities: bool) -> None:
    """Positions, velocities and currents are where they were written, the pose is none of them."""
    width = len(names) or 6
    kept = ["time", "actual_q", *(["actual_qd"] if velocities else []), *["-"] * width]
    columns = one.entry["columns"]
    assert [*columns] == [*kept, "actual_current"]


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("velocities", [True, False])
def test_a_pose_proves_the_declared_arm(
    tmp_path: Path, arm: Robot, moved: Sequence[Array], form: str, velocities: bool
) -> None:
    pose = rows_of_pose(arm, moved[1], form)
    one = imported(tmp_path / "log.csv", moved, form, pose, "ur5e", velocities)
    check_channels(one, FORMS[form][0], velocities)
    (row,) = told_of(one, "robot")
    assert (row.taken_for, row.confidence) == ("ur5e", "proven")
    (posed,) = [row for row in one.account if row.reason.startswith("a pose in ")]
    assert posed.taken_for == NOTHING
    assert FORMS[form][3] in posed.reason
    assert any(row.confidence == "evidence" and "pose: " in row.reason for row in one.account)


@pytest.mark.parametrize("form", ["Fanuc", "ROS", "list", "nameless"])
def test_a_pose_contradicts_another_arm_and_names_the_right_one(
    tmp_path: Path, arm: Robot, moved: Sequence[Array], form: str
) -> None:
    pose = rows_of_pose(arm, moved[1], form, tool=True)
    one = imported(tmp_path / "log.csv", moved, form, pose, "ur10", velocities=False)
    check_channels(one, FORMS[form][0], velocities=False)
    doubt = next(row for row in told_of(one, "robot") if row.confidence == "check")
    assert "a tool of ur5e within 0.0 mm" in doubt.reason
    assert "--robot" in doubt.reason


@pytest.mark.parametrize("form", ["KUKA", "list of seven", "nameless mm"])
def test_a_pose_tells_an_arm_that_nobody_names(
    tmp_path: Path, arm: Robot, moved: Sequence[Array], form: str
) -> None:
    pose = rows_of_pose(arm, moved[1], form, tool=True)
    one = imported(tmp_path / "log.csv", moved, form, pose, "", velocities=True)
    (row,) = told_of(one, "robot")
    assert (row.taken_for, row.confidence) == ("ur5e", "proven")


def test_angles_that_are_no_rotation_vector_are_no_pose_of_a_study(
    tmp_path: Path, arm: Robot, moved: Sequence[Array]
) -> None:
    """Under RTDE's name, too, which has a rotation vector in rad."""
    frames, origin = link_frames(arm, moved[1])
    angles = Rotation.from_matrix(frames[:, -1]).as_euler("xyz")
    columns = {f"actual_TCP_pose_{k}": column for k, column in enumerate(
        np.hstack([origin[:, -1], angles]).T
    )}  # fmt: skip
    motion = {f"actual_q_{k}": column for k, column in enumerate(moved[1].T)}
    table = pd.DataFrame({"time": moved[0], **motion, **columns})
    table.to_csv(tmp_path / "log.csv", index=False)
    (one,) = import_files([tmp_path / "log.csv"], UserStatement("ur5e"))
    assert "actual_TCP_pose" not in str(one.entry["columns"])
    assert "roll, pitch, yaw" in str(one.account)


def test_what_only_travels_like_a_flange_is_no_pose(tmp_path: Path, moved: Sequence[Array]) -> None:
    pose = 0.3 * np.sin(moved[0][:, None] * np.linspace(0.5, 1.1, 6))
    one = imported(tmp_path / "log.csv", moved, "Fanuc", pose, "ur5e", velocities=True)
    (row,) = told_of(one, "robot")
    assert row.confidence == "assumed"
    assert "a pose in" not in str(one.account)
