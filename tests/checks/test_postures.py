"""What postures at rest show of an arm."""

import re

import numpy as np
import pytest

from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.postures import what_gravity_shows
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
