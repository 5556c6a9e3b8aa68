"""Friction of all terms at steady velocities: that of the prediction, with an error that holds."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from tests.current_study import (
    CONSTANT,
    coefficients,
    make_noise,
    make_record,
    noisy,
    prior,
    smooth,
)
from ur5lib.identification.current_regression import expected_fit, fit_currents
from ur5lib.identification.current_samples import prior_of
from ur5lib.identification.currents import friction_current, torque_constants
from ur5lib.identification.estimation import estimate_together, physical_values
from ur5lib.identification.samples import INDEPENDENT_STEP, CurrentSamples, joint_samples
from ur5lib.identification.steady_friction import (
    STATED_VELOCITIES,
    friction_curve,
    mean_load,
    steady_columns,
    steady_friction,
    total_friction,
)
from ur5lib.records.friction import CoefficientEstimate, CurrentFit, JointFit
from ur5lib.robots.description import Robot
from ur5lib.steps.fit_friction import with_far_friction
from ur5lib.timeseries.arrays import Array

STUDY, RUNS = 10, 60  # recordings, studies
TERMS = ("coulomb", "viscous", "load", "velocity_root")
NAMES = ["total_0", "total_0.1", "total_0.5", "total_1"]
VALUES = np.array([10.0, 0.3, 6.0, 8.0, 0.1, 3.0])  # k, b, and the coefficients of TERMS


@pytest.fixture(scope="module")
def records() -> list[CurrentSamples]:
    return noisy(range(3))


@pytest.fixture(scope="module")
def fitted(records: list[CurrentSamples]) -> CurrentFit:
    return fit_currents(records, smooth, prior())


def steady_motion(velocity: float, load: Array) -> CurrentSamples:
    """All joints turn at a velocity [rad/s] under these loads (6,) [Nm]; at none, just begun."""
    q = np.linspace(0, 1, 50)[:, None] * np.ones(6)
    qd, torque = np.full_like(q, velocity), load * np.ones_like(q)
    return CurrentSamples("steady", 0.02, np.zeros(50, int), q, qd, torque, 0 * q)


def joint_fit(error: Array, replicates: Array, unseen: Array | float = 0.0) -> JointFit:
    """The fit of VALUES with such errors; replicates: (B, 6) of the same."""
    shares = np.zeros((4, 6))
    shares[3] = 1.0
    own, drawn = (physical_values(values) for values in (VALUES, replicates))  # its own inverse
    estimate = CoefficientEstimate(own, shares, drawn, error)
    nothing, bands = np.zeros(1), np.zeros(4).tolist()
    return JointFit(TERMS, (), estimate, nothing, *bands, unseen + 0 * own, ())


def drawn_values(correlation: Array, seed: int = 0) -> Array:
    """Replicates of VALUES whose frictions have unit variance and this correlation (4, 4)."""
    random = np.random.default_rng(seed)
    friction = random.multivariate_normal(VALUES[2:], correlation, 4000)
    return np.column_stack([np.full(4000, VALUES[0]), np.full(4000, VALUES[1]), friction])


def test_totals_are_what_the_prediction_takes(
    records: list[CurrentSamples], fitted: CurrentFit
) -> None:
    """The friction of a motion at that velocity under that load, with whatever terms."""
    load = mean_load(records, smooth, fitted.joints[0].terms)
    totals = {(row.joint, row.name): row.value for row in total_friction(fitted, load)}
    assert [*totals] == [(joint, name) for joint in range(1, 7) for name in NAMES]
    for name, velocity in zip(NAMES, STATED_VELOCITIES.tolist(), strict=True):
        current = friction_current(fitted, steady_motion(velocity, load))[-1]
        expected = torque_constants(fitted) * current
        found = [totals[joint, name] for joint in range(1, 7)]
        np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_the_first_total_is_the_limit_from_above(fitted: CurrentFit) -> None:
    """Of the curve that the figure draws, which has no direction at zero."""
    load = np.arange(1.0, 7.0)
    firsts = [row.value for row in total_friction(fitted, load) if row.name == "total_0"]
    for first, model, own in zip(firsts, fitted.joints, load, strict=True):
        near, at, below = friction_curve(model, np.array([1e-16, 0.0, -1e-16]), own)
        assert first == pytest.approx(near, rel=1e-6)
        assert (at, below) == (0.0, -near)


def test_friction_turns_with_the_velocity() -> None:
    """Its error does not; in positive direction, and at rest, both are those of the totals."""
    model = joint_fit(np.full(6, 0.1), drawn_values(np.eye(4)), 0.07 * np.abs(VALUES))
    totals = [*total_friction(CurrentFit((model,), 5), np.array([20.0]))]
    forward, error = steady_friction(model, STATED_VELOCITIES, 20.0)
    np.testing.assert_allclose(forward, [row.value for row in totals])
    np.testing.assert_allclose(error, [row.std_error for row in totals])
    back, error_back = steady_friction(model, -STATED_VELOCITIES[1:], 20.0)
    np.testing.assert_allclose(back, -forward[1:])
    np.testing.assert_allclose(error_back, error[1:])


def test_the_terms_add_up_by_their_formulas() -> None:
    """Those that the documents state: the root's also changes friction near rest and at 1 rad/s."""
    model = joint_fit(np.full(6, 0.1), drawn_values(np.eye(4)))
    found = [row.value for row in total_friction(CurrentFit((model,), 5), np.array([20.0]))]
    v, (_, _, coulomb, viscous, load, root) = STATED_VELOCITIES, VALUES
    terms = coulomb + 20 * load + viscous * v + root * (np.sqrt(v) - 4 / 15 - 4 / 5 * v)
    np.testing.assert_allclose(found, terms)
    assert abs(found[0] / (coulomb + 20 * load) - 1) > 0.05


def test_a_joint_that_does_not_move_has_no_total(records: list[CurrentSamples]) -> None:
    still = [1, 1, 1, 1, 0, 1]
    resting = [replace(own, q=own.q * still, qd=own.qd * still) for own in records]
    fit = fit_currents(resting, smooth, prior())
    load = mean_load(resting, smooth, fit.joints[0].terms)
    assert np.isnan(load).tolist() == [False, False, False, False, True, False]
    assert {row.joint for row in total_friction(fit, load)} == {1, 2, 3, 4, 6}


@pytest.mark.parametrize("prior_share", [0.0, 0.4, 1.0])
def test_the_interval_of_a_total_is_by_student_as_far_as_the_data_tell_it(
    prior_share: float,
) -> None:
    """By the normal quantile as far as other arms do; half of what is left is the arm's share."""
    model, units = joint_fit(np.full(6, 0.1), drawn_values(np.eye(4))), 5
    shares = np.zeros((4, 6))
    shares[0], shares[1], shares[3] = prior_share, *2 * [(1 - prior_share) / 2]
    model = replace(model, estimate=replace(model.estimate, shares=shares))
    rows = [*total_friction(CurrentFit((model,), units), np.array([20.0]))]
    student, normal = stats.t.ppf(0.975, units - 1), stats.norm.ppf(0.975)
    factor = np.sqrt(prior_share * normal**2 + (1 - prior_share) * student**2)
    for row in rows:
        assert row.prior_share == pytest.approx(prior_share)
        low, high = row.interval
        assert high - row.value == pytest.approx(factor * row.std_error, rel=1e-3)
        assert row.value - low == pytest.approx(factor * row.std_error, rel=1e-3)


@pytest.mark.parametrize("correlation", [0.0, 0.8, -0.8])
def test_the_error_of_a_total_is_that_of_its_parts_together(correlation: float) -> None:
    """√(J Σ Jᵀ) of errors that replicates correlate, and that may be larger than their spread."""
    related, error = np.eye(4), np.array([1.0, 1.0, 0.5, 2.0, 0.03, 0.4])
    related[0, 1] = related[1, 0] = correlation
    model = joint_fit(error, drawn_values(related))
    found = [row.std_error for row in total_friction(CurrentFit((model,), 5), np.array([20.0]))]
    columns = steady_columns(TERMS, STATED_VELOCITIES, np.ones(4), 20.0)
    covariance = related * np.outer(error[2:], error[2:])
    expected = np.sqrt(np.einsum("vi,ij,vj->v", columns, covariance, columns))
    np.testing.assert_allclose(found, expected, rtol=0.05)


def test_days_change_all_terms_alike() -> None:
    """Of a friction that is known exactly, another day leaves a share of the total."""
    unseen = 0.07 * np.abs(VALUES) * [0, 0, 1, 1, 1, 1]
    model = joint_fit(np.zeros(6), drawn_values(np.eye(4)), unseen)
    for row in total_friction(CurrentFit((model,), 5), np.array([20.0])):
        assert row.std_error == pytest.approx(0.07 * row.value)
        low, high = row.interval
        assert (high - low) / 2 == pytest.approx(1.96 * row.std_error, rel=1e-3)


def test_a_total_without_a_sure_sign_is_not_determined() -> None:
    wide = joint_fit(np.array([1.0, 1.0, 9.0, 0.1, 0.01, 0.1]), drawn_values(np.eye(4)))
    of_others = replace(wide.estimate, std_error=np.full(6, 0.1), shares=np.eye(4)[:, [0] * 6])
    known = replace(of_others, shares=np.eye(4)[:, [3] * 6])
    for estimate, told in ((wide.estimate, False), (of_others, False), (known, True)):
        fit = CurrentFit((replace(wide, estimate=estimate),), 5)
        assert {row.determined for row in total_friction(fit, np.array([20.0]))} == {told}


def test_intervals_of_totals_hold_what_they_promise() -> None:
    """60 studies of six joints; constants as the prior says, noise as real residuals."""
    samples = joint_samples([make_record(seed) for seed in range(STUDY)], smooth)
    samples = [own.where(own.moving) for own in samples]
    load = np.array([np.abs(own.columns[:, 0]).mean() for own in samples])
    inside = []
    for run in range(RUNS):
        random = np.random.default_rng(run)
        truth = [np.append(coefficients(joint), 0.0) for joint in range(6)]
        noise = [make_noise(random, 400, INDEPENDENT_STEP) for _ in range(STUDY)]
        drawn = []
        for joint, own in enumerate(samples):
            truth[joint][0] *= 1 + 0.1 * random.standard_normal()
            truth[joint][4] = 0.1 * random.standard_normal() / CONSTANT[joint]
            place = np.concatenate([np.arange(np.sum(own.record == one)) for one in range(STUDY)])
            residual = np.stack(noise)[own.record, place, joint]
            drawn.append(replace(own, current=own.columns @ truth[joint] + residual))
        estimates, units = estimate_together(drawn, prior(), seed=run)
        model = joint_fit(np.zeros(6), drawn_values(np.eye(4)))
        joints = tuple(replace(model, estimate=own) for own in estimates)
        rows = iter(total_friction(CurrentFit(joints, units), load))
        for true, size in zip(truth, load.tolist(), strict=True):
            columns = steady_columns(TERMS, STATED_VELOCITIES, np.ones(4), size)
            for value in columns @ physical_values(true)[2:]:
                low, high = next(rows).interval
                inside.append(low < value < high)
    coverage = np.reshape(inside, (RUNS, -1)).mean(axis=0)
    assert coverage.mean() == pytest.approx(0.95, abs=0.03)
    assert coverage.min() >= 0.87


@pytest.mark.parametrize("factor", [1.0, 6.0])
def test_friction_far_from_the_prior_is_remarked_on(ur5: Robot, factor: float) -> None:
    """A brake on joint 3 has terms of speed in place of dry friction."""
    known = prior_of(ur5, [])
    fit = expected_fit(known)
    estimate = fit.joints[2].estimate
    dry = 2 + fit.joints[2].terms.index("coulomb")
    coefficients = estimate.coefficients.copy()
    coefficients[dry] *= factor
    braked = replace(fit.joints[2], estimate=replace(estimate, coefficients=coefficients))
    joints = (*fit.joints[:2], braked, *fit.joints[3:])
    found = with_far_friction(replace(fit, joints=joints), np.full(6, 10.0), known)
    codes = [
        [one.code for one in joint.remarks if one.code == "far friction"] for joint in found.joints
    ]
    assert codes == [["far friction"] * (factor > 1 and k == 2) for k in range(6)]
