"""Sizes of measured torques of an arm of which only the weight is known."""

import numpy as np
import pytest

from ur5lib.checks.block_means import BlockMeans
from ur5lib.checks.sensed_torques import size_ratio
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import link_frames
from ur5lib.timeseries.arrays import Array


def test_torques_are_compared_with_half_the_weight_in_equal_links(ur5: Robot) -> None:
    """Known here by the change of the links' potential energy with each joint."""
    arm = ur5.model_copy(update={"links": "unknown", "weight": 20.0})

    def energy(q: Array) -> Array:
        ends = link_frames(arm, q)[1]
        middles = (ends[:, 1:] + ends[:, :-1]) / 2
        return -10.0 / 6 * (middles @ np.array(arm.gravity)).sum(axis=1)

    q, steps = np.random.default_rng(0).uniform(-2, 2, (100, 6)), 1e-5 * np.eye(6)
    torque = np.stack([(energy(q + h) - energy(q - h)) / 2e-5 for h in steps], axis=1)
    means = BlockMeans(q, 0 * q, 0 * q, None, {"actual_torque": 3 * torque})
    assert size_ratio(means, arm) == pytest.approx(3.0, rel=1e-6)
