"""External torque, joint states, and what is learned of the torque without contact."""

import json

import numpy as np
import pytest
from scipy import signal

from ur5lib.errors import InputError
from ur5lib.force.external_torque import (
    MOVING,
    RESTING,
    TURNING,
    at_rest,
    external_torque,
    joint_states,
    unbroken,
    without_edges,
)
from ur5lib.force.residual_model import ResidualModel, fit_residual_model

PERIOD = 0.02


def drift(count: int, std: np.ndarray, time_constant: float, seed: int) -> np.ndarray:
    """An Ornstein-Uhlenbeck process (count, 6)."""
    memory = np.exp(-PERIOD / time_constant)
    steps = np.random.default_rng(seed).normal(size=(count + 2000, 6)) * np.sqrt(1 - memory**2)
    return std * signal.lfilter([1], [1, -memory], steps, axis=0)[2000:]


def test_less_current_than_modelled_is_help_from_outside() -> None:
    """tau_ext = J^T F: the environment lifts, the motor needs less."""
    k = np.arange(1.0, 7)
    torque = external_torque(k, np.zeros((2, 6)), np.ones((2, 6)))
    np.testing.assert_array_equal(torque, [k, k])


def test_gaps_divide_and_edges_are_unknown() -> None:
    segment = np.array([0] * 10 + [1] * 5 + [2] * 3)
    assert unbroken(segment) == [slice(0, 10), slice(10, 15), slice(15, 18)]
    left = without_edges(np.ones((18, 6)), segment, 2)[:, 0]
    np.testing.assert_array_equal(np.flatnonzero(np.isfinite(left)), [2, 3, 4, 5, 6, 7, 12])


def test_a_joint_rests_only_when_it_has_rested_for_a_while() -> None:
    time = np.arange(0, 6, PERIOD)
    qd = np.zeros((len(time), 6))
    qd[time < 2, 0] = 1.0
    states = joint_states(qd, np.zeros(len(time), int), PERIOD)
    assert (states[time < 1.99, 0] == MOVING).all()
    assert (states[(time > 2.01) & (time < 2.95), 0] == TURNING).all()
    assert (states[time > 3.05, 0] == RESTING).all()
    assert (states[:, 1:] == RESTING).all()
    np.testing.assert_array_equal(at_rest(states), states[:, 0] == RESTING)


def test_a_gap_wakes_no_joint() -> None:
    qd = np.zeros((100, 6))
    qd[:50] = 1.0
    states = joint_states(qd, np.repeat([0, 1], 50), PERIOD)
    assert (states[50:] == RESTING).all()


def test_spread_change_and_rate_of_a_known_process() -> None:
    """An Ornstein-Uhlenbeck process grows by 1 - exp(-h / time constant) over a lag h."""
    std, time_constant = np.array([3.0, 4, 2, 1, 0.5, 0.7]), 4.0
    torque = drift(60000, std, time_constant, seed=3)
    states = np.full(torque.shape, MOVING)
    model = fit_residual_model([(torque, states)], PERIOD, cutoff=2.0)
    np.testing.assert_allclose(model.spread[MOVING], std, rtol=0.15)
    change = std * np.sqrt(1 - np.exp(-0.5 / time_constant))
    np.testing.assert_allclose(model.change[MOVING], change, rtol=0.15)
    assert 0.1 < model.rate[MOVING] < 0.35
    np.testing.assert_allclose(model.correlation, np.eye(6), atol=0.1)
    assert model.independent == 0.25


def test_each_state_has_its_own_and_joints_go_together() -> None:
    count = 20000
    torque = drift(count, np.ones(6), 0.1, seed=4)
    torque[:, 1] = 0.8 * torque[:, 0] + 0.6 * torque[:, 1]
    states = np.repeat([MOVING, RESTING], count // 2)[:, None] * np.ones(6, int)
    torque[count // 2 :] *= 5
    model = fit_residual_model([(torque, states)], PERIOD, cutoff=2.0)
    np.testing.assert_allclose(model.spread[RESTING] / model.spread[MOVING], 5, rtol=0.1)
    assert model.correlation[0, 1] == pytest.approx(0.8, abs=0.05)
    covariance = model.covariance(model.spread, states[:1])
    np.testing.assert_allclose(covariance[0], covariance[0].T)
    assert np.linalg.eigvalsh(covariance[0]).min() > 0


def test_a_state_never_seen_is_the_least_certain() -> None:
    torque = drift(2000, np.ones(6), 1.0, seed=5)
    model = fit_residual_model([(torque, np.zeros(torque.shape, int))], PERIOD, cutoff=2.0)
    np.testing.assert_array_equal(model.spread[RESTING], model.spread[MOVING])


def test_no_difference_is_taken_across_a_gap() -> None:
    """Two quiet stretches far apart are quiet, not a jump."""
    states = np.zeros((500, 6), int)
    quiet = drift(500, np.full(6, 0.1), 1.0, seed=6)
    model = fit_residual_model([(quiet, states), (quiet + 50, states)], PERIOD, cutoff=2.0)
    assert (model.change[MOVING] < 0.2).all()


def test_too_short_recordings_are_told() -> None:
    with pytest.raises(InputError, match="2 s"):
        fit_residual_model([(np.zeros((20, 6)), np.zeros((20, 6), int))], PERIOD, cutoff=2.0)


def test_a_model_survives_json() -> None:
    torque = drift(2000, np.ones(6), 1.0, seed=7)
    model = fit_residual_model([(torque, np.zeros(torque.shape, int))], PERIOD, cutoff=2.0)
    again = ResidualModel.from_dict(json.loads(json.dumps(model.to_dict())))
    for name, value in vars(model).items():
        np.testing.assert_array_equal(getattr(again, name), value)
