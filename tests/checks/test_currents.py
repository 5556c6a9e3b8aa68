"""What currents leave unexplained, against scipy's least squares without negative coefficients."""

import numpy as np
from scipy.optimize import nnls

from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.currents import _unexplained_squares, least_squares_left
from ur5lib.robots.description import load_robot, robot_path


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


def test_a_current_is_explained_by_the_motion_that_its_target_follows() -> None:
    """Of joint 1, the current (row) is that of joint 2's motion (column)."""
    random = np.random.default_rng(0)
    q, qd, qdd, target, noise = random.normal(size=(5, 300, 6))
    current = target + 0.1 * noise
    current[:, 0] = target[:, 1] + 0.1 * noise[:, 0]
    currents = {"actual_current": current, "target_current": target}
    means = BlockMeans(q, qd, qdd, None, currents)
    left = _unexplained_squares(means, load_robot(robot_path("ur5")))
    np.testing.assert_array_equal(left.argmin(axis=1), [1, 1, 2, 3, 4, 5])
    assert left[0, 1] < 0.02
    assert left[1, 0] > 0.5
