"""Contacts that the gate misses, and the band while it is shut."""

import numpy as np
import pytest
from scipy.stats import norm

from tests.made_up_torques import PERIOD, PRIOR
from ur5lib.force.missed_contacts import missed_contacts, mixture_std, probability_while_shut


def test_missed_contacts_are_those_whose_torque_is_hidden() -> None:
    """Weighing forces of the prior by exp(-z² / 2 κ²) gives their share and their variance."""
    random = np.random.default_rng(0)
    jacobian, hidden = random.normal(size=(1, 6, 6)), random.uniform(1, 9, (1, 6))
    share, spread = missed_contacts(jacobian, hidden, PRIOR)
    for axis in range(3):
        force = PRIOR.force * random.normal(size=400_000)
        torque = force[:, None] * jacobian[0, axis]
        chance = np.exp(-(torque**2 / hidden[0]).sum(axis=1) / 2)
        assert chance.mean() == pytest.approx(share[0, axis], rel=0.02)
        variance = (chance * force**2).sum() / chance.sum()
        assert variance == pytest.approx(spread[0, axis], rel=0.03)


def test_a_mixtures_band_is_between_those_of_its_parts() -> None:
    chance = np.array([[0.0], [0.03], [0.3], [1.0]])
    missed, free = np.full((4, 1), 100.0), np.ones(1)
    half = 1.96 * mixture_std(chance, missed, free)[:, 0]
    outside = chance[:, 0] * 2 * norm.sf(half / 10) + (1 - chance[:, 0]) * 2 * norm.sf(half)
    np.testing.assert_allclose(outside, 0.05, rtol=1e-3)
    np.testing.assert_allclose(half[[0, 3]], [1.96, 19.6], rtol=1e-3)
    assert (np.diff(half) > 0).all()


def test_a_gate_that_misses_none_leaves_no_contact() -> None:
    found = np.arange(50_000) < 15_000
    none, half, all_ = (
        probability_while_shut(np.full((50_000, 6), missed), found, PERIOD, PRIOR)[0, 0]
        for missed in (0.0, 0.5, 1.0)
    )
    assert none == 0
    # with half of the contacts missed, they fill 0.6 of the time, and half of that is left
    assert half == pytest.approx(0.3 / 0.7, rel=0.02)
    assert all_ > half


def test_moments_say_nothing_about_the_time_in_contact() -> None:
    """Contacts are forces: how many are missed follows from the first three columns."""
    found = np.arange(50_000) < 15_000
    missed = np.full((2, 50_000, 6), 0.5)
    missed[1, :, 3:] = [0.0, 0.9, 1.0]
    one, other = (probability_while_shut(each, found, PERIOD, PRIOR)[0, :3] for each in missed)
    np.testing.assert_array_equal(one, other)
