"""What of a current nothing explains, where something touches the arm in some of the blocks."""

import numpy as np

from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.contacts import OUTLIER_DISTANCE, _unexplained_current


def test_a_touch_bends_the_fit_no_more_than_its_bounded_part() -> None:
    """The residual, cut at 1.5 standard deviations by the median, is orthogonal to each column, as
    of Huber's estimate; blocks without motion have no part in it.
    """
    random = np.random.default_rng(0)
    q, qd, qdd = random.normal(size=(3, 400, 6))
    gravity, touch, noise = random.normal(size=(3, 400))
    moving = np.arange(400) < 300
    push = np.where(np.arange(400) % 7 == 0, 8 + touch, 0.0) + np.where(moving, 0.0, 50.0)
    current = 2 * gravity[:, None] + 0.5 * qdd + (0.3 * noise + push)[:, None]
    means = BlockMeans(q, qd, qdd, None, {"actual_current": current})
    residual = _unexplained_current(means, gravity, 1, moving)[moving]
    limit = OUTLIER_DISTANCE * np.median(np.abs(residual)) / 0.6745
    assert 0.05 < np.mean(np.abs(residual) > limit) < 0.4
    cut = np.clip(residual, -limit, limit)
    for column in (gravity, *qdd.T, np.tanh(qd[:, 1] / 0.02), qd[:, 1], np.ones(400)):
        assert abs(np.mean(column[moving] * cut)) < 0.003
    assert np.median(residual[np.arange(300) % 7 == 0]) > 7.5
