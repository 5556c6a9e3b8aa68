"""What postures at rest show of an arm."""

import re

import numpy as np
import pytest

from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.currents import MAX_CONSTANT_RATIO
from ur5lib.checks.postures import large_constants, posture_stop_signs, what_gravity_shows
from ur5lib.robots.description import Robot


def test_gravity_explains_the_share_of_its_regression(ur5: Robot) -> None:
    """Of each joint's current, with any factor and offset."""
    random = np.random.default_rng(0)
    q = random.uniform(-2, 2, (100, 6))
    gravity = BlockMeans(q, 0 * q, 0 * q, None, {}).gravity(ur5)
    current = gravity / 10 + 1.0 + random.normal(0, 0.5, q.shape)
    means = BlockMeans(q, 0 * q, 0 * q, None, {"actual_current": current}, offset=True)
    (note,) = what_gravity_shows(means, ur5, None)
    shares = re.findall(r"joint (\d): (\d+)%", note.detail)
    assert len(shares) >= 2
    for joint, share in shares:
        x, y = gravity[:, int(joint) - 1], current[:, int(joint) - 1]
        left = y - np.polyval(np.polyfit(x, y, 1), x)
        assert int(share) == pytest.approx(100 * (1 - left.var() / y.var()), abs=0.51)


@pytest.mark.parametrize(
    ("ratio", "small", "large"),
    [
        (1.02 / MAX_CONSTANT_RATIO, False, False),
        (0.98 / MAX_CONSTANT_RATIO, True, False),
        (1.0, False, False),
        (0.98 * MAX_CONSTANT_RATIO, False, False),
        (1.02 * MAX_CONSTANT_RATIO, False, True),
    ],
)
def test_a_constant_contradicts_the_known_one_by_a_factor(
    ur5: Robot, ratio: float, small: bool, large: bool
) -> None:
    """A smaller one stops, a larger one, of a current that lacks torque, is warned of."""
    random = np.random.default_rng(0)
    q, noise = random.uniform(-2, 2, (100, 6)), random.normal(0, 1e-3, (100, 6))
    still = BlockMeans(q, 0 * q, 0 * q, None, {}, offset=True, independent=1.0)
    known = np.array(ur5.family_torque_constants())
    own = known * np.where(np.arange(6) == 2, ratio, 1.0)
    means = still.with_efforts(still.gravity(ur5) / own + 0.3 + noise)
    stops = [one.detail for one in posture_stop_signs(means, ur5, None, None)]
    warned = [one.detail for one in large_constants(means, ur5)]
    assert (len(stops), len(warned)) == (small, large)
    words = f"joint 3 with {own[2]:.3g} instead of {known[2]:.3g} Nm/A"
    assert all(words in one for one in [*stops, *warned])
