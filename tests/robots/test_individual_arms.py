"""Arms of one's own: numbers that differ, kinematic calibration, mounting, tool."""

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from scipy.spatial.transform import Rotation

from tests.command import words
from tests.conftest import PROJECT, shared_folder
from tests.robots.test_arm_family import ROS_LINKS, by_pinocchio
from ur5lib.dynamics.link_model import LinkModel
from ur5lib.errors import InputError
from ur5lib.robots.description import Robot, load_robot, robot_path, robot_yaml
from ur5lib.robots.individual import (
    calibrated_robot,
    chain,
    individual_robot,
    link_matrix,
    overridden_data,
)
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.robots.statics import flange_kinematics
from ur5lib.study.arms import Tilt, base_gravity
from ur5lib.study.reading import parse_study
from ur5lib.timeseries.arrays import Array

# Overrides


def test_any_number_can_be_different(ur5e: Robot) -> None:
    override = {
        "masses": {4: 1.5},
        "denavit_hartenberg": {"6": {"d": 0.1}},
        "motors": {"size1": {"torque_constant": 0.08}},
        "models": {"maker": {"centers_of_mass": {2: [0.2, 0, 0.1]}}},
    }
    own = individual_robot(robot_path("ur5e"), "mine", override, None)
    assert own.name == "mine"
    assert own.masses == (*ur5e.masses[:3], 1.5, *ur5e.masses[4:])
    assert own.denavit_hartenberg[5].d == 0.1
    assert own.maker_torque_constants()[5] == pytest.approx(8.08)
    assert own.models["maker+rotors"].centers_of_mass[1] == (0.2, 0, 0.1)
    assert own.models["maker"].centers_of_mass[0] == ur5e.models["maker"].centers_of_mass[0]


def test_nothing_different_is_the_arm_itself(ur5e: Robot, tmp_path: Path) -> None:
    own = individual_robot(robot_path("ur5e"), "ur5e", {}, None)
    (tmp_path / "own.yaml").write_text(robot_yaml(own))
    assert own == ur5e == load_robot(tmp_path / "own.yaml")


def test_lists_are_changed_entry_by_entry_or_as_a_whole() -> None:
    assert overridden_data([1, 2, 3], {2: 0}) == [1, 0, 3]
    assert overridden_data([1, 2, 3], [4]) == [4]
    assert overridden_data({"a": {"b": 1, "c": 2}}, {"a": {"b": 3}, "d": 4}) == {
        "a": {"b": 3, "c": 2},
        "d": 4,
    }


@pytest.mark.parametrize("override", [{"mases": [1]}, {"masses": {7: 1.0}}, {"masses": {1: -2}}])
def test_a_wrong_override_is_told(override: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="`override` of mine"):
        individual_robot(robot_path("ur5e"), "mine", override, None)


# Calibration


def bent(robot: Robot, size: float = 1e-3) -> list[Array]:
    """Frames 0 to 6 at q = 0 of an arm whose axes lie some millimetres and millirads off."""
    random, frames = np.random.default_rng(4), chain(list(map(link_matrix, robot.link_poses())))
    for frame in frames[1:6]:
        turn = Rotation.from_rotvec(size * random.normal(size=3)).as_matrix()
        frame[:3, :3] = turn @ frame[:3, :3]
        frame[:3, 3] += size * random.normal(size=3)
    frames[6] = frames[5] @ link_matrix(robot.link_poses()[5])
    return frames


def common_normals(frames: Sequence[Array]) -> list[tuple[float, float, float, float]]:
    """Denavit-Hartenberg θ, d, a, α of a chain: between the common normals of its axes.

    Independent of the project's own code; the normal of two almost parallel axes is far away.
    """
    normals, feet = [frames[0][:3, 0]], [frames[0][:3, 3]]
    for before, after in pairwise(frames[:6]):
        z, w = before[:3, 2], after[:3, 2]
        x = np.cross(z, w) / np.linalg.norm(np.cross(z, w))
        x = x if x @ after[:3, 0] > 0 else -x
        gap = after[:3, 3] - before[:3, 3]
        normals.append(x)
        feet.append(after[:3, 3] + np.linalg.solve(np.column_stack([z, x, -w]), gap)[2] * w)
    normals.append(frames[6][:3, 0])
    feet.append(frames[6][:3, 3])
    axes, parameters = [frame[:3, 2] for frame in frames], []
    for k in range(6):
        (x, y), (z, w), (foot, other) = normals[k : k + 2], axes[k : k + 2], feet[k : k + 2]
        theta = np.arctan2(np.cross(x, y) @ z, x @ y)
        alpha = np.arctan2(np.cross(z, w) @ y, z @ w)
        between = other - foot
        parameters.append((float(theta), float(between @ z), float(between @ y), float(alpha)))
    return parameters


def calibration_conf(robot: Robot, parameters: Sequence[Sequence[float]]) -> str:
    """The controller's file: what is added to the nominal parameters."""
    nominal = [(0.0, link.d, link.a, link.alpha) for link in robot.denavit_hartenberg]
    deltas = (np.array(parameters) - np.array(nominal)).T
    names = ("delta_theta", "delta_d", "delta_a", "delta_alpha")
    rows = [
        f"{name} = [ {', '.join(map(repr, row.tolist()))}]"
        for name, row in zip(names, deltas, strict=True)
    ]
    checksums = "joint_checksum = [ 0x6e0f7bf, 0xa32a713f, 0xf636a50, 0x9ec2338a, 0xa1, 0xb29b]"
    return "\n".join(["[mounting]", *rows, checksums, "calibration_status = 2 # 0 == not", ""])


def flange(frames: Sequence[Array], q: Array) -> tuple[Array, Array]:
    """R (3, 3), o (3,) of a chain of frames given at q = 0, each joint turned by q about its z."""
    pose = np.eye(4)
    for (before, after), angle in zip(pairwise(frames), q, strict=True):
        turn = np.eye(4)
        turn[:3, :3] = Rotation.from_rotvec([0, 0, angle]).as_matrix()
        pose = pose @ turn @ np.linalg.inv(before) @ after
    return pose[:3, :3], pose[:3, 3]


def expect_flange(robot: Robot, frames: Sequence[Array], atol: float) -> None:
    q = np.random.default_rng(1).uniform(-3, 3, (20, 6))
    rotation, origin, _ = flange_kinematics(robot, q)
    for k, angles in enumerate(q):
        R, o = flange(frames, angles)
        np.testing.assert_allclose(origin[k], o, rtol=0, atol=atol)
        np.testing.assert_allclose(rotation[k], R, rtol=0, atol=atol)


@pytest.mark.parametrize("name", ["ur5e", "ur10e", "ur3"])
def test_a_controller_s_calibration_places_the_flange(name: str, tmp_path: Path) -> None:
    """With offsets of many metres, as real files have them for joints 2 to 4."""
    robot, path = load_robot(robot_path(name)), tmp_path / "calibration.conf"
    frames = bent(robot)
    parameters = common_normals(frames)
    path.write_text(calibration_conf(robot, parameters))
    assert max(abs(d) for _, d, _, _ in parameters) > 20  # m
    own = calibrated_robot(robot, path)
    expect_flange(own, frames, atol=1e-11)
    for nominal, ours in zip(robot.link_poses(), own.link_poses(), strict=True):
        away = np.subtract(link_matrix(ours), link_matrix(nominal))
        assert np.abs(away).max() < 0.02  # the frames stay where the centres of mass mean them


def test_opposite_offsets_of_parallel_axes_cancel(ur5e: Robot, tmp_path: Path) -> None:
    """161, -196 and 35 m with axes that stay parallel: nothing but a shift of 1 mm is left."""
    parameters = [[0.0, link.d, link.a, link.alpha] for link in ur5e.denavit_hartenberg]
    for link, offset in zip(parameters[1:4], (161.0, -196.0, 35.001), strict=True):
        link[1] += offset
    path = tmp_path / "calibration.conf"
    path.write_text(calibration_conf(ur5e, parameters))
    own, q = calibrated_robot(ur5e, path), np.zeros((1, 6))
    (_, at, _), (_, before, _) = flange_kinematics(own, q), flange_kinematics(ur5e, q)
    np.testing.assert_allclose(at - before, [[0, -0.001, 0]], atol=1e-12)
    ours, nominal = (LinkModel(one, "maker+rotors") for one in (own, ur5e))
    states = np.random.default_rng(0).uniform(-3, 3, (3, 50, 6))
    torques = [model.inverse_dynamics(*states) for model in (ours, nominal)]
    assert 0 < np.abs(torques[0] - torques[1]).max() < 0.1  # Nm


def test_the_ros_driver_s_calibration_places_the_flange(ur5e: Robot, tmp_path: Path) -> None:
    frames, links = bent(ur5e), {}
    on_axes = [np.eye(4), *frames[:5], frames[6]]  # base, and ROS's frames of the links
    for name, (before, after) in zip(ROS_LINKS, pairwise(on_axes), strict=True):
        step = np.linalg.inv(before) @ after
        angles = Rotation.from_matrix(step[:3, :3]).as_euler("xyz").tolist()
        values = [*step[:3, 3].tolist(), *angles]
        links[name] = dict(zip(("x", "y", "z", "roll", "pitch", "yaw"), values, strict=True))
    path = tmp_path / "calibration.yaml"
    path.write_text(yaml.safe_dump({"kinematics": {**links, "hash": "calib_1278"}}))
    expect_flange(calibrated_robot(ur5e, path), frames, atol=1e-11)


@pytest.mark.parametrize("name", ["ur3", "ur5", "ur10", "ur3e", "ur5e", "ur10e", "ur16e"])
def test_the_ros_description_calibrates_nothing(name: str) -> None:
    folder = shared_folder("arms", "they are config/ of Universal_Robots_ROS2_Description")
    robot = load_robot(robot_path(name))
    own = calibrated_robot(robot, folder / name / "default_kinematics.yaml")
    for nominal, ours in zip(robot.link_poses(), own.link_poses(), strict=True):
        np.testing.assert_allclose(link_matrix(ours), link_matrix(nominal), rtol=0, atol=1.001e-6)


def test_a_calibrated_arm_is_the_same_in_another_engine(ur5e: Robot, tmp_path: Path) -> None:
    path = tmp_path / "calibration.conf"
    path.write_text(calibration_conf(ur5e, common_normals(bent(ur5e, 5e-3))))
    own = calibrated_robot(ur5e, path)
    (tmp_path / "own.yaml").write_text(robot_yaml(own))
    assert load_robot(tmp_path / "own.yaml") == own
    given = np.random.default_rng(0).uniform(-3, 3, (3, 20, 6))
    theirs = by_pinocchio(own, rigid_bodies(own, "maker+rotors"), given)
    ours = LinkModel(own, "maker+rotors").inverse_dynamics(*given)
    np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-7)


@pytest.mark.parametrize(
    ("text", "named"),
    [
        ("delta_theta = [1, 2]", "`delta_theta`"),
        ("delta_theta = [0, 0, 0, 0, 0, 0]", "`delta_d`"),
        ("nothing: here", "no calibration"),
        ("[: no yaml", "no calibration"),
    ],
)
def test_a_wrong_calibration_is_named(ur5e: Robot, tmp_path: Path, text: str, named: str) -> None:
    path = tmp_path / "calibration.conf"
    path.write_text(text)
    with pytest.raises(InputError, match=rf"calibration\.conf.*{named}"):
        calibrated_robot(ur5e, path)


def test_the_calibration_of_another_arm_is_told() -> None:
    folder = shared_folder("arms", "they are config/ of Universal_Robots_ROS2_Description")
    robot = load_robot(robot_path("ur10e"))
    with pytest.raises(InputError, match=r"mm .*ur10e"):
        calibrated_robot(robot, folder / "ur5e" / "default_kinematics.yaml")


# Mounting


@pytest.mark.parametrize(
    ("mounting", "gravity"),
    [
        ("floor", (0, 0, -9.82)),
        ("wall", (0, -9.82, 0)),
        ("ceiling", (0, 0, 9.82)),
        (Tilt(tilt_deg=90, rotation_deg=90), (-9.82, 0, 0)),
        (Tilt(tilt_deg=30), (0, -4.91, -9.82 * np.sqrt(0.75))),
        ((1.0, 2.0, 9.3), (1.0, 2.0, 9.3)),
    ],
)
def test_gravity_follows_from_the_mounting(mounting: Any, gravity: Sequence[float]) -> None:
    np.testing.assert_allclose(base_gravity(mounting, 9.82), gravity, atol=1e-9)


# In a study

TOOL = {"mass": 1.2, "center_of_mass": [0, 0, 0.05], "tcp": [0, 0, 0.1, 0, 0, 0]}


def study(tmp_path: Path, robot: Any, *recordings: dict[str, Any]) -> Any:
    entries = [
        {"name": f"run{k}", "format": "rtde-csv", "role": "fit", "folder": str(tmp_path)}
        | {"file": f"{k}.csv"}
        | entry
        for k, entry in enumerate(recordings)
    ]
    return parse_study(
        {"study": "mine", "title": "Mine", "robot": robot, "recordings": entries}, "mine.yaml"
    )


def test_the_study_s_arm_is_that_of_its_recordings(tmp_path: Path) -> None:
    robot = {"arm": "ur5e", "name": "cell-2", "mounting": "ceiling", "tool": TOOL}
    own = {"mounting": "floor", "tool": {"mass": 0.3}}
    given = study(tmp_path, robot, {}, own, {"payload": {"mass": 0.8}}, {"robot": "ur10e"})
    assert [one.arm.known_as for one in given.recordings] == ["cell-2"] * 3 + ["ur10e"]
    assert {*given.arms()} == {"cell-2", "ur10e"}
    ups = [one.known_gravity() for one in given.recordings]
    assert ups == [(0, 0, 9.82), (0, 0, -9.82), (0, 0, 9.82), None]
    masses = [one.known_payload() and one.known_payload().mass for one in given.recordings]
    assert masses == [1.2, 0.3, 2.0, None]
    assert given.recordings[2].known_payload().center_of_mass == pytest.approx((0, 0, 0.03))


@pytest.mark.parametrize(
    ("robot", "recording", "named"),
    [
        (None, {}, "`recordings[0].robot` missing `robot`"),
        ({"arm": "ur7"}, {}, "`robot.arm` `ur7` docs/robots.md"),
        ({"arm": "ur5e", "tol": 1}, {}, "`robot.tol` `tool` calibration mounting"),
        ({"arm": "ur5e", "mounting": "cieling"}, {}, "`robot.mounting` 'cieling' `ceiling` wall"),
        ({"arm": "ur5e", "mounting": {"tilt": 3}}, {}, "`robot.mounting.tilt_deg` -180 180"),
        ({"arm": "ur5e", "tool": {"mass": -1}}, {}, "`robot.tool.mass` -1 0"),
        ({"arm": "ur5e", "calibration": "no.conf"}, {}, "`robot.calibration` 'no.conf'"),
        ({"arm": "ur5e", "override": {"masses": {1: -1}}}, {}, "`override` ur5e docs/robots.md"),
        ("ur5e", {"mounting": "wall", "gravity": [0, 0, 9.8]},
         "`recordings[0]` `gravity` `mounting`"),
    ],
)  # fmt: skip
def test_a_wrong_arm_is_named(tmp_path: Path, robot: Any, recording: Any, named: str) -> None:
    with pytest.raises(InputError) as error:
        study(tmp_path, robot, recording)
    first, *_ = str(error.value).splitlines()
    assert words(f"mine.yaml {named}") <= words(first)


def test_two_arms_of_one_name_are_named(tmp_path: Path) -> None:
    other = {"robot": {"arm": "ur5e", "override": {"masses": {1: 4.0}}}}
    with pytest.raises(InputError, match=r"run1.*ur5e.*`name`"):
        study(tmp_path, "ur5e", {}, other)
    other["robot"]["name"] = "cell-2"
    assert {*study(tmp_path, "ur5e", {}, other).arms()} == {"ur5e", "cell-2"}


def test_an_arm_is_described_beside_the_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "robots").mkdir()
    text = (PROJECT / "ur5lib/robots/ur5e.yaml").read_text().replace("name: ur5e", "name: ur7e")
    (tmp_path / "robots/ur7e.yaml").write_text(text)
    monkeypatch.chdir(tmp_path)
    given = study(tmp_path, "ur7e", {})
    assert given.arms()["ur7e"].description().name == "ur7e"
    (tmp_path / "robots/ur5e.yaml").write_text(text)
    with pytest.raises(InputError, match=r"robots/ur5e\.yaml"):
        study(tmp_path, "ur5e", {})
