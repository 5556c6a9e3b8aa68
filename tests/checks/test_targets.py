"""Currents that are a fraction or a multiple of their targets, where a joint bears something."""

import numpy as np
import pytest

from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.targets import scaled_currents, unlike_targets

RANDOM = np.random.default_rng(0)


@pytest.mark.parametrize(
    ("constant", "swing", "moving", "told"),
    [
        (1.5, 0.0, True, True),  # a load that is borne in motion
        (0.7, 0.0, True, False),
        (0.0, 1.1, True, True),
        (0.0, 0.9, True, False),
        (1.5, 0.0, False, False),
        (1.5, 1.1, False, True),  # at rest, where others change the load
        (1.5, 0.9, False, False),
    ],
)
def test_a_target_tells_of_an_ampere_that_is_borne(
    constant: float, swing: float, moving: bool, told: bool
) -> None:
    """In motion the whole of it, at rest what changes; the ratio is that of the two currents."""
    q, qd, qdd = RANDOM.normal(size=(3, 400, 6))
    qd[:, 1] *= moving
    load = np.sqrt(2) * np.sin(np.arange(400))
    target, friction = np.zeros((2, 400, 6))
    target[:, 1] = constant + swing * load
    friction[:, 1] = 0.5 * np.tanh(qd[:, 1] / 0.02) + 0.1 * qdd[:, 1]
    currents = {"actual_current": 3.0 * target + friction, "target_current": target}
    means = BlockMeans(q, qd, qdd, None, currents)
    assert dict(unlike_targets(means)) == ({1: pytest.approx(3.0, abs=1e-6)} if told else {})
    for odd in ((), (0,)):
        assert [one.joints for one in scaled_currents(means, odd)] == [(2,)] * told
    assert [*scaled_currents(means, odd={1})] == []
