"""A payload from currents alone."""

from dataclasses import replace

import numpy as np
import pytest
from scipy import stats

from tests.current_study import cut, make_record, noisy, prior, smooth, with_noise
from ur5lib.identification.current_regression import fit_currents
from ur5lib.identification.currents import predict
from ur5lib.identification.payload import (
    PayloadEstimate,
    error_growth,
    estimate_payload,
    joint_gains,
    judge,
    judged_load,
)
from ur5lib.identification.samples import CurrentSamples
from ur5lib.records.friction import CurrentFit
from ur5lib.records.prediction import LoadEstimate

CARRIED = np.array([2.8, 0.1, -0.3])


@pytest.fixture(scope="module")
def fitted() -> CurrentFit:
    return fit_currents(noisy(range(6)), smooth, prior())


def regressor(record: CurrentSamples) -> np.ndarray:
    """Torque per mass and moments, as gravity would cause it on a made-up arm."""
    lever = np.array([0.0, 6.0, 5.0, 2.0, 1.0, 0.0])
    angles = np.stack([record.q, 2 * record.q + 1, record.q - np.roll(record.q, 1, axis=1)], axis=2)
    return lever[:, None] * np.cos(angles)


def test_a_payload_comes_back_with_the_friction_it_adds(fitted: CurrentFit) -> None:
    record = make_record(50)
    heavy = replace(record, torque=record.torque + regressor(record) @ CARRIED)
    loaded = replace(record, current=predict(fitted, heavy))
    payload = estimate_payload(fitted, loaded, regressor(record), smooth)
    np.testing.assert_allclose(payload.parameters, CARRIED, atol=0.01)


def test_what_motion_does_not_tell_stays_unknown_however_precise_the_torque(
    fitted: CurrentFit,
) -> None:
    """Of an arm in a plane: a moment that no joint feels, another that only the mass's torque has.

    Of equal priors, what is known of a combination is shared by the squares of its weights.
    """
    record = make_record(50)
    plane = regressor(record)
    plane[..., 1], plane[..., 2] = 0.0, 0.5 * plane[..., 0]
    heavy = replace(record, torque=record.torque + plane @ [2.5, 0.0, 0.0])
    exact = replace(record, current=predict(fitted, heavy))
    for unit in (1.0, 1e-8):  # of what is estimated
        payload = estimate_payload(fitted, exact, plane / unit, smooth)
        np.testing.assert_allclose(payload.parameters, [2.0 * unit, 0.0, 1.0 * unit], rtol=0.02)
        assert (payload.std_error[1:] > 10.0).all()


def loaded(fitted: CurrentFit, seed: int, when: np.ndarray | float = 1.0) -> CurrentSamples:
    """A recording that carries a load, all along or in part (N,)."""
    record = make_record(seed)
    torque = regressor(record) @ CARRIED * np.reshape(when, (-1, 1))
    heavy = replace(record, torque=record.torque + torque)
    return with_noise(replace(record, current=predict(fitted, heavy)), seed)


def load_of(fitted: CurrentFit, record: CurrentSamples, growth: float = 1.0) -> LoadEstimate:
    return judge(estimate_payload(fitted, record, regressor(record), smooth), growth)


@pytest.mark.parametrize("seed", [51, 61, 67])
def test_its_interval_holds_the_mass_and_not_zero(fitted: CurrentFit, seed: int) -> None:
    """And each part of a run tells the load."""
    record = loaded(fitted, seed)
    payload = estimate_payload(fitted, record, regressor(record), smooth)
    assert payload.parts.shape == (3,)
    np.testing.assert_allclose(payload.parts, CARRIED[0], rtol=0.25)
    load = judge(payload, 1.0)
    low, high = load.interval
    assert 0 < low < CARRIED[0] < high
    assert high - low < 1.0
    assert load.certain


def test_an_empty_flange_weighs_nothing(fitted: CurrentFit) -> None:
    """As runs differ, and some stray far: what they seem to carry says how far."""
    records = noisy(range(52, 72))
    empty = [estimate_payload(fitted, own, regressor(own), smooth) for own in records]
    told = np.array([own.parameters for own in empty]), np.array([own.std_error for own in empty])
    growth = error_growth(*told, paths=len(empty))[0]
    assert growth < 3.0
    loads = [judge(payload, growth) for payload in empty]
    assert np.mean([load.interval[0] < 0 < load.interval[1] for load in loads]) >= 0.9
    assert sum(load.certain for load in loads) <= 1


@pytest.mark.parametrize("share", [(0.0, 0.5), (0.4, 0.6), (0.75, 1.0)])
def test_what_is_there_for_a_part_of_a_run_is_no_load_all_along(
    fitted: CurrentFit, share: tuple[float, float]
) -> None:
    """A push, or something picked up on the way: of its mean mass, a third of the run has none."""
    for seed in (65, 66):
        count = len(make_record(seed).q)
        time = np.arange(count) / count
        part = (time >= share[0]) & (time < share[1])
        assert not load_of(fitted, loaded(fitted, seed, part.astype(float))).certain


def test_too_short_a_run_tells_no_load_all_along(fitted: CurrentFit) -> None:
    """Of one block there are no three parts."""
    assert not load_of(fitted, cut(loaded(fitted, 68), slice(100))).certain


def test_a_joint_that_was_fitted_exactly_tells_no_load(fitted: CurrentFit) -> None:
    """Of too few samples, a fit leaves nothing by which a joint could be weighed."""
    joints = [replace(fitted.joints[0], band_moving=0.0), *fitted.joints[1:]]
    record = loaded(fitted, 69)
    exact = estimate_payload(replace(fitted, joints=joints), record, regressor(record), smooth)
    usual = estimate_payload(fitted, record, regressor(record), smooth)
    assert exact.parameters[0] == pytest.approx(usual.parameters[0], abs=0.1)
    none = [replace(joint, band_moving=0.0) for joint in fitted.joints]
    unknown = estimate_payload(replace(fitted, joints=none), record, regressor(record), smooth)
    np.testing.assert_array_equal(unknown.parameters, 0.0)


# What a mass is worth


@pytest.mark.parametrize(
    ("mass", "std", "least", "growth", "certain"),
    [
        (0.29, 0.05, 0.29, 2.0, False),  # a load exceeds three of its errors
        (0.32, 0.05, 0.32, 2.0, True),
        (2.0, 0.02, 2.0, 50.0, False),  # runs without any load seem to carry half of it
        (-2.0, 0.02, -2.0, 5.0, False),  # no load lifts
        (2.0, 0.02, 0.98, 5.0, False),  # it shows half of it in each part
        (2.0, 0.02, 1.02, 5.0, True),
    ],
)
def test_a_load_is_certain_beyond_its_errors_and_in_every_part(
    mass: float, std: float, least: float, growth: float, certain: bool
) -> None:
    """The errors of the run, as far as those of others grow, and three per cent for the gears."""
    parts = np.array([least, 2.5, 2.5])
    load = judge(PayloadEstimate(np.array([mass, 0.0]), np.array([std, 0.1]), parts), growth)
    error = np.hypot(growth * std, 0.03 * mass)
    assert load.std_error == pytest.approx(error)
    np.testing.assert_allclose(load.interval, [mass - 1.96 * error, mass + 1.96 * error], rtol=1e-4)
    assert load.certain == certain


@pytest.mark.parametrize("paths", [1, 2, 5, 30])
@pytest.mark.parametrize(("errors", "ratio"), [([0.1, 0.2], 3.0), ([0.3, 0.6], 1.0)])
def test_runs_without_load_tell_how_far_their_errors_must_grow(
    errors: list[float], ratio: float, paths: int
) -> None:
    """Of masses in their errors, at least as far as few paths ask for; one path counts as two."""
    masses = np.array([[0.3], [-0.6]])
    factor = stats.t.ppf(0.975, max(1, paths - 1)) / stats.norm.ppf(0.975)
    growth = error_growth(masses, np.array(errors)[:, None], paths)
    assert growth[0] == pytest.approx(ratio * factor, rel=1e-3)


def test_a_load_is_judged_by_the_errors_of_runs_without_one() -> None:
    """Each parameter by its own: masses are off by two errors there, moments by five and none."""
    errors, configured = np.array([0.1, 0.02, 0.04, 0.01]), 0.5
    off = np.array([2.0, 5.0, 0.0, 0.0])
    empty = [PayloadEstimate(sign * off * errors, errors, errors) for sign in (1, -1, 1)]
    carried = PayloadEstimate(np.array([3.6, 0.36, -0.18, 1.08]), errors, np.full(3, 3.6))
    nothing = PayloadEstimate()
    told = judged_load(carried, [*empty, nothing], 1000, configured, may_be_taken=True)
    assert (told.mass, told.configured, told.carried) == (3.6, configured, pytest.approx(4.1))
    assert told.std_error == pytest.approx(np.hypot(2 * 0.1, 0.03 * 3.6), rel=1e-2)
    np.testing.assert_allclose(told.center_of_mass, [0.1, -0.05, 0.3])
    random = np.random.default_rng(0)
    moments = carried.parameters[1:] + random.normal(size=(100_000, 3)) * errors[1:] * [5, 1, 1]
    masses = 3.6 + told.std_error * random.normal(size=100_000)
    spread = (moments / masses[:, None]).std(axis=0)
    np.testing.assert_allclose(told.center_of_mass_std, spread, rtol=0.03)
    assert told.taken
    assert not judged_load(carried, empty, 1000, configured, may_be_taken=False).taken
    doubted = judged_load(carried, empty, 2, configured, may_be_taken=True)  # of two paths
    assert not doubted.taken
    assert np.isnan([*doubted.center_of_mass, *doubted.center_of_mass_std]).all()


def test_a_run_that_does_not_tell_a_load_says_nothing_of_the_others_errors() -> None:
    """One joint moves: its mass is as unknown as before, and not a hundred kilograms of error."""
    masses, errors = np.array([[0.04], [-0.04]]), np.array([[0.01], [0.01]])
    told = error_growth(masses, errors, paths=30)
    blind = np.append(masses, [[0.3]], axis=0), np.append(errors, [[99.999]], axis=0)
    np.testing.assert_allclose(error_growth(*blind, paths=30), told, rtol=1e-3)


def test_runs_without_errors_grow_none() -> None:
    """As of a single block under a fit without replicates."""
    assert np.isfinite(error_growth(np.ones((2, 1)), np.zeros((2, 1)), paths=5)).all()


def test_a_fit_without_a_path_errs_at_least_as_the_one_to_all(fitted: CurrentFit) -> None:
    """It is kept without its replicates; those of the other fit stand for them."""
    record = with_noise(make_record(53), 53)
    joints = [
        replace(j, estimate=replace(j.estimate, replicates=j.estimate.replicates[:1]))
        for j in fitted.joints
    ]
    kept = replace(fitted, joints=tuple(joints))
    own, other = (
        estimate_payload(fit, record, regressor(record), smooth, fitted) for fit in (kept, fitted)
    )
    np.testing.assert_allclose(own.std_error, other.std_error)


def test_a_few_wild_draws_do_not_set_the_error(fitted: CurrentFit) -> None:
    """Some draws of recordings leave out all that determines a friction parameter."""

    def wild(values: np.ndarray) -> np.ndarray:
        return np.where(np.arange(len(values))[:, None] % 20, values, 30 * values)

    joints = [
        replace(j, estimate=replace(j.estimate, replicates=wild(j.estimate.replicates)))
        for j in fitted.joints
    ]
    record = with_noise(make_record(53), 53)
    tame, torn = (
        estimate_payload(fit, record, regressor(record), smooth).std_error[0]
        for fit in (fitted, replace(fitted, joints=tuple(joints)))
    )
    assert torn < 1.5 * tame


def test_a_mass_that_motion_does_not_tell_is_stated_as_unknown(fitted: CurrentFit) -> None:
    record = with_noise(make_record(54), 54)
    blind = regressor(record) * [0, 1, 1]
    load = judge(estimate_payload(fitted, record, blind, smooth), 1.0)
    assert load.interval[0] < -100 < 100 < load.interval[1]
    assert not load.certain
    still = replace(record, qd=np.zeros_like(record.qd))
    load = load_of(fitted, still)
    assert load.interval[0] < -100 < 100 < load.interval[1]
    assert not load.certain


def test_a_joints_gain_is_by_least_squares_with_a_prior() -> None:
    """Of 0 ± 30 %, with the noise of what is left over, on so many independent values."""
    random, time = np.random.default_rng(0), np.arange(0, 40, 0.02)[:, None]
    load = np.array([0.5, 25, 15, 3, 1, 0.0]) * np.sin(0.5 * time + np.arange(6))
    left = 0.2 * load + 5.0 * random.normal(size=load.shape)
    left[50:60] = np.nan
    known = np.isfinite(left).all(axis=1)
    share = known.sum() / 40  # of samples to independent values
    noise = left[known].var(axis=0)
    product, square = (left * load)[known].sum(axis=0), (load**2)[known].sum(axis=0)
    expected = product / (square + share * noise / 0.3**2)
    np.testing.assert_allclose(joint_gains(left, load, count=40), expected, rtol=1e-9)
    np.testing.assert_allclose(joint_gains(left, load, 0), joint_gains(left, load, 1))
    assert (joint_gains(left, load, 1)[:5] < joint_gains(left, load, 2)[:5]).all()
    assert (joint_gains(np.full_like(left, np.nan), load, count=20) == 0).all()
