"""Standard errors over recordings and over blocks within them."""

import numpy as np
import pytest
from scipy import stats

from ur5lib.identification.regression import (
    block_sums,
    draw_units,
    half_width,
    spread,
    standard_error,
)


def test_blocks_add_up_to_the_normal_equations() -> None:
    random = np.random.default_rng(0)
    columns, (curvature, pull) = random.normal(size=(30, 4)), random.normal(size=(2, 30))
    block = random.integers(0, 3, 30)
    sums = block_sums(columns, curvature, pull, block, 4)
    for one in range(4):
        own = block == one
        matrix = columns[own].T @ (columns[own] * curvature[own, None])
        np.testing.assert_allclose(sums[one, :, :4], matrix, atol=1e-12)
        np.testing.assert_allclose(sums[one, :, 4], columns[own].T @ pull[own], atol=1e-12)


def test_a_mean_over_units_has_the_error_of_its_units() -> None:
    """Of twelve recordings of ten blocks each that differ from one another, not within."""
    random = np.random.default_rng(1)
    unit = np.repeat(np.arange(12), 10)
    value = random.normal(size=12)[unit]
    counts = draw_units(unit, np.random.default_rng(2))
    means = (counts @ value / counts.sum(axis=1))[:, None]
    error = standard_error(means, 0 * means, 12)
    assert error[0] == pytest.approx(np.std(value[::10], ddof=1) / np.sqrt(12), rel=0.1)


def test_the_larger_spread_counts_and_few_units_widen_theirs() -> None:
    normal = np.random.default_rng(3).normal(size=(20_000, 1))
    for units, factor in ((1, 1.0), (2, np.sqrt(2)), (5, np.sqrt(5 / 4))):
        assert standard_error(normal, 0 * normal, units)[0] == pytest.approx(factor, rel=0.02)
    assert standard_error(normal, 3 * normal, 2)[0] == pytest.approx(3.0, rel=0.02)


def test_a_spread_is_a_standard_deviation_without_the_tails() -> None:
    values = np.random.default_rng(4).normal(0, [1.0, 5.0], (20_000, 2))
    np.testing.assert_allclose(spread(values), [1, 5], rtol=0.03)
    values[:1000] = 1e6
    np.testing.assert_allclose(spread(values), [1, 5], rtol=0.15)


@pytest.mark.parametrize(("units", "freedom"), [(1, 1), (2, 1), (3, 2), (30, 29)])
def test_an_interval_is_by_students_t(units: int, freedom: int) -> None:
    """One unit counts as two."""
    half = half_width(np.array([1.0, 2.0]), units)
    np.testing.assert_allclose(half, stats.t.ppf(0.975, freedom) * np.array([1.0, 2.0]))
