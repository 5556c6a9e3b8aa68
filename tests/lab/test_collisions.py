"""Capsules around an arm: distances, their gradients, and what stands around it."""

import numpy as np

from ur5lab.collisions import Box, Capsules, Surroundings, collisions
from ur5lib.robots.description import Robot

CELL = Surroundings(table=0.0, boxes=[Box(center=(0.5, 0.0, 0.3), size=(0.2, 0.3, 0.2))])
REACH = 0.1  # m


def test_gradients_of_distances_are_those_of_finite_differences(ur5: Robot) -> None:
    capsules, step = Capsules(ur5, CELL, REACH), 1e-6
    q = np.random.default_rng(1).uniform(-2, 2, (100, 6))
    near, compared = capsules.near(q, gradient_below=REACH), set()
    for sample, gradient, pair in zip(near.sample, near.gradient, near.pairs, strict=True):
        if (near.sample == sample).sum() == 1:
            ends = [capsules.near(q[sample] + sign * step * np.eye(6)) for sign in (-1, 1)]
            if all(end.pairs == [pair] * 6 for end in ends):
                slopes = (ends[1].distance - ends[0].distance) / (2 * step)
                np.testing.assert_allclose(gradient, slopes, atol=1e-6)
                compared.add(pair)
    assert {"table", "box_1"} & {name for pair in compared for name in pair}


def test_only_what_is_within_reach_is_near(ur5: Robot) -> None:
    q = np.random.default_rng(2).uniform(-2, 2, (100, 6))
    distance = Capsules(ur5, CELL, REACH).near(q).distance
    assert distance.max() < REACH
    closer = Capsules(ur5, CELL, REACH / 2).near(q).distance
    np.testing.assert_allclose(np.sort(closer), np.sort(distance[distance < REACH / 2]))


def test_an_arm_that_reaches_down_hits_the_table(ur5: Robot) -> None:
    path = np.array([[0.0, -1.6, 1.6, -1.5, 1.5, 0.0], [0.0, 0.3, 0.3, 0.0, 1.5, 0.0]])
    assert {sample for sample, *parts in collisions(ur5, path, 0.0) if "table" in parts} == {1}
    assert not any("table" in parts for _, *parts in collisions(ur5, path, None))
