"""The prior of the maps from torque to current: what it takes for one standard deviation."""

from dataclasses import replace

import numpy as np
import pytest

from tests.current_study import CONSTANT, LOAD, noisy, prior, smooth
from ur5lib.errors import RefusalError
from ur5lib.identification.at_rest import AtRest
from ur5lib.identification.current_regression import expected_fit
from ur5lib.identification.currents import parameters
from ur5lib.identification.estimation import estimate_together
from ur5lib.identification.prior import (
    OFFSET_NAME,
    Prior,
    makers_covariance,
    standstill_ratio,
    torque_constant_prior,
    typical_friction,
)
from ur5lib.identification.regression import Normal
from ur5lib.identification.samples import joint_samples
from ur5lib.robots.friction import BASE_TERMS, FITTED_TERMS, coefficient_names
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


def test_constants_are_combined_as_normal_distributions_of_their_logarithm() -> None:
    """By Bayes' rule on a grid of log k; joints of one motor size share the maker's error."""
    maker, controller = np.array([10.0, 10.0, np.nan]), np.array([11.0, np.nan, 9.0])
    shared, spread, ratio = 0.1, 0.03, 0.05
    covariance = makers_covariance(maker, controller, ["a", "a", "b"], shared, spread)
    grid = np.exp(np.linspace(-0.5, 0.5, 401))
    common = np.linspace(-0.5, 0.5, 401)  # the error of all joints of a size
    weight = np.exp(-0.5 * (common / shared) ** 2)
    of_first = np.log(10.0 * grid)[:, None]
    density = weight * np.exp(-0.5 * ((of_first - np.log(10.0) - common) / spread) ** 2)
    density *= np.exp(-0.5 * ((of_first - np.log(11.0)) / ratio) ** 2)
    density /= density.sum()
    found = torque_constant_prior(maker, covariance, controller, ratio)
    logs = -np.log(found.mean)
    stds = np.sqrt(np.diag(np.linalg.inv(found.precision))) / found.mean
    first = (density * of_first).sum()
    assert logs[0] == pytest.approx(first, abs=1e-3)
    assert stds[0] == pytest.approx(np.sqrt((density * (of_first - first) ** 2).sum()), rel=0.01)
    # the second joint is known by what the first one says of their size alone
    others = (density * common).sum()
    assert logs[1] == pytest.approx(np.log(10.0) + others, abs=1e-3)
    width = np.hypot(np.sqrt((density * (common - others) ** 2).sum()), spread)
    assert stds[1] == pytest.approx(width, rel=0.01)
    # the third by its controller, as good as alone
    assert logs[2] == pytest.approx(np.log(9.0), abs=1e-3)
    assert stds[2] == pytest.approx(ratio, rel=0.01)


def test_a_motor_size_that_nothing_knows_is_refused() -> None:
    unknown, given = np.array([np.nan, np.nan]), np.array([9.0, np.nan])
    makers_covariance(unknown, given, ["a", "a"], 0.1, 0.03)
    with pytest.raises(RefusalError, match="torque constant of a motor size"):
        makers_covariance(unknown, given, ["a", "b"], 0.1, 0.03)


def test_the_controller_s_constant_is_that_of_samples_at_rest_that_carry_a_load() -> None:
    """In motion, friction is in the current; half of the samples at rest have to carry a load."""
    count, constants = 300, np.array([9.0, 10.0, 11.0, 12.0])
    moment = np.tile([20.0, -5.0, 0.05, 3.0], (count, 1))
    moment[:, 3] *= np.arange(count) < 120  # of 200 samples at rest
    current = moment / constants
    qd = np.zeros((count, 4))
    qd[200:, 2] = 0.1  # any joint that moves
    current[200:] += 5.0
    found = standstill_ratio(moment, current, qd)
    np.testing.assert_allclose(found, [9.0, 10.0, np.nan, 12.0])
    moment[100:, 3] = 0.0
    assert np.isnan(standstill_ratio(moment, current, qd)[3])


def test_what_is_known_without_a_recording_is_all_from_the_prior() -> None:
    """Constants as the maker says, friction as of other joints."""
    rows = parameters(expected_fit(KNOWN))
    assert len(rows) == 6 * (2 + len(coefficient_names(BASE_TERMS)))
    for row in rows:
        shares = row.prior_share, row.arm_share, row.day_share, row.run_share
        assert shares == (1.0, 0.0, 0.0, 0.0)
        if row.name in TYPICAL:
            typical, joint = TYPICAL[row.name], row.joint - 1
            assert row.value == pytest.approx(typical.mean[joint], rel=1e-6, abs=1e-9)
            assert row.std_error == pytest.approx(typical.std[joint], rel=0.15)
        if row.name == "torque_constant":
            assert row.value == pytest.approx(CONSTANT[row.joint - 1])


def test_shares_of_knowledge_are_of_recordings_whatever_their_order() -> None:
    """Of one in motion, and of two of postures, each a day of its own."""
    random = np.random.default_rng(4)
    torques = [random.uniform(-1, 1, (8, 6)) * LOAD for _ in range(2)]
    postures = [(one, one / CONSTANT + 0.05 * random.normal(size=(8, 6))) for one in torques]
    samples = joint_samples(noisy([1]), smooth)
    found = [
        estimate_together(samples, replace(prior(), at_rest=AtRest.of(order)))[0]
        for order in (postures, postures[::-1])
    ]
    for one, other in zip(*found, strict=True):
        np.testing.assert_allclose(one.shares.sum(axis=0), 1.0)
        np.testing.assert_allclose(one.shares, other.shares, atol=1e-6)
