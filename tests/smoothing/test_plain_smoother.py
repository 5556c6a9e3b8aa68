"""The plain smoother of encoders: what it must find, and that it tunes itself."""

import numpy as np
import pytest
from filterpy.common import Q_discrete_white_noise
from filterpy.kalman import KalmanFilter

from ur5lib.smoothing import plain_smoother
from ur5lib.smoothing.plain_smoother import smooth_plainly, white_noise
from ur5lib.timeseries.arrays import Array

PERIOD = 0.008
NOISE = np.repeat([3e-5, 3e-3], 6)  # rad, rad/s


def driven(jerk: float, count: int, seed: int = 0) -> tuple[Array, Array, Array]:
    """Measured q and q̇, and true q̈ (N, 6), of accelerations that a white jerk changes."""
    random = np.random.default_rng(seed)
    qdd = np.cumsum(jerk * PERIOD * random.normal(size=(count, 6)), axis=0)
    qd = np.cumsum(qdd, axis=0) * PERIOD
    z = np.hstack([np.cumsum(qd, axis=0) * PERIOD, qd]) + NOISE * random.normal(size=(count, 12))
    return z[:, :6], z[:, 6:], qdd


def one_segment(count: int) -> Array:
    return np.zeros(count, np.int64)


def test_a_constant_acceleration_is_found() -> None:
    time = PERIOD * np.arange(400)[:, None]
    qdd = np.array([0.5, -1.0, 2.0, 0.0, 0.1, -0.3])
    found = smooth_plainly(one_segment(400), qdd * time**2 / 2, qdd * time, PERIOD)
    np.testing.assert_allclose(found.qdd[50:], np.tile(qdd, (350, 1)), atol=1e-6)
    np.testing.assert_allclose(found.qd[50:], (qdd * time)[50:], atol=1e-6)


def test_the_noise_is_that_of_the_measurements() -> None:
    z = np.hstack(driven(1.0, 5000)[:2])
    np.testing.assert_allclose(white_noise(z, one_segment(5000)), NOISE, rtol=0.05)
    z[1000:] += 1.0  # what lies between two segments is no noise
    apart = np.repeat([0, 1], [1000, 4000])
    np.testing.assert_allclose(white_noise(z, apart), NOISE, rtol=0.05)


@pytest.mark.parametrize("jerk", [10.0, 100.0, 1000.0])
def test_it_takes_the_most_likely_jerk(jerk: float, monkeypatch: pytest.MonkeyPatch) -> None:
    q, qd, _ = driven(jerk, 600)
    found = smooth_plainly(one_segment(600), q, qd, PERIOD).qdd
    monkeypatch.setattr(plain_smoother, "CANDIDATE_JERKS", (jerk,))
    np.testing.assert_array_equal(found, smooth_plainly(one_segment(600), q, qd, PERIOD).qdd)


def test_segments_are_filtered_on_their_own() -> None:
    q, qd, _ = driven(100.0, 400)
    both = smooth_plainly(np.repeat([0, 1], 400), np.tile(q, (2, 1)), np.tile(qd, (2, 1)), PERIOD)
    np.testing.assert_array_equal(both.qdd[:400], both.qdd[400:])


def test_missing_samples_are_bridged() -> None:
    q, qd, _ = driven(100.0, 400)
    q[200:205], qd[200:205] = np.nan, np.nan
    found = smooth_plainly(one_segment(400), q, qd, PERIOD)
    np.testing.assert_allclose(np.diff(found.qd[199:206], axis=0), found.qdd[200:206] * PERIOD)
    assert (found.qdd[200:205] != found.qdd[199]).all()


def test_the_way_back_is_that_of_a_linear_filter(monkeypatch: pytest.MonkeyPatch) -> None:
    """filterpy smooths that one, with a covariance for each sample."""
    monkeypatch.setattr(plain_smoother, "CANDIDATE_JERKS", (100.0,))
    q, qd, qdd = driven(100.0, 400)
    z, found = np.hstack([q, qd]), smooth_plainly(one_segment(400), q, qd, PERIOD)
    linear, noise = KalmanFilter(18, 12), white_noise(z, one_segment(400))
    step = np.array([[1, PERIOD, PERIOD**2 / 2], [0, 1, PERIOD], [0, 0, 1]])
    linear.F, linear.H, linear.R = np.kron(step, np.eye(6)), np.eye(12, 18), np.diag(noise**2)
    linear.Q = Q_discrete_white_noise(3, PERIOD, (100.0 * PERIOD) ** 2, 6, order_by_dim=False)
    linear.x, linear.P = np.zeros(18), np.diag(plain_smoother.INITIAL_STD**2)
    forwards, covariances, *_ = linear.batch_filter(z, update_first=True)
    smoothed = linear.rts_smoother(forwards, covariances)[0]
    np.testing.assert_allclose(found.qdd, smoothed[:, 12:], atol=1e-6)
    forward_error, error = (np.std(own - qdd) for own in (forwards[:, 12:], found.qdd))
    assert error < 0.8 * forward_error
