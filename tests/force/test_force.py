"""From a sensor to the wrench on the arm, and how its errors are measured."""

import numpy as np
import pytest

from ur5lib.force.plain_least_squares import plain_least_squares
from ur5lib.force.sensor import move_to_frame_6, wrench_of_environment
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics
from ur5lib.timeseries.metrics import (
    correlation,
    coverage,
    interval_score,
    largest_error,
    mean_absolute_error,
    skill,
    slope,
    zero_interval_score,
)

RANDOM = np.random.default_rng(0)


def rotations(count: int) -> np.ndarray:
    return np.linalg.qr(RANDOM.normal(size=(count, 3, 3)))[0]


def test_plain_least_squares_gives_the_wrench_back(ur5: Robot) -> None:
    """But for what a singular posture hides, which is zero there."""
    J = flange_kinematics(ur5, RANDOM.uniform(-3, 3, (200, 6)))[2]
    wrench = RANDOM.normal(size=(200, 6))
    estimate = plain_least_squares(np.matvec(J.mT, wrench), J, 0.05)
    seen = np.linalg.svd(J, compute_uv=False)[:, -1] > 0.05
    np.testing.assert_allclose(estimate[seen], wrench[seen], rtol=1e-7, atol=1e-9)
    assert (np.linalg.norm(estimate, axis=1) <= np.linalg.norm(wrench, axis=1) + 1e-9).all()


def test_plain_least_squares_leave_out_what_no_joint_feels() -> None:
    """A direction of less than the smallest singular value has no force, the others their own."""
    jacobian = np.diag([2.0, 3.0, 0.5, 1.0, 0.02, 1.0])[None]
    torque = np.array([[4.0, 6.0, 1.0, 3.0, 5.0, -2.0]])
    found = plain_least_squares(torque, jacobian, 0.05)
    np.testing.assert_allclose(found, [[2.0, 2.0, 2.0, 3.0, 0.0, -2.0]], atol=1e-12)


def test_a_reading_is_turned_into_base_axes() -> None:
    """Equation 6.11, without its minus: the environment acting on the arm."""
    rotation = rotations(20)
    force, moment = RANDOM.normal(size=(20, 3)), RANDOM.normal(size=(20, 3))
    reading = np.concatenate(
        [np.einsum("nji,nj->ni", rotation, half) for half in (force, moment)], axis=1
    )
    np.testing.assert_allclose(
        wrench_of_environment(reading, rotation),
        np.concatenate([force, moment], axis=1),
        atol=1e-12,
    )


def test_a_moved_wrench_does_the_same_work() -> None:
    """Power of a wrench on a turning body does not depend on where the wrench is told."""
    rotation, position = rotations(20), np.array([0.01, -0.02, 0.0286])
    wrench, twist = RANDOM.normal(size=(20, 6)), RANDOM.normal(size=(20, 6))
    velocity, omega = twist[:, :3], twist[:, 3:]
    at_sensor = np.concatenate([velocity + np.cross(omega, rotation @ position), omega], axis=1)
    moved = move_to_frame_6(wrench, rotation, position)
    np.testing.assert_allclose((moved * twist).sum(1), (wrench * at_sensor).sum(1))


# Errors


def test_errors_count_only_what_both_know() -> None:
    reference = np.array([[1.0], [2.0], [np.nan], [4.0]])
    estimate = np.array([[2.0], [np.nan], [5.0], [1.0]])
    assert mean_absolute_error(estimate, reference) == pytest.approx(2.0)
    assert largest_error(estimate, reference) == pytest.approx(3.0)


def test_correlation_does_not_see_scale_and_offset() -> None:
    x = RANDOM.normal(size=(100, 2))
    np.testing.assert_allclose(correlation(3 * x + 1, x), 1.0)
    np.testing.assert_allclose(correlation(-x, x), -1.0)
    np.testing.assert_allclose(
        correlation(x, x[::-1]), [np.corrcoef(x[:, i], x[::-1, i])[0, 1] for i in (0, 1)]
    )
    assert np.isnan(correlation(np.ones((9, 1)), x[:9, :1])).all()


def test_skill_compares_with_saying_nothing() -> None:
    reference = np.array([[2.0], [-2.0], [np.nan], [4.0]])
    assert skill(reference, reference) == pytest.approx(1)
    assert skill(np.zeros((4, 1)), reference) == pytest.approx(0)
    assert skill(-reference, reference) == pytest.approx(-1)


def test_the_slope_is_what_an_estimate_shows_of_each_force() -> None:
    x = RANDOM.normal(3, 1, size=(50, 2))
    np.testing.assert_allclose(slope(0.7 * x, x), 0.7)
    beside = np.where(np.arange(50)[:, None] < 10, np.nan, 0.7 * x)
    np.testing.assert_allclose(slope(beside, x), 0.7)
    assert np.isnan(slope(x, np.zeros_like(x))).all()


@pytest.mark.parametrize("stated", [0.5, 0.8, 0.95])
def test_a_true_band_covers_what_it_states(stated: float) -> None:
    reference = np.random.default_rng(1).normal(0, 2, size=(20000, 1))
    estimate, std = np.zeros_like(reference), np.full_like(reference, 2.0)
    assert coverage(estimate, std, reference, stated) == pytest.approx(stated, abs=0.01)
    assert coverage(estimate, std / 2, reference, stated) < stated - 0.1


def test_no_other_band_scores_better_than_the_true_one() -> None:
    reference = np.random.default_rng(1).normal(0, 2, size=(20000, 1))
    zero = np.zeros_like(reference)
    scores = [interval_score(zero, np.full_like(reference, std), reference)[0] for std in (1, 2, 4)]
    assert scores[1] < min(scores[0], scores[2])
    assert interval_score(zero + 1, zero + 2, reference)[0] > scores[1]


def test_the_score_is_the_width_where_all_is_held() -> None:
    reference = RANDOM.normal(size=(100, 2))
    wide = np.full_like(reference, 100.0)
    np.testing.assert_allclose(
        interval_score(reference, wide, reference), 2 * 1.96 * 100, rtol=1e-4
    )


def test_the_band_around_zero_holds_what_it_states() -> None:
    """95 of 100 references are 1, five are 3: a width of 2, and 40 times 5 misses of 2 in 100."""
    reference = np.concatenate([np.ones(951), np.full(49, 3.0)])[:, None]
    expected = 2 + 40 * 2 * 49 / 1000
    assert zero_interval_score(reference)[0] == pytest.approx(expected)
