"""Robust regression by consensus: quiet stretches, candidates, agreement."""

import numpy as np
import pytest

from ur5lib.force.free_fit import agreement, candidates, quiet_stretches, random_subset

PERIOD = 0.01
SCALE = np.array([0.1] * 3 + [0.01] * 3)


def restless(levels: list[float]) -> np.ndarray:
    """Stretches of 0.1 s, each with its number as mean, and shaking by its level on all axes."""
    shake = np.where(np.arange(10) % 2, 1.0, -1.0)
    parts = [k + level * shake[:, None] * SCALE for k, level in enumerate(levels)]
    return np.concatenate(parts)


def test_the_quieter_half_of_the_stretches_is_found() -> None:
    """Rounded up, in order of their unrest; what is left at the end is no stretch."""
    reading = np.concatenate([restless([5, 1, 4, 2, 3]), np.zeros((9, 6))])
    middle, means, noise = quiet_stretches(reading, PERIOD, SCALE)
    np.testing.assert_array_equal(middle, [15, 35, 45])
    np.testing.assert_allclose(means, np.repeat([[1.0], [3.0], [4.0]], 6, axis=1))
    np.testing.assert_allclose(noise, 2 * SCALE)


def test_a_stretch_that_was_not_measured_is_not_quiet() -> None:
    reading = restless([1, 2, 3, 4])
    reading[5] = np.nan
    np.testing.assert_array_equal(quiet_stretches(reading, PERIOD, SCALE)[0], [15, 25])
    middle, means, noise = quiet_stretches(np.full((40, 6), np.nan), PERIOD, SCALE)
    assert (len(middle), len(means)) == (0, 0)
    np.testing.assert_array_equal(noise, np.zeros(6))


def test_components_are_compared_in_their_own_units() -> None:
    """A moment that shakes by 0.05 Nm is as restless as a force by 0.5 N."""
    reading = np.zeros((40, 6))
    for part, (axis, size) in enumerate([(5, 0.05), (0, 0.4), (1, 0.6), (4, 0.03)]):
        reading[10 * part : 10 * part + 10, axis] = size * (-1.0) ** np.arange(10)
    np.testing.assert_array_equal(quiet_stretches(reading, PERIOD, SCALE)[0], [35, 15])


def test_at_a_low_rate_a_stretch_is_of_two_samples() -> None:
    middle, means, _ = quiet_stretches(np.arange(24.0).reshape(4, 6), 0.2, SCALE)
    np.testing.assert_array_equal(middle, [1])
    np.testing.assert_array_equal(means, [[3, 4, 5, 6, 7, 8]])


@pytest.mark.parametrize(("count", "found"), [(0, 0), (7, 7), (600, 600), (900, 600)])
def test_each_stretch_is_a_candidate_up_to_six_hundred(count: int, found: int) -> None:
    """Where one determines the parameters."""
    reading = np.random.default_rng(0).normal(size=(count, 6))
    terms = np.tile(np.eye(6), (count, 1, 1))
    tried = candidates(terms, reading, SCALE, together=1)
    assert tried.shape == (found, 6)
    assert {tuple(row) for row in np.round(tried, 9)} <= {tuple(r) for r in np.round(reading, 9)}
    assert len(np.unique(tried, axis=0)) == found


def test_three_stretches_together_determine_what_one_does_not() -> None:
    """Each tells six of eight parameters; all together tell the truth, without noise."""
    random = np.random.default_rng(1)
    terms, truth = random.normal(size=(20, 6, 8)), random.normal(size=8)
    tried = candidates(terms, terms @ truth, SCALE, together=3)
    assert tried.shape == (600, 8)
    assert np.mean(np.abs(tried - truth).max(axis=1) < 1e-6) > 0.9


def test_what_agrees_does_so_in_all_components() -> None:
    reading = np.zeros((4, 6))
    reading[1, 0], reading[2, 0], reading[3, 5] = 0.1, 0.11, -0.02
    agrees = agreement(np.zeros((1, 6)), np.tile(np.eye(6), (4, 1, 1)), reading, SCALE)
    np.testing.assert_array_equal(agrees, [[True, True, False, False]])


def test_a_draw_is_of_different_values_and_always_the_same() -> None:
    values = np.arange(100, 200)
    chosen = random_subset(values, 30)
    assert len(np.unique(chosen)) == 30
    assert np.isin(chosen, values).all()
    np.testing.assert_array_equal(chosen, random_subset(values, 30))
    np.testing.assert_array_equal(random_subset(values, 100), values)
