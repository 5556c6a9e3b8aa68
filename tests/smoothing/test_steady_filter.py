"""The steady Kalman filter."""

import numpy as np
import pytest
from scipy import signal
from scipy.linalg import solve_discrete_are

from ur5lib.smoothing.steady_filter import steady_filter


@pytest.mark.parametrize("drive", [1e-5, 1e-2, 10.0])
def test_innovations_are_those_of_the_riccati_equation(drive: float) -> None:
    """By scipy's solver and its conversion to transfer functions; and by plain recursion."""
    F = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]])
    Q = drive**2 * np.outer([1 / 6, 0.5, 1], [1 / 6, 0.5, 1])
    H, R = np.array([[1, 0, 0], [0, 0.7, -0.2]]), np.diag([1.0, 2.0])
    z = np.random.default_rng(0).normal(size=(500, 2))
    steady = steady_filter(F, Q, H, R)

    P = solve_discrete_are(F.T, H.T, Q, R)
    S = H @ P @ H.T + R
    K = F @ P @ H.T @ np.linalg.inv(S)
    np.testing.assert_allclose(steady.S, S, rtol=1e-9)
    assert (steady.poles.shape, steady.zeros.shape) == ((4,), (2, 2, 4))
    theirs = np.zeros_like(z)
    for index in (0, 1):
        zeros, poles = signal.ss2tf(F - K @ H, K, -H, np.eye(2), input=index)
        theirs += np.stack([signal.lfilter(row, poles, z[:, index]) for row in zeros], axis=1)
    np.testing.assert_allclose(steady.innovations(z), theirs, atol=1e-8)

    x = np.zeros(3)
    for measured, innovation in zip(z, steady.innovations(z), strict=True):
        np.testing.assert_allclose(innovation, measured - H @ x, atol=1e-8)
        x = F @ x + K @ (measured - H @ x)


def test_a_stack_of_filters_is_each_of_them() -> None:
    F = np.array([[1, 1, 0.5], [0, 1, 1], [0, 0, 1]])
    driven = np.array([[1 / 6], [0.5], [1]])
    Q = np.array([1e-5, 1e-2, 10.0])[:, None, None] ** 2 * (driven @ driven.T)
    H, R = np.array([[1, 0, 0], [0, 0.7, -0.2]]), np.diag([1.0, 2.0])
    z = np.random.default_rng(0).normal(size=(100, 2))
    for own, each in zip(Q, steady_filter(F, Q, H, R).each(), strict=True):
        alone = steady_filter(F, own, H, R)
        np.testing.assert_allclose(each.S, alone.S, rtol=1e-9)
        np.testing.assert_allclose(each.innovations(z), alone.innovations(z), atol=1e-8)
