"""Files of movej and movel: how they are read, planned and refused, and inverse kinematics."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ur5lab.inverse_kinematics import inverse_kinematics
from ur5lab.recorder.commanded_motion import CommandedMotion, refusals
from ur5lab.recorder.move_program import is_program, planned_motion, read_program
from ur5lib.errors import InputError
from ur5lib.recordings.entries import ThesisFiles
from ur5lib.recordings.thesis_csv import read_thesis_csv
from ur5lib.robots.description import Robot, load_robot, robot_names, robot_path
from ur5lib.robots.statics import geometric_jacobian, link_frames
from ur5lib.tables import channel
from ur5lib.timeseries.arrays import Array

HOME = np.array([0.5, -1.6, 1.6, -1.5, 1.5, 0.3])
THESIS = "movej([2.181661, -2.135061, -1.745329, 0.275936, -6.021385, 0])"  # Figure 4.5


def flange(robot: Robot, q: Array) -> tuple[Array, Array]:
    """R_6 (N, 3, 3) and o_6 (N, 3)."""
    rotations, origins = link_frames(robot, np.atleast_2d(q))
    return rotations[:, 6], origins[:, 6]


def pose(robot: Robot, q: Array, shift: tuple[float, float, float] = (0, 0, 0)) -> str:
    """The pose of frame 6 in URScript, shifted in the base frame."""
    rotation, origin = flange(robot, q)
    turn = Rotation.from_matrix(rotation[0]).as_rotvec()
    return f"p[{', '.join(map(repr, np.hstack([origin[0] + shift, turn]).tolist()))}]"


def planned(
    folder: Path, robot: Robot, *lines: str, speed: float = 1.0, wait: float = 0.0
) -> CommandedMotion:
    path = folder / "moves.txt"
    path.write_text("\n".join(lines))
    assert is_program(path)
    return planned_motion(read_program(path), robot, HOME, speed, wait)


# Inverse kinematics


@pytest.mark.parametrize(
    "name", [name for name in robot_names() if load_robot(robot_path(name)).is_ur()]
)
def test_every_posture_is_among_the_solutions_of_its_pose(name: str) -> None:
    robot = load_robot(robot_path(name))
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (100, 6))
    rotation, position = flange(robot, q)
    found = inverse_kinematics(robot, rotation, position)
    apart = np.abs(np.exp(1j * found) - np.exp(1j * q)[:, None]).max(axis=2)
    assert np.nanmin(apart, axis=1).max() < 1e-6
    row, which = np.nonzero(np.isfinite(found).all(axis=2))
    again = flange(robot, found[row, which])
    np.testing.assert_allclose(again[0], rotation[row], atol=1e-6)
    np.testing.assert_allclose(again[1], position[row], atol=1e-6)


def test_a_calibrated_arm_reaches_its_pose_with_its_own_frames(ur5: Robot) -> None:
    random = np.random.default_rng(1)
    off = [
        one.model_copy(
            update={
                "position": tuple(np.array(one.position) + 1e-3 * random.normal(size=3)),
                "rpy": tuple(np.array(one.rpy) + 1e-3 * random.normal(size=3)),
            }
        )
        for one in ur5.link_poses()
    ]
    robot = ur5.model_copy(update={"calibration": tuple(off)})
    rotation, position = flange(robot, HOME)
    found = inverse_kinematics(robot, rotation, position)[0]
    apart = np.abs(np.exp(1j * found) - np.exp(1j * HOME)).max(axis=1)
    assert np.nanmin(apart) < 1e-9


def test_the_jacobian_is_the_derivative_of_the_pose(ur5: Robot) -> None:
    step = 1e-6
    (rotation, here), around = flange(ur5, HOME), flange(ur5, HOME + step * np.eye(6))
    linear = (around[1] - here) / step
    angular = Rotation.from_matrix(around[0] @ rotation[0].T).as_rotvec() / step
    expected = np.hstack([linear, angular]).T
    np.testing.assert_allclose(geometric_jacobian(ur5, HOME[None])[0], expected, atol=1e-5)


def test_the_controller_s_pose_is_that_of_frame_6(thesis_data: Path, ur5: Robot) -> None:
    """The tool vector that the thesis's controller sent beside the joint angles."""
    folder = thesis_data / "Movement_No8_Singularity_Free_1"
    table = read_thesis_csv(ThesisFiles(format="thesis-csv", folder=str(folder))).robot.table
    q, sent = channel(table, "actual_q"), channel(table, "actual_TCP_pose")
    rotation, position = flange(ur5, q)
    np.testing.assert_allclose(position, sent[:, :3], atol=1e-5)
    turned = Rotation.from_rotvec(sent[:, 3:]).as_matrix()
    np.testing.assert_allclose(rotation, turned, atol=1e-5)


# Plans


def test_the_thesis_s_file_starts_and_stops_at_its_way_points(tmp_path: Path, ur5: Robot) -> None:
    """As commanded: 1.05 rad/s and 1.4 rad/s² on the longest way, at rest at each way-point."""
    away = np.deg2rad([45.7, -175, -20, -88, -240, 150])
    motion = planned(tmp_path, ur5, THESIS, "", f"movej({away.tolist()})", THESIS)
    assert motion.time is not None
    first = [2.181661, -2.135061, -1.745329, 0.275936, -6.021385, 0]
    np.testing.assert_allclose(motion.q[[0, -1]], [first, first], atol=1e-12)
    qd = np.diff(motion.q, axis=0) / 0.008
    assert np.abs(qd).max() == pytest.approx(1.05)
    assert np.abs(np.diff(qd, axis=0)).max() / 0.008 == pytest.approx(1.4, rel=1e-6)
    at = np.abs(motion.q - away).max(axis=1).argmin()
    np.testing.assert_allclose(motion.q[at], away, atol=1e-12)
    assert np.abs(qd[at - 1 : at + 1]).max() < 1.4 * 0.008


def test_a_straight_line_is_straight(tmp_path: Path, ur5: Robot) -> None:
    """At 0.1 m/s, with the flange's orientation kept, and back."""
    up = pose(ur5, HOME, (0.05, -0.1, 0.1))
    start = f"movej({HOME.tolist()})"
    motion = planned(tmp_path, ur5, start, f"movel({up}, v=0.1)", f"movel({HOME.tolist()}, v=0.1)")
    rotation, position = flange(ur5, motion.q)
    way, shift = position - position[0], np.array([0.05, -0.1, 0.1])
    along = way @ shift / (shift @ shift)
    np.testing.assert_allclose(way, np.outer(along, shift), atol=1e-9)
    assert along.max() == pytest.approx(1)
    np.testing.assert_allclose(rotation, np.broadcast_to(rotation[0], rotation.shape), atol=1e-9)
    np.testing.assert_allclose(motion.q[-1], HOME, atol=1e-9)
    speed = np.linalg.norm(np.diff(position, axis=0), axis=1) / 0.008
    assert speed.max() == pytest.approx(0.1, rel=1e-6)


def test_a_straight_line_turns_evenly(tmp_path: Path, ur5: Robot) -> None:
    turned = HOME + np.array([0, 0, 0, 0, 0, 0.8])
    lines = [f"movej({HOME.tolist()})", f"movel({pose(ur5, turned)})"]
    motion = planned(tmp_path, ur5, *lines)
    np.testing.assert_allclose(motion.q[:, :5], np.tile(HOME[:5], (len(motion.q), 1)), atol=1e-9)
    np.testing.assert_allclose(motion.q[-1], turned, atol=1e-9)


def test_movej_to_a_pose_takes_the_nearest_posture(tmp_path: Path, ur5: Robot) -> None:
    goal = HOME + 0.2
    lines = [f"movej({HOME.tolist()})", f"movej({pose(ur5, goal)})"]
    np.testing.assert_allclose(planned(tmp_path, ur5, *lines).q[-1], goal, atol=1e-9)
    first = planned(tmp_path, ur5, lines[1], lines[0])  # near the present posture
    np.testing.assert_allclose(first.q[0], goal, atol=1e-9)


def test_a_turn_ends_within_the_limits(tmp_path: Path, ur5: Robot) -> None:
    """The last joint stands at 6.2 rad: 6.4 rad would be nearest, but is beyond 2 pi."""
    begin, goal = HOME.copy(), HOME.copy()
    begin[5], goal[5] = 6.2, 6.4
    lines = [f"movej({begin.tolist()})", f"movej({pose(ur5, goal)})"]
    motion = planned(tmp_path, ur5, *lines)
    assert [*refusals(motion, ur5, begin, None)] == []
    np.testing.assert_allclose(flange(ur5, motion.q[-1])[0], flange(ur5, goal)[0], atol=1e-9)
    np.testing.assert_allclose(flange(ur5, motion.q[-1])[1], flange(ur5, goal)[1], atol=1e-9)


@pytest.mark.parametrize("speed", [1.0, 0.25])
def test_waits_and_rests_are_not_slowed(tmp_path: Path, ur5: Robot, speed: float) -> None:
    near = HOME + 0.01
    lines = [f"movej({HOME.tolist()})", "sleep(1.5)", f"movej({near.tolist()})"]
    for wait, rest in ((0.0, 1.5), (4.0, 4.0)):
        motion = planned(tmp_path, ur5, *lines, speed=speed, wait=wait)
        begins = np.flatnonzero(np.abs(motion.q - HOME).max(axis=1) > 1e-9)[0]
        assert motion.time is not None
        assert motion.time[begins] / speed == pytest.approx(rest, abs=0.05)


def test_a_command_waits_for_the_end_of_the_one_before(tmp_path: Path, ur5: Robot) -> None:
    """The real controller would skip it, which the thesis warns of."""
    lines = [f"movej({(HOME + k * 0.5).tolist()})" for k in (0, 1, 0)]
    hasty, calm = (planned(tmp_path, ur5, *lines, wait=wait) for wait in (0.1, 0.0))
    assert np.abs(hasty.q - HOME).max() == pytest.approx(0.5)
    assert len(calm.q) <= len(hasty.q) <= len(calm.q) + round(0.1 / 0.008) + 1


def test_a_blend_rounds_the_corner_within_its_radius(tmp_path: Path, ur5: Robot) -> None:
    corner, end = (0.0, 0.0, 0.15), (0.1, 0.1, 0.15)
    lines = [f"movej({HOME.tolist()})"]
    lines += [f"movel({pose(ur5, HOME, corner)}, r=0.03)", f"movel({pose(ur5, HOME, end)})"]
    round_one = planned(tmp_path, ur5, *lines)
    sharp = planned(tmp_path, ur5, *lines[:1], lines[1].replace(", r=0.03", ""), lines[2])
    nearest = []
    for motion in (round_one, sharp):
        position = flange(ur5, motion.q)[1]
        gaps = np.linalg.norm(position - flange(ur5, HOME)[1] - np.array(corner), axis=1)
        nearest.append(gaps.min())
        if motion is round_one:
            here = gaps.argmin()
            moving = np.linalg.norm(np.diff(position, axis=0), axis=1)[here - 5 : here + 5] / 0.008
            assert moving.min() > 0.05  # it does not stop
    assert 1e-3 < nearest[0] < 0.03
    assert nearest[1] < 1e-9
    np.testing.assert_allclose(round_one.q[-1], sharp.q[-1], atol=1e-9)
    # one sample of the sharp path is at the corner; the round one saves those with both moves near
    [at] = np.flatnonzero(gaps < 1e-9)
    near = min(np.count_nonzero(gaps[:at] < 0.03), np.count_nonzero(gaps[at + 1 :] < 0.03))
    assert len(sharp.q) - len(round_one.q) == near


def test_a_duration_wins_over_speed(tmp_path: Path, ur5: Robot) -> None:
    goal = (HOME + 0.3).tolist()
    motion = planned(tmp_path, ur5, f"movej({HOME.tolist()})", f"movej({goal}, t=2)")
    assert motion.duration() == pytest.approx(2.0, abs=0.01)


# What is refused


def test_a_line_through_a_singularity_is_refused(tmp_path: Path, ur5: Robot) -> None:
    """From the wrist turned one way to the wrist turned the other, and to a stretched arm."""
    wrist = np.array([0.5, -1.6, 1.6, -1.5, 0.4, 0.3])
    beyond = wrist * [1, 1, 1, 1, -1, 1]
    lines = [f"movej({wrist.tolist()})", f"movel({pose(ur5, beyond)})"]
    with pytest.raises(InputError, match=r"line 2: .* singularity at q = \("):
        planned(tmp_path, ur5, *lines)
    with pytest.raises(InputError, match=r"line 2: .* singularity"):
        planned(
            tmp_path, ur5, "movej([0, -1.5, 0.001, -1, 1, 0])", "movel(p[0.3, 0, 0.3, 0, 0, 0])"
        )


def test_a_line_to_another_posture_of_its_pose_is_refused(tmp_path: Path, ur5: Robot) -> None:
    start = f"movej({HOME.tolist()})"
    turned = HOME + np.array([0, 0, 0, 0, 0, 2 * np.pi])
    with pytest.raises(InputError, match=r"line 2: .* another posture"):
        planned(tmp_path, ur5, start, f"movel({turned.tolist()})")


def test_a_pose_out_of_reach_is_refused(tmp_path: Path, ur5: Robot) -> None:
    for kind in ("movej", "movel"):
        with pytest.raises(InputError, match=r"line 2: .* reach"):
            planned(tmp_path, ur5, f"movej({HOME.tolist()})", f"{kind}(p[2, 0, 0, 0, 0, 0])")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (THESIS, r"found 1 move\(s\)"),
        (f"{THESIS}\nmovec(p[0, 0, 0, 0, 0, 0])", "line 2: .* is no move"),
        (f"{THESIS}\nmovej([0, 0, 0])", "line 2: .* is no move"),
        (f"{THESIS}\nmovel(p[0, 0, 0])", "line 2: .* is no move"),
        (f"{THESIS}\nmovej([0, 0, 0, 0, 0, 0], v=0)", "line 2: .* is no move"),
        (f"{THESIS}\nmovej([0, 0, 0, 0, 0, 0], r=-1)", "line 2: .* is no move"),
        (f"sleep(1)\n{THESIS}", "line 1: .* is no move"),
        (f"{THESIS}\nsleep(-1)", "line 2: .* is no move"),
        ("movej(" + "(" * 300, "line 1: .* is no move"),
    ],
)
def test_a_file_that_is_no_program_is_refused(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "moves.txt"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        read_program(path)
