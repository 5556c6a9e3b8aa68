"""The momentum observer, on motions whose external torque is known."""

import numpy as np
import pytest

from ur5lib.dynamics.link_model import LinkModel
from ur5lib.robots.description import Robot
from ur5rivals.estimators.momentum_observer import observe
from ur5rivals.momentum import momentum_rate

PERIOD = 0.004
TIME = np.arange(0, 6, PERIOD)[:, None]
PUSH = np.exp(-(((TIME - 3) / 0.4) ** 2)) * np.array([20.0, -15, 10, 3, -2, 1])
ONE = np.zeros(len(TIME), int)


@pytest.fixture(scope="module")
def arm(ur5: Robot) -> LinkModel:
    return LinkModel(ur5.mounted([0, 0, 0]), "C+rotors")


def swing() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    rate = np.linspace(0.8, 2.0, 6)
    angle = rate * TIME + np.arange(6.0)
    return np.sin(angle), rate * np.cos(angle), -(rate**2) * np.sin(angle)


def observed(arm: LinkModel, segment: np.ndarray, bandwidth: float) -> np.ndarray:
    """Of an arm that swings and is pushed."""
    q, qd, qdd = swing()
    known = momentum_rate(arm, q, qd, qdd, PUSH)
    return observe(arm.momentum(q, qd), known, segment, PERIOD, bandwidth)


def test_the_rate_without_contact_is_that_of_motors_and_gravity(ur5: Robot, arm: LinkModel) -> None:
    """As published: τ_m + Cᵀ q̇ - g, whatever the acceleration."""
    q, qd, qdd = swing()
    heavy = LinkModel(ur5, "C+rotors")
    motor = heavy.inverse_dynamics(q, qd, qdd) - PUSH
    published = motor + heavy.coriolis_torque(q, qd) - heavy.gravity_torque(q)
    np.testing.assert_allclose(momentum_rate(arm, q, qd, qdd, PUSH), published, atol=1e-9)


def test_the_push_is_seen_and_nothing_else(arm: LinkModel) -> None:
    torque = observed(arm, ONE, bandwidth=8.0)
    np.testing.assert_allclose(torque, PUSH, atol=0.02 * np.abs(PUSH).max())


def test_a_torque_that_swings_at_the_bandwidth_is_halved() -> None:
    """By 3 dB on the way forwards and on the way back."""
    angle = 2 * np.pi * 2.0 * TIME
    momentum = (1 - np.cos(angle)) / (2 * np.pi * 2.0) * np.ones(6)
    torque = observe(momentum, np.zeros_like(momentum), ONE, PERIOD, bandwidth=2.0)
    inside = slice(500, 1000)
    np.testing.assert_allclose(
        torque[inside].std(axis=0), np.sin(angle)[inside].std() / 2, rtol=0.03
    )


def test_a_gap_divides_the_run(arm: LinkModel) -> None:
    segment = np.repeat([0, 1], len(TIME) // 2)
    torque = observed(arm, segment, bandwidth=8.0)
    alone = observed(arm, ONE, bandwidth=8.0)
    assert np.isfinite(torque).all()
    np.testing.assert_allclose(torque[:500], alone[:500], atol=1e-3)


def test_missing_rows_stay_missing() -> None:
    momentum = np.zeros((100, 6))
    momentum[40] = np.nan
    torque = observe(momentum, np.ones((100, 6)), np.zeros(100, int), PERIOD, 2.0)
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(torque[:, 0])), [40])


@pytest.mark.parametrize(("count", "told"), [(4, False), (5, True)])
def test_a_stretch_of_four_samples_tells_nothing(count: int, told: bool) -> None:
    """Its filter needs four steps; of a steady push of 2 Nm it then tells that."""
    segment = np.repeat([0, 1, 2], [10, count, 10])
    momentum = 3.0 * PERIOD * np.arange(len(segment))[:, None] * np.ones(6)
    torque = observe(momentum, np.ones((len(segment), 6)), segment, PERIOD, 2.0)
    np.testing.assert_allclose(torque[segment == 1], 2.0 if told else np.nan)
    np.testing.assert_allclose(torque[segment != 1], 2.0)
