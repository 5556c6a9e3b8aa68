"""What is known of torque constants beforehand."""

import numpy as np
import pytest

from ur5lib.identification.torque_constants import standstill_ratio, torque_constant_prior

SIZES = ["big", "big", "big", "small", "small", "small"]
NONE = np.full(6, np.nan)
WIDTHS = (0.3, 0.1, 0.05)


def relative_spread(prior: object) -> np.ndarray:
    return np.sqrt(np.diag(np.linalg.inv(prior.precision))) / prior.mean


def test_the_maker_alone_is_the_prior() -> None:
    maker = np.array([13.0] * 3 + [14.0] * 3)
    prior = torque_constant_prior(maker, NONE, SIZES, WIDTHS)
    np.testing.assert_allclose(1 / prior.mean, maker)
    np.testing.assert_allclose(relative_spread(prior), np.hypot(0.3, 0.1))


def test_a_joint_learns_from_another_of_its_size_only() -> None:
    maker, told = np.full(6, 13.0), NONE.copy()
    told[1] = 10.0
    prior = torque_constant_prior(maker, told, SIZES, WIDTHS)
    constant, spread = 1 / prior.mean, relative_spread(prior)
    assert constant[1] == pytest.approx(10.0, rel=0.02)
    np.testing.assert_allclose(constant[0], constant[2])
    assert 10.0 < constant[0] < 11.0
    np.testing.assert_allclose(constant[3:], 13.0)
    assert spread[1] < spread[0] < spread[3]


def test_the_controller_alone_will_do() -> None:
    told = np.array([np.nan, 12.0, 9.8, 10.8, np.nan, np.nan])
    prior = torque_constant_prior(NONE, told, SIZES, WIDTHS)
    np.testing.assert_allclose(1 / prior.mean[4:], 10.8, rtol=1e-3)


def test_a_size_of_which_nothing_is_known_is_an_error() -> None:
    with pytest.raises(ValueError, match="motor size"):
        torque_constant_prior(NONE, np.array([10.0] * 3 + [np.nan] * 3), SIZES, WIDTHS)


def test_the_ratio_is_read_at_rest_and_under_load() -> None:
    constants = np.array([np.nan, 10.7, 10.2, 11.9, np.nan, np.nan])
    moment = np.tile([0.0, 30.0, -12.0, 1.0, 0.01, 0.0], (50, 1))
    current = moment / np.nan_to_num(constants, nan=8.0)
    qd = np.zeros((50, 6))
    qd[40:], current[40:] = 0.5, 99.0
    np.testing.assert_allclose(standstill_ratio(moment, current, qd), constants)


def test_an_arm_that_never_rests_tells_no_ratio() -> None:
    assert np.isnan(standstill_ratio(np.ones((9, 6)), np.ones((9, 6)), np.ones((9, 6)))).all()


@pytest.mark.parametrize(("bearing", "told"), [(50, False), (51, True)])
def test_a_joint_tells_a_ratio_that_bears_a_load_most_of_the_time(bearing: int, told: bool) -> None:
    """Of the time at rest; and a load is more than a tenth of a newton metre."""
    moment = np.full((100, 6), 0.09)
    moment[:bearing] = -0.11
    ratio = standstill_ratio(moment, moment / 8, np.zeros((100, 6)))
    np.testing.assert_allclose(ratio, 8.0 if told else np.nan)
