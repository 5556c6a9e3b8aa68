"""The force on a resting arm without any fit: exact without errors, inside its band with them."""

import numpy as np
import pytest

from ur5lib.force.contact_wrench import BREAKAWAY, SLOW, at_rest, static_wrench, torque_std

TORQUE_MAX = np.array([150.0, 150.0, 150.0, 28.0, 28.0, 28.0])


def jacobians(count: int) -> np.ndarray:
    """Regular Jacobians of an arm of 0.8 m, (count, 6, 6)."""
    rng = np.random.default_rng(1)
    linear = rng.normal(size=(count, 3, 6)) * np.array([0.5, 0.5, 0.4, 0.1, 0.1, 0.05])
    return np.concatenate([linear, rng.normal(size=(count, 3, 6))], axis=1)


def test_the_force_is_exact_without_friction_and_with_right_constants() -> None:
    jacobian, wrench = jacobians(50), np.tile([60.0, -80.0, 30.0, 1.0, -2.0, 0.5], (50, 1))
    torque = (jacobian.mT @ wrench[..., None])[..., 0]
    found, std = static_wrench(torque, np.full((50, 6), 1e-4), jacobian)
    assert np.abs(found - wrench).max() < 1e-2
    assert (std[:, :3] < 1).all()


def test_without_any_torque_known_the_prior_is_left() -> None:
    _, std = static_wrench(np.zeros((1, 6)), np.full((1, 6), 1e9), jacobians(1))
    assert std[0] == pytest.approx([100.0] * 3 + [10.0] * 3)


def test_the_band_holds_under_any_friction_and_wrong_constants() -> None:
    """Friction anywhere within the breakaway torque, constants that are off by 30 % (one std)."""
    rng = np.random.default_rng(2)
    count, jacobian = 4000, jacobians(4000)
    wrench = rng.normal(size=(count, 6)) * np.array([100.0] * 3 + [10.0] * 3)
    external = (jacobian.mT @ wrench[..., None])[..., 0]
    gravity = rng.uniform(-0.3, 0.3, (count, 6)) * TORQUE_MAX
    friction = rng.uniform(-BREAKAWAY, BREAKAWAY, (count, 6)) * TORQUE_MAX
    motor = gravity - external + friction
    measured = motor * (1 + 0.3 * rng.normal(size=(count, 6)))
    std = torque_std(motor, np.full(6, 0.3), TORQUE_MAX)
    found, deviation = static_wrench(gravity - measured, std, jacobian)
    held = (np.abs(found - wrench) <= 1.96 * deviation).mean(axis=0)
    assert ((held > 0.93) & (held < 0.97)).all(), held


def test_motion_is_no_rest_and_unknown_torque_is_no_force() -> None:
    qd = np.zeros((3, 6))
    qd[1, 4] = 2 * SLOW
    assert at_rest(qd).tolist() == [True, False, True]
    torque = np.zeros((3, 6))
    torque[1, 0] = np.nan
    found, std = static_wrench(torque, np.ones((3, 6)), jacobians(3))
    assert np.isfinite(found).all(axis=1).tolist() == [True, False, True]
    assert np.isnan(std[1]).all()
