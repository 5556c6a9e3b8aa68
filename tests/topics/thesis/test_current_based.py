"""The thesis's way from currents to the wrench on the arm."""

import numpy as np

from ur5lib.force.controller import environment_on_arm
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import flange_kinematics
from ur5lib.topics.thesis.current_based import (
    delay,
    friction_torque,
    motor_torque,
    motor_torque_as_published,
    wrench_from_torque,
)

RANDOM = np.random.default_rng(0)


def test_a_wrench_comes_back_from_its_torques(ur5: Robot) -> None:
    """tau = J^T F (3.2), then F = J^-T tau (3.3)."""
    J = flange_kinematics(ur5, RANDOM.uniform(-3, 3, (200, 6)))[2]
    wrench = RANDOM.normal(size=(200, 6))
    torque = (J.transpose(0, 2, 1) @ wrench[..., None])[..., 0]
    estimate = wrench_from_torque(J, torque, min_singular_value=1e-3)
    seen = np.linalg.svd(J, compute_uv=False)[:, -1] >= 1e-3
    np.testing.assert_allclose(estimate[seen], wrench[seen], rtol=1e-7, atol=1e-9)
    assert np.isnan(estimate[~seen]).all()


def test_a_published_wrench_is_turned_round_once(ur5: Robot) -> None:
    """Lifted from outside, the motors give less: J^-T (tau_motor - tau_model) points downwards."""
    J = flange_kinematics(ur5, RANDOM.uniform(0.5, 1.5, (5, 6)))[2]
    lift = np.tile([0.0, 0, 10, 0, 0, 0], (5, 1))
    missing = -(J.mT @ lift[..., None])[..., 0]
    published = wrench_from_torque(J, missing, min_singular_value=1e-3)
    np.testing.assert_allclose(environment_on_arm(published), lift, atol=1e-8)


def test_missing_torques_give_no_wrench() -> None:
    J = np.tile(np.eye(6), (2, 1, 1))
    torque = np.array([[1.0] * 6, [1.0] * 5 + [np.nan]])
    estimate = wrench_from_torque(J, torque, 0.1)
    np.testing.assert_array_equal(np.isnan(estimate[:, 0]), [False, True])


def test_motor_torque_is_equation_6_6(ur5: Robot) -> None:
    np.testing.assert_allclose(
        motor_torque(np.ones((1, 6)), ur5.current_to_torque)[0],
        [6.89, 22.8, 11.6, 3.64, 3.264, 3.499],
    )


def test_the_published_script_differs_on_joint_6_only(ur5: Robot) -> None:
    """Erratum 6: 3.4 i6 times 0.099."""
    current = RANDOM.normal(size=(50, 6))
    printed = motor_torque(current, ur5.current_to_torque)
    published = motor_torque_as_published(current, ur5.current_to_torque)
    np.testing.assert_array_equal(published[:, :5], printed[:, :5])
    np.testing.assert_allclose(published[:, 5], 3.4 * 0.099 * current[:, 5])


def test_friction_opposes_motion_and_rests_in_the_dead_zone(ur5: Robot) -> None:
    qd = RANDOM.uniform(-2, 2, (100, 6))
    friction = friction_torque(qd, ur5.friction)
    np.testing.assert_allclose(friction_torque(-qd, ur5.friction), -friction)
    assert (friction * qd >= 0).all()
    inside = np.full((1, 6), 0.02)  # delta of Equation 6.4
    np.testing.assert_allclose(
        friction_torque(inside, ur5.friction)[0] / 0.02, ur5.friction.viscous
    )


def test_delay_repeats_the_first_row() -> None:
    np.testing.assert_array_equal(delay(np.arange(5), 2), [0, 0, 0, 1, 2])
    np.testing.assert_array_equal(delay(np.arange(5), 0), np.arange(5))
