"""Interpolation between samples, against that of scipy."""

import numpy as np
import pytest
from scipy.interpolate import PchipInterpolator

from ur5lib.timeseries.sampling import monotone


@pytest.mark.parametrize("count", [2, 3, 4, 500])
@pytest.mark.parametrize("rounded", [True, False])
def test_monotone_cubics_equal_those_of_scipy_to_the_bit(count: int, rounded: bool) -> None:
    """Rounded values give equal neighbours and many extrema, at the ends, too."""
    rng = np.random.default_rng(count)
    for _ in range(50):
        places = np.cumsum(rng.uniform(0.1, 3.0, count))
        values = rng.normal(size=(count, 6))
        values = values.round() if rounded else values
        at = np.concatenate([places, rng.uniform(places[0] - 1e-6, places[-1] + 1e-6, 100)])
        expected = PchipInterpolator(places, values, axis=0)(at)
        np.testing.assert_array_equal(monotone(at, places, values), expected)


def test_monotone_cubics_stay_between_their_neighbours() -> None:
    rng = np.random.default_rng(1)
    places, values = np.arange(100.0), rng.normal(size=(100, 2)).round(1)
    low, high = np.minimum(values[1:], values[:-1]), np.maximum(values[1:], values[:-1])
    for share in (0.01, 0.5, 0.99):
        between = monotone(places[:-1] + share, places, values)
        assert (low - 1e-12 <= between).all()
        assert (between <= high + 1e-12).all()
