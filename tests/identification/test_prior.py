"""The prior of the maps from torque to current: what it takes for one standard deviation."""

from dataclasses import replace

import numpy as np
import pytest

from tests.current_study import prior
from ur5lib.identification.prior import OFFSET_NAME, Prior, typical_friction
from ur5lib.identification.regression import Normal
from ur5lib.robots.friction import FITTED_TERMS, coefficient_names
from ur5lib.timeseries.arrays import Array

WIDTH = 0.1
TORQUE_MAX = np.array([150.0, 140.0, 130.0, 30.0, 28.0, 26.0])
NAMES = ["", OFFSET_NAME, *coefficient_names(FITTED_TERMS)]  # of each joint; "" is 1/k
TYPICAL = typical_friction(TORQUE_MAX)
KNOWN = replace(prior(WIDTH), torque_max=TORQUE_MAX, typical=TYPICAL)


def deviations(distribution: Normal, values: Array) -> float:
    """How many standard deviations values are off."""
    away = values - distribution.mean
    return float(np.sqrt(away @ distribution.precision @ away))


def changed(joint: int, name: str, by: float) -> Array:
    values = KNOWN.over(FITTED_TERMS).mean.copy()
    values[len(NAMES) * joint + NAMES.index(name)] += by
    return values


@pytest.mark.parametrize("joint", range(6))
@pytest.mark.parametrize("name", TYPICAL)
def test_a_typical_coefficient_is_that_of_the_joint_within_its_deviation(
    name: str, joint: int
) -> None:
    """Of the current: c = F / k; the offset is what the current lacks."""
    inverse, typical = KNOWN.inverse_constant.mean[joint], TYPICAL[name]
    known = KNOWN.over(FITTED_TERMS)
    value = changed(joint, name, 0.0)[len(NAMES) * joint + NAMES.index(name)]
    assert value == pytest.approx(typical.mean[joint] * inverse)
    off = changed(joint, name, typical.std[joint] * inverse)
    assert deviations(known, off) == pytest.approx(1.0)


@pytest.mark.parametrize("joint", range(6))
def test_friction_is_known_at_the_joint_whatever_the_constant_is(joint: int) -> None:
    """A constant that is off takes the friction of the current along."""
    known, place = KNOWN.over(FITTED_TERMS), len(NAMES) * joint
    values = known.mean.copy()
    values[place : place + len(NAMES)] *= 1 + WIDTH
    assert deviations(known, values) == pytest.approx(1.0)


def test_what_is_not_typical_is_at_most_as_large_as_can_be_expected() -> None:
    """Without typical values, an offset is up to the motor's largest torque."""
    known = replace(KNOWN, typical={}).over(FITTED_TERMS)
    for joint, inverse in enumerate(KNOWN.inverse_constant.mean):
        values = known.mean.copy()
        values[len(NAMES) * joint + 1] += TORQUE_MAX[joint] * inverse
        assert deviations(known, values) == pytest.approx(1.0)


def test_a_pinned_constant_is_as_good_as_certain() -> None:
    """And takes no other with it, although all are of one maker."""
    inverse = KNOWN.inverse_constant.mean
    covariance = np.outer(inverse, inverse) * (0.01 * np.eye(6) + 0.02)
    together = replace(
        KNOWN, inverse_constant=Normal(inverse, np.linalg.inv(covariance)), typical={}
    )
    pinned = together.with_pinned(np.arange(6) == 2)
    stds = []
    for own in (together, pinned):
        places = len(NAMES) * np.arange(6)
        found = np.linalg.inv(own.over(FITTED_TERMS).precision)[np.ix_(places, places)]
        stds.append(np.sqrt(np.diag(found)))
        np.testing.assert_allclose(stds[-1], own.std(), rtol=1e-6)
    np.testing.assert_allclose(stds[1] / stds[0], [1, 1, 1e-3, 1, 1, 1], rtol=1e-6)


def test_a_joint_s_prior_is_its_part_of_the_arm_s() -> None:
    size = len(NAMES)
    whole = KNOWN.over(FITTED_TERMS)
    for joint in range(6):
        own = KNOWN.of_joint(joint).over(FITTED_TERMS)
        rows = slice(size * joint, size * (joint + 1))
        np.testing.assert_allclose(own.mean, whole.mean[rows])
        np.testing.assert_allclose(own.precision, whole.precision[rows, rows])


def test_usual_noise_is_a_share_of_the_largest_current() -> None:
    most = Prior(KNOWN.inverse_constant, TORQUE_MAX)
    largest = TORQUE_MAX * KNOWN.inverse_constant.mean  # A
    np.testing.assert_allclose(np.sqrt(most.noise()) / largest, 0.005)
    # anywhere within a twentieth: uniform
    drawn = np.random.default_rng(0).uniform(-0.05, 0.05, 100_000).std()
    np.testing.assert_allclose(np.sqrt(most.noise_at_rest()) / largest, drawn, rtol=0.01)
