"""Targets of the virtual test stand: smooth, within limits, and as the real controller's."""

from pathlib import Path

import numpy as np
import pytest

from ur5lib.errors import InputError
from ur5lib.recordings.entries import ThesisFiles
from ur5lib.recordings.thesis_csv import read_thesis_csv
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.stand.plan import POSTURE, Fourier, Movej, Standstill
from ur5lib.stand.trajectories import INITIAL_REST, Targets, plan_targets, read_way_points
from ur5lib.tables import channel

TIME = np.arange(0, 20, 0.001)
HOME = (2.181661, -2.135061, -1.745329, 0.275936, -6.021385, 0.0)  # Figure 4.5
AWAY = tuple(np.deg2rad([45.7, -175, -20, -88, -240, 150]))
PLANS = {
    "fourier": Fourier(kind="fourier"),
    "long fourier": Fourier(kind="fourier", draw=7, harmonics=12, period_s=20),
    "movej": Movej(kind="movej", way_points=[HOME, AWAY]),
    "pauses": Movej(kind="movej", way_points=[HOME, AWAY, POSTURE], pause_s=0.5),
    "standstill": Standstill(kind="standstill"),
}


@pytest.fixture(params=PLANS)
def targets(request: pytest.FixtureRequest, ur5: Robot) -> Targets:
    return plan_targets(PLANS[request.param], ur5, TIME)


def test_targets_begin_at_rest(targets: Targets) -> None:
    before = TIME <= INITIAL_REST
    assert (targets.q[before] == targets.q[0]).all()
    assert np.abs(targets.qd[before]).max() < 1e-12
    assert np.abs(targets.qdd[TIME < INITIAL_REST]).max() < 1e-12


def test_targets_are_one_another_s_derivatives(targets: Targets) -> None:
    for values, slopes, bound in ((targets.q, targets.qd, 1e-3), (targets.qd, targets.qdd, 2e-3)):
        steps = np.diff(values, axis=0)
        assert np.abs(steps - 0.0005 * (slopes[1:] + slopes[:-1])).max() < bound * 1.5


@pytest.mark.parametrize("name", ["ur5", "ur10e"])
@pytest.mark.parametrize("draw", range(5))
def test_a_series_keeps_to_the_limits_and_uses_them(name: str, draw: int) -> None:
    robot = load_robot(robot_path(name))
    plan = Fourier(kind="fourier", draw=draw, limit_share=0.3)
    targets = plan_targets(plan, robot, TIME)
    speed = np.array(robot.velocity_limits())
    most = [np.abs(values).max(axis=0) for values in (targets.q - plan.posture, targets.qd)]
    shares = np.stack([most[0] / plan.amplitude_rad, most[1] / (0.3 * speed)])
    assert shares.max() < 1 + 1e-3
    np.testing.assert_allclose(shares.max(axis=0), 1, atol=0.05)
    np.testing.assert_allclose(targets.q[0], plan.posture, atol=1e-12)


def test_a_draw_is_a_trajectory_of_its_own(ur5: Robot) -> None:
    first, second = (plan_targets(Fourier(kind="fourier", draw=d), ur5, TIME) for d in (1, 2))
    assert abs(np.corrcoef(first.q.ravel() - POSTURE[0], second.q.ravel())[0, 1]) < 0.999
    assert np.abs(first.q - second.q).max() > 0.3


def test_moves_reach_their_way_points_with_joints_in_step(ur5: Robot) -> None:
    targets = plan_targets(PLANS["pauses"], ur5, TIME)
    for point in (HOME, AWAY, POSTURE):
        at = np.abs(targets.q - point).max(axis=1) < 1e-9
        assert at.sum() >= 500  # it pauses there
        assert not targets.qd[at][5:-5].any()
    assert np.abs(targets.qd).max() == pytest.approx(1.05, abs=1e-6)
    assert np.abs(targets.qdd).max() == pytest.approx(1.4, abs=1e-6)
    moving = np.abs(targets.qd[: round(3.5 / 0.001)]).max(axis=1) > 1e-3
    shares = targets.qd[: len(moving)][moving] / targets.qd[: len(moving), 5:][moving]
    assert np.ptp(shares, axis=0).max() < 1e-9


def test_a_short_move_never_comes_to_full_speed(ur5: Robot) -> None:
    near = (HOME[0] + 0.1, *HOME[1:])
    plan = Movej(kind="movej", way_points=[HOME, near], pause_s=1)
    targets = plan_targets(plan, ur5, TIME)
    assert np.abs(targets.qd).max() == pytest.approx((0.1 * 1.4) ** 0.5, rel=2e-3)
    assert targets.q[:, 0].max() == pytest.approx(near[0], abs=1e-12)


def test_way_points_that_are_all_the_same_are_a_standstill(ur5: Robot) -> None:
    targets = plan_targets(Movej(kind="movej", way_points=[HOME, HOME]), ur5, TIME)
    assert (targets.q == HOME).all()


def test_a_move_is_the_real_controller_s(thesis_data: Path, ur5: Robot) -> None:
    """The thesis's way-points at 60 deg/s and 80 deg/s², until the real one ends a move early."""
    folder = str(thesis_data / "Movement_No8_Singularity_Free_1")
    real = read_thesis_csv(ThesisFiles(format="thesis-csv", folder=folder)).robot.table
    start = 393  # the frame where its first long move begins, from where it stands
    q, qd = channel(real, "target_q")[start - 1 :], channel(real, "target_qd")[start:]
    plan = Movej(
        kind="movej",
        way_points=[tuple(q[0]), AWAY],
        speed_rad_s=np.deg2rad(60),
        acceleration_rad_s2=np.deg2rad(80),
    )
    time = real["time"].to_numpy()[start:] - real["time"].iloc[start] + INITIAL_REST
    targets = plan_targets(plan, ur5, time)
    assert np.abs(targets.q - q[1:])[:380].max() < 3e-4
    assert np.abs(targets.qd - qd)[:380].max() < 3e-4


def test_way_points_come_from_a_file(tmp_path: Path, ur5: Robot) -> None:
    path = tmp_path / "Singularity_Free.txt"
    lines = [f"movej([{', '.join(map(repr, map(float, point)))}])" for point in (HOME, AWAY)]
    path.write_text("\n".join(["", *lines, ""]))
    assert read_way_points(path) == [HOME, AWAY]
    read, given = (
        plan_targets(Movej(kind="movej", way_points=points), ur5, TIME)
        for points in (str(path), [HOME, AWAY])
    )
    np.testing.assert_array_equal(read.q, given.q)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("movej([0, 0, 0, 0, 0, 0])", r"found 1 way-point\(s\); give at least two"),
        ("movej([0, 0, 0, 0, 0, 0])\nmovel([0, 0, 0, 0, 0, 0])", "line 2: 'movel"),
        ("movej([0, 0, 0, 0, 0, nan])", "line 1: .*is not a way-point"),
    ],
)
def test_a_wrong_file_of_way_points_is_told(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "points.txt"
    path.write_text(text)
    with pytest.raises(InputError, match=words):
        read_way_points(path)
    with pytest.raises(InputError, match=r"nowhere\.txt cannot be read"):
        read_way_points(tmp_path / "nowhere.txt")
