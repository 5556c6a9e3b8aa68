"""What currents leave unexplained, against scipy's least squares without negative coefficients."""

import numpy as np
from scipy.optimize import nnls

from ur5lib.checks.currents import least_squares_left


def test_what_is_left_equals_that_of_scipy() -> None:
    """With columns of zeros, two that are alike, and coefficients held at their bound."""
    rng, bound = np.random.default_rng(1), 0
    for k in range(30):
        positive, free = rng.normal(size=(50, 3)), rng.normal(size=(50, 1 + k % 2))
        positive[:, 2] = [0 * positive[:, 0], positive[:, 1], positive[:, 2]][k % 3]
        values = rng.normal(size=(50, 6)) + positive @ rng.normal(size=(3, 6))
        both = np.column_stack([positive, free, -free])
        found = [nnls(both, column) for column in values.T]
        expected = [size**2 / 50 for _, size in found]
        bound += sum((coefficients[:3] == 0).any() for coefficients, _ in found)
        np.testing.assert_allclose(least_squares_left(positive, free, values), expected, rtol=1e-9)
    assert bound > 60
