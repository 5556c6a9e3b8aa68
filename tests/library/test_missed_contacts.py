"""Contacts that the gate misses, and the band while it is shut."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from tests.library.made_up_torques import MODEL, PERIOD, PRIOR, free_run
from ur5lib.force.force_input import ForceInput
from ur5lib.force.missed_contacts import (
    largest_missed,
    missed_contacts,
    mixture_std,
    probability_while_shut,
)
from ur5lib.force.trial_contacts import largest_of_trials, try_contacts
from ur5lib.robots.description import Robot


def test_missed_contacts_are_those_whose_torque_is_hidden() -> None:
    """Weighing forces of the prior by exp(-z² / 2 κ²) gives their share and their variance."""
    random = np.random.default_rng(0)
    jacobian, hidden = random.normal(size=(1, 6, 6)), np.diag(random.uniform(1, 9, 6))[None]
    share, spread = missed_contacts(jacobian, hidden, PRIOR)
    for axis in range(3):
        force = PRIOR.force * random.normal(size=400_000)
        torque = force[:, None] * jacobian[0, axis]
        chance = np.exp(-(torque**2 / np.diag(hidden[0])).sum(axis=1) / 2)
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


@pytest.mark.parametrize("kappa", [1.0, 3.0])
def test_the_largest_missed_contact_is_learnt_from_trials(kappa: float) -> None:
    random = np.random.default_rng(1)
    size = random.uniform(0, 8, 5000)
    missed = random.uniform(size=5000) < np.exp(-(size**2) / (2 * kappa**2))
    assert largest_missed(size, missed, 1.0, 2.0) == pytest.approx(kappa, rel=0.05)
    assert largest_missed(size[:0], missed[:0], 1.0, 2.0) == pytest.approx(2.0, rel=1e-3)


def test_trial_contacts_of_a_blind_gate_are_all_missed(ur5: Robot) -> None:
    """A gate that finds nothing raises the size, one that finds each contact lowers it."""
    free = free_run(ur5, seed=90)
    segment = np.zeros(len(free.time), int)
    run = ForceInput(free.q, free.qd, free.torque, free.states, segment, PERIOD)
    for finds, low, high in ((0.0, 3.0, np.inf), (1.0, 0.0, 1.0)):
        known = run, free.jacobian, MODEL, PRIOR, np.random.default_rng(2)
        tried = try_contacts(lambda torque, f=finds: f * torque, *known)
        assert low < largest_of_trials([tried]) < high
    doubled = replace(MODEL, spread=2 * MODEL.spread)
    known = run, free.jacobian, doubled, PRIOR, np.random.default_rng(2)
    np.testing.assert_allclose(try_contacts(lambda t: t, *known).size, tried.size / 2)
