"""The shares of samples within their bands, by speed."""

from itertools import pairwise

import numpy as np
import pytest

from ur5lib.identification.validation import MIN_SAMPLES, ShareBySpeed, share_by_speed

NOWHERE = (np.nan, np.nan)


def test_shares_of_each_range_of_speeds() -> None:
    speed = np.repeat([0.03, 0.3], 100)
    inside = np.arange(200) % 4 > 0
    found = share_by_speed(speed, inside)
    assert found.samples.sum() == 200
    np.testing.assert_allclose(found.share[np.isfinite(found.share)], [0.75, 0.75])
    few = share_by_speed(np.full(MIN_SAMPLES - 1, 0.3), np.ones(MIN_SAMPLES - 1, bool))
    assert np.isnan(few.suffices()).all()


def test_shares_are_those_of_each_bin_by_itself() -> None:
    random = np.random.default_rng(0)
    speed = np.exp(random.uniform(np.log(1e-3), np.log(3.0), 5000))
    inside = random.random(5000) < 0.8
    edges = [0.0, 0.005, 0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, np.inf]  # rad/s
    found = share_by_speed(speed, inside)
    for k, (low, high) in enumerate(pairwise(edges)):
        own = (speed >= low) & (speed < high)
        assert found.samples[k] == own.sum()
        assert found.share[k] == pytest.approx(inside[own].mean())


@pytest.mark.parametrize(
    ("share", "expected"),
    [
        ([0.2, 0.5, 0.6, 0.7, 0.95, 0.99, 0.98, 0.97, 0.96], (0.05, np.inf)),
        ([0.2, 0.5, 0.6, 0.7, 0.95, 0.99, 0.98, 0.97, 0.80], (0.05, 1.0)),
        ([0.2, np.nan, 0.6, 0.7, 0.95, np.nan, 0.98, np.nan, np.nan], (0.05, np.inf)),
        ([0.95, 0.2, 0.2, 0.2, 0.2, 0.95, 0.95, 0.95, 0.2], (0.1, 1.0)),
        ([0.1] * 9, NOWHERE),
        ([np.nan] * 9, NOWHERE),
    ],
)
def test_the_range_that_suffices(share: list[float], expected: tuple[float, float]) -> None:
    found = ShareBySpeed(np.array(share), np.full(9, 100.0)).suffices()
    np.testing.assert_array_equal(found, expected)
