"""What measured arms have in common, as a prior of one more arm."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from ur5lib.errors import InputError
from ur5lib.identification.current_regression import expected_fit
from ur5lib.identification.currents import JointFit, parameters
from ur5lib.identification.estimation import physical
from ur5lib.identification.population import KINDS, fit_population, typical_arm
from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import Normal, posterior_mean
from ur5lib.identification.unlike_others import unlike_others
from ur5lib.pipeline.current_samples import prior_of
from ur5lib.report.findings import in_words
from ur5lib.robots.description import POPULATION, load_robot, robot_path
from ur5lib.robots.friction import BASE
from ur5lib.robots.population import Measured, MeasuredArm, MeasuredJoint, read_measured
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95

TORQUE_MAX = np.array([150.0, 150.0, 150.0, 28.0, 28.0, 28.0])
OF_ARMS, OF_JOINTS, ERROR = 0.2, 0.15, 0.05


def coulomb_of(torque_max: Array, random: np.random.Generator) -> Array:
    """Draw the Coulomb friction of an arm's joints [Nm] about 3 Nm (torque_max / 54 Nm)^0.8."""
    trend = 3.0 * (torque_max / 54.0) ** 0.8
    joints = OF_JOINTS * random.standard_normal(len(torque_max))
    return np.asarray(trend * np.exp(OF_ARMS * random.standard_normal() + joints))


def drawn_arms(count: int, seed: int) -> Measured:
    """Return arms of one population, their friction measured with errors."""
    random, arms = np.random.default_rng(seed), []
    for number in range(count):
        true = coulomb_of(TORQUE_MAX, random)
        seen = true * np.exp(ERROR * random.standard_normal(len(true)))
        joints = {
            joint: MeasuredJoint(torque_max=most, values={"coulomb": (value, ERROR * value)})
            for joint, (most, value) in enumerate(zip(TORQUE_MAX, seen, strict=True), start=1)
        }
        name = f"arm{number}"
        arms.append(
            MeasuredArm(arm=name, study=name, source="drawn", days=1, minutes=1.0, joints=joints)
        )
    return Measured(arms=arms)


def test_spreads_of_many_arms_are_the_true_ones() -> None:
    spread = fit_population(drawn_arms(200, seed=0))["coulomb"]
    assert spread.arm == pytest.approx(OF_ARMS, rel=0.2)
    assert spread.joint == pytest.approx(OF_JOINTS, rel=0.2)
    np.testing.assert_allclose(np.exp(spread.trend[0]), 3.0, rtol=0.05)
    np.testing.assert_allclose(spread.trend[1], 0.8, atol=0.05)


def test_intervals_of_one_more_arm_hold_what_they_promise() -> None:
    known = typical_arm(fit_population(drawn_arms(200, seed=1)), TORQUE_MAX)["coulomb"]
    half = NORMAL95 * np.sqrt(np.diag(known.covariance)) / known.mean
    random = np.random.default_rng(2)
    true = np.array([coulomb_of(TORQUE_MAX, random) for _ in range(500)])
    inside = np.abs(np.log(true / known.mean)) <= half
    assert inside.mean() == pytest.approx(0.95, abs=0.02)


def test_few_arms_leave_the_spread_open() -> None:
    many, few = (fit_population(drawn_arms(count, seed=3))["coulomb"] for count in (50, 2))
    widths = [np.sqrt(np.diag(own.of_arm(TORQUE_MAX)[1])) for own in (few, many)]
    assert (widths[0] > widths[1]).all()


def test_a_strange_joint_hardly_counts() -> None:
    usual = drawn_arms(20, seed=4)
    [first, *others] = usual.arms
    value, error = first.joints[1].values["coulomb"]
    wrong = first.joints[1].model_copy(update={"values": {"coulomb": (10 * value, 10 * error)}})
    strange = first.model_copy(update={"joints": first.joints | {1: wrong}})
    found = fit_population(Measured(arms=[strange, *others]))["coulomb"]
    alone = fit_population(usual)["coulomb"]
    np.testing.assert_allclose(found.trend, alone.trend, atol=0.1)


def prior_by_shipped_arms(robot: str, without: str = "") -> Prior:
    """Return the prior of an arm from all shipped arms but those of a study."""
    population = fit_population(read_measured(POPULATION).without(without))
    return prior_of(load_robot(robot_path(robot)), [], population)


def test_measured_arms_are_inside_the_intervals_of_the_others() -> None:
    inside = []
    for arm in read_measured(POPULATION).arms:
        known = parameters(expected_fit(prior_by_shipped_arms(arm.arm, arm.study)))
        for row in known:
            measured = arm.joints.get(row.joint)
            if measured and row.name in measured.values:
                value, error = measured.values[row.name]
                half = np.hypot((row.interval[1] - row.interval[0]) / 2, NORMAL95 * error)
                inside.append(abs(value - row.value) <= half)
    assert len(inside) > 80
    assert 0.88 <= np.mean(inside) <= 1.0


def test_friction_is_known_whatever_the_torque_constant() -> None:
    """With 1/k twice the prior's mean, the most probable friction currents double, too."""
    prior = prior_by_shipped_arms("ur5e")
    known, twice = prior.of_joint(2).over([BASE]), 2 * prior.inverse_constant.mean[2]
    sure = np.zeros((len(known.mean), len(known.mean)))
    sure[0, 0] = 1e12
    found = posterior_mean(sure, sure @ (twice * np.eye(len(known.mean))[0]), known)
    np.testing.assert_allclose(found, 2 * known.mean, rtol=1e-3, atol=1e-9)


def test_friction_shows_a_torque_constant_that_inertia_does_not() -> None:
    """Coulomb friction alone was seen, as 0.3 A: its typical value is k times that."""
    joint = prior_by_shipped_arms("ur3").of_joint(0)
    prior, seen = joint.over([BASE]), np.zeros((5, 5))
    seen[2, 2] = 1e8
    found = posterior_mean(seen, seen @ np.array([0, 0, 0.3, 0, 0]), prior)
    by_friction, before = joint.typical["coulomb"].mean[0] / 0.3, 1 / prior.mean[0]
    assert min(by_friction, before) < 1 / found[0] < max(by_friction, before)


def remarked(prior: Prior, friction: Array) -> set[int]:
    """Return the joints that are unlike others where friction is as given."""
    return {joint for joint, _ in unlike_others(with_friction(prior, friction), prior)}


def with_friction(prior: Prior, friction: Array) -> list[JointFit]:
    """Return expected joints whose Coulomb and viscous friction (2, 6) were measured, with 2 %."""
    joints = []
    for joint, own in enumerate(expected_fit(prior).joints):
        coefficients = own.estimate.coefficients.copy()
        coefficients[2:4] = friction[:, joint] * coefficients[0]
        error = 0.02 * np.abs(physical(coefficients))
        estimate = replace(own.estimate, coefficients=coefficients, std_error=error)
        joints.append(replace(own, estimate=estimate))
    return joints


def test_a_joint_unlike_those_of_other_arms_is_named() -> None:
    """Arms drawn from a population of 200; of one joint in each, friction is doubled."""
    known = typical_arm(fit_population(drawn_arms(200, seed=5)), TORQUE_MAX)
    constants = Normal(np.full(6, 0.1), np.eye(6) * 1e4)
    typical = dict.fromkeys(("coulomb", "viscous"), known["coulomb"])
    prior = Prior(constants, TORQUE_MAX, typical=typical)
    random, named, falsely = np.random.default_rng(6), 0, 0
    for run in range(200):
        true = np.stack([coulomb_of(TORQUE_MAX, random) for _ in typical])
        falsely += bool(remarked(prior, true))
        true[:, run % 6] *= 2
        named += remarked(prior, true) == {run % 6}
    assert falsely / 200 <= 0.05
    assert named / 200 >= 0.95


def test_a_strange_joint_is_told_with_its_ratio_arms_and_odds() -> None:
    """Far from what the shipped arms let expect, and alone in that."""
    prior = prior_by_shipped_arms("ur5e")
    friction = np.stack([prior.typical[name].mean for name in ("coulomb", "viscous")])
    friction[0, 2] *= 5
    [(joint, found)] = unlike_others(with_friction(prior, friction), prior)
    assert joint == 2
    assert found.values["ratio"] == pytest.approx(5)
    assert found.values["arms"] == len(read_measured(POPULATION).arms)
    assert found.values["odds"] >= 1000
    assert "5.0 times" in in_words(found)


def test_joints_of_an_arm_are_correlated() -> None:
    """Where joint 1 has more Coulomb friction than typical, joint 2 is expected to, as well."""
    prior = prior_by_shipped_arms("ur5e").over([BASE] * 6)
    sure = np.zeros_like(prior.precision)
    for place in (0, 2):
        sure[place, place] = 1e12
    target = prior.mean.copy()
    target[2] *= 1.5
    found = posterior_mean(sure, sure @ target, prior)
    assert found[7] > 1.05 * prior.mean[7]


def test_without_a_population_friction_is_unknown() -> None:
    prior = prior_of(load_robot(robot_path("ur5e")), [], None)
    assert not prior.typical
    own = prior.of_joint(0).over([BASE])
    np.testing.assert_array_equal(own.mean[1:], 0)


def test_a_study_does_not_expect_what_it_measured_itself() -> None:
    measured = read_measured(POPULATION)
    assert {arm.study for arm in measured.without("thesis").arms} == {
        arm.study for arm in measured.arms
    } - {"thesis"}


def test_every_trait_of_the_shipped_arms_is_used() -> None:
    assert set(fit_population(read_measured(POPULATION))) == set(KINDS)


@pytest.mark.parametrize("content", ["arms: 3", "[]", "arms: [{arm: ur5}]", "{"])
def test_a_file_that_is_no_population_is_refused(tmp_path: Path, content: str) -> None:
    path = tmp_path / "mine.yaml"
    path.write_text(content)
    with pytest.raises(InputError, match=r"mine\.yaml"):
        read_measured(path)


def test_the_shipped_file_names_a_source_of_each_arm() -> None:
    for arm in yaml.safe_load(POPULATION.read_text())["arms"]:
        assert arm["source"].startswith("https://")
