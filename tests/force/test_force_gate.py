"""The gate and the wrench behind it, on made-up torques whose contacts are known."""

from dataclasses import replace

import numpy as np
import pytest

from tests.made_up_torques import (
    FLANGE,
    MODEL,
    PERIOD,
    PRIOR,
    WRIST,
    Free,
    between,
    free_run,
    torque_of,
    unnoticed,
)
from ur5lib.force.contact_prior import ContactPrior
from ur5lib.force.external_torque import JointState
from ur5lib.force.force_input import Gears, mean_stiction_torque
from ur5lib.force.gate import Observations, TorqueVariances, find_contacts, quiet_force
from ur5lib.force.missed_contacts import MISSED_DEVIATIONS, missed_contacts, probability_while_shut
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.wrench_estimate import (
    StretchEstimate,
    WrenchEstimate,
    contact_spans,
)
from ur5lib.robots.description import Robot
from ur5lib.timeseries.metrics import coverage, slope
from ur5lib.timeseries.segments import spans

AXES = np.eye(3)
SIZES = [5.0, 30.0, 80.0]  # N
TOOL = np.array([0.0, 0.0, 0.15])  # m, frame 6: the tip of a tool


def probability(estimate: WrenchEstimate) -> np.ndarray:
    return 1 / (1 + np.exp(-estimate.log_odds))


def contacts(estimate: WrenchEstimate) -> list[tuple[int, int]]:
    return spans(probability(estimate), 0.5, 0.1)


def push(run: Free, axis: int, size: float, start: float, end: float) -> np.ndarray:
    """A wrench (N, 6) of a force along one axis."""
    return run.wrench(size * between(run.time, start, end)[:, None] * AXES[axis])


# Found where there is one, none made up


@pytest.mark.parametrize("moving", [True, False], ids=["moving", "resting"])
@pytest.mark.parametrize("seed", range(3))
def test_without_contact_none_is_made_up(ur5: Robot, seed: int, moving: bool) -> None:
    estimate = free_run(ur5, seed, moving=moving).estimate()
    assert (probability(estimate) > 0.5).mean() < 0.01
    assert np.abs(estimate.wrench[:, :3]).mean() < 0.3
    assert (np.abs(estimate.wrench) <= 1.96 * estimate.std).mean() >= 0.97
    assert (estimate.least_squares[probability(estimate) < 0.1] == 0).all()


@pytest.mark.parametrize("axis", range(3))
def test_a_push_of_30_n_is_found(ur5: Robot, axis: int) -> None:
    run = free_run(ur5, seed=10 + axis)
    wrench = push(run, axis, 30.0, 12.0, 13.5)
    estimate = run.pushed(wrench).estimate()
    ((first, last),) = contacts(estimate)
    np.testing.assert_allclose(run.time[[first, last]], [12.0, 13.5], atol=0.3)
    during = (run.time > 12.2) & (run.time < 13.3)
    assert slope(estimate.wrench[during], wrench[during])[axis] == pytest.approx(1, abs=0.25)
    assert coverage(estimate.wrench, estimate.std, wrench)[:3].min() > 0.9


def test_a_push_at_rest_is_found_and_so_is_the_next(ur5: Robot) -> None:
    """Between the two nothing is, though the joints wander by a third of their friction."""
    run = free_run(ur5, seed=20, moving=False)
    assert (run.states == JointState.STILL).all()
    wrench = push(run, 2, 40.0, 8.0, 10.0) + push(run, 2, -40.0, 15.0, 17.0)
    wander = 0.3 * MODEL.breakaway * between(run.time, 10.0, 15.0)[:, None]
    touched = run.pushed(wrench)
    estimate = replace(touched, torque=touched.torque + wander).estimate()
    assert len(contacts(estimate)) == 2
    pause = (run.time > 10.5) & (run.time < 14.5)
    assert (probability(estimate)[pause] < 0.5).all()
    assert np.abs(estimate.wrench[pause, :3]).mean() < 0.5
    held = coverage(estimate.wrench[pause], estimate.std[pause], wrench[pause])
    assert held[:3].min() > 0.95


@pytest.fixture
def repeats() -> ResidualModel:
    """An arm that repeats at rest far better than its friction."""
    still = (np.arange(5) == JointState.STILL)[:, None]
    return replace(
        MODEL,
        spread=np.where(still, 0.1 * MODEL.breakaway, MODEL.spread),
        change=np.where(still, 0.05 * MODEL.breakaway, MODEL.change),
    )


@pytest.mark.parametrize("axis", range(3))
def test_the_band_holds_what_stiction_takes_of_a_push(
    ur5: Robot, repeats: ResidualModel, axis: int
) -> None:
    """At rest each joint's friction bears a part of it, of which the motor feels nothing."""
    run = free_run(ur5, seed=90, moving=False, scale=0.05)
    wrench = push(run, axis, 60.0, 8.0, 11.0)
    whole = torque_of(run.jacobian, wrench)
    most = MODEL.stiction * MODEL.breakaway
    felt = replace(run, torque=run.torque + whole - np.clip(whole, -most, most))
    estimate = felt.estimate(model=repeats)
    during = (run.time > 8.2) & (run.time < 10.8)
    held = coverage(estimate.wrench[during], estimate.std[during], wrench[during])
    assert held[:3].min() > 0.9


def test_what_stiction_may_take_varies_about_its_mean(ur5: Robot) -> None:
    """Of a share of the breakaway torque as second moment, the mean's square is no variance."""
    run = free_run(ur5, seed=90, seconds=16, moving=False)
    run = run.pushed(push(run, 2, 60.0, 8.0, 11.0))
    estimate, observations = (
        run.estimate(),
        Observations.of(run.input(), run.jacobian, MODEL, PRIOR),
    )
    _, background = find_contacts(observations)
    largest = mean_stiction_torque(np.full(6, np.inf), MODEL.breakaway, MODEL.stiction)
    taken = (MODEL.stiction * MODEL.breakaway) ** 2 - largest**2
    during = (run.time > 8.2) & (run.time < 10.8)
    slow = np.linalg.diagonal(background.covariance)[during]
    variance = observations.noise.quick[during] + slow + taken
    J_v = run.jacobian[during, :3]
    # cov F = (J_v S⁻¹ J_vᵀ)⁻¹, of least squares
    covariance = np.linalg.inv((J_v / variance[:, None]) @ J_v.mT)
    std = np.sqrt(np.linalg.diagonal(covariance))
    np.testing.assert_allclose(estimate.least_squares_std[during, :3], std, rtol=1e-6)


@pytest.mark.parametrize("seed", [20, 21])
def test_joints_that_wander_after_a_touch_are_no_contact(
    ur5: Robot, repeats: ResidualModel, seed: int
) -> None:
    """By a third of their friction."""
    run = free_run(ur5, seed, moving=False, scale=0.1)
    side = np.random.default_rng(seed).choice([-1, 1], 6)
    wander = 0.3 * side * MODEL.breakaway * between(run.time, 10.0, 12.0)[:, None]
    touched = run.pushed(push(run, 2, 40.0, 8.0, 10.0))
    estimate = replace(touched, torque=touched.torque + wander).estimate(model=repeats)
    ((_, last),) = contacts(estimate)
    assert run.time[last] < 10.5


@pytest.mark.parametrize("share", [0.3, 0.9])
def test_a_release_makes_no_contact_of_its_own(ur5: Robot, share: float) -> None:
    """After a push a joint springs back by a part of its dry friction, for a quarter second."""
    run = free_run(ur5, seed=21, moving=False)
    rebound = -share * MODEL.breakaway * between(run.time, 10.0, 10.25)[:, None]
    touched = run.pushed(push(run, 2, 40.0, 8.0, 10.0))
    estimate = replace(touched, torque=touched.torque + rebound).estimate()
    ((_, last),) = contacts(estimate)
    assert run.time[last] < 10.6


# Noise


def test_noise_is_the_sum_of_what_makes_it() -> None:
    """Of the model, and of what a load was misjudged by."""
    states = np.array([[JointState.MOVING] * 6, [JointState.STILL] * 6])
    doubt = np.arange(12.0).reshape(2, 6)
    noise = TorqueVariances.of(states, MODEL, doubt)
    still = np.array([[0.0], [1.0]])
    quick, spread, hidden = noise.quick, noise.spread, noise.hidden
    rows = [JointState.MOVING, JointState.STILL]
    np.testing.assert_allclose(quick, MODEL.change[rows] ** 2 + 0.3 * doubt**2)
    np.testing.assert_allclose(spread, MODEL.spread[rows] ** 2 + doubt**2)
    taken = np.where(still, MODEL.stiction, MODEL.rubbing) * MODEL.breakaway
    np.testing.assert_allclose(hidden, taken**2)
    np.testing.assert_array_equal(noise.still, np.repeat(still > 0, 6, axis=1))


def backgrounds(run: Free, prior: ContactPrior) -> np.ndarray:
    """Variance (N, 6) of the background."""
    seen = Observations.of(run.input(), run.jacobian, MODEL, prior)
    return np.linalg.diagonal(find_contacts(seen)[1].covariance)


def test_a_push_draws_anew_what_friction_holds_at_rest(ur5: Robot) -> None:
    """The more, the shorter pushes are; not in motion, and not where none came."""
    for moving in (True, False):
        free = free_run(ur5, seed=23, seconds=12.0, moving=moving)
        run = free.pushed(push(free, 2, 80.0, 5.0, 7.0))
        during, away = (between(run.time, *part) > 0 for part in ((5.5, 6.5), (0.5, 2.0)))
        short, long = (
            backgrounds(run, replace(PRIOR, duration=duration)) for duration in (0.5, 5.0)
        )
        np.testing.assert_allclose(short[away], long[away], rtol=0.05)
        if moving:
            np.testing.assert_allclose(short, long, rtol=0.05)
        else:
            assert (short[during] > 1.5 * long[during]).all()


def test_what_stiction_holds_does_not_follow_a_push(ur5: Robot) -> None:
    """At rest a free arm's torque stays where it was: a push of 15 N is none of its drift."""
    run = free_run(ur5, seed=23, seconds=12.0, moving=False, scale=0.1)
    estimate = run.pushed(push(run, 2, 15.0, 5.0, 7.0)).estimate()
    during, before = between(run.time, 5.2, 6.8) > 0, run.time < 4.5
    assert probability(estimate)[during].mean() > 0.92
    assert probability(estimate)[before].max() < 0.1


# A sustained push, of all sizes


@pytest.mark.parametrize(("axis", "off"), [(0, FLANGE), (1, TOOL), (2, TOOL)], ids=["x", "y", "z"])
def test_a_sustained_push_is_told_at_any_size(ur5: Robot, axis: int, off: np.ndarray) -> None:
    run = free_run(ur5, seed=30 + axis)
    on = between(run.time, 5.0, 20.0)
    told = []
    for size in SIZES:
        wrench = run.wrench(size * on[:, None] * AXES[axis], off)
        estimate = run.pushed(wrench).estimate()
        told.append(estimate.wrench[on > 0, axis].mean())
        std = unnoticed(estimate, run.jacobian, run.states, MODEL)
        during = estimate.wrench[on > 0], std[on > 0], wrench[on > 0]
        assert coverage(*during)[:3].min() >= 0.9, size
        assert coverage(estimate.wrench, std, wrench)[:3].min() >= 0.9, size
    ratio = np.array(SIZES) @ told / (np.array(SIZES) @ SIZES)
    assert 0.9 <= ratio <= 1.1


def test_a_weak_push_that_lasts_is_not_taken_for_background(ur5: Robot) -> None:
    """10 N along z for 15 s, of which joints show about what they stray by."""
    told = []
    for seed in (30, 31, 32):
        run = free_run(ur5, seed)
        estimate = run.pushed(push(run, 2, 10.0, 5.0, 20.0)).estimate()
        told.append(estimate.wrench[between(run.time, 5.0, 20.0) > 0, 2].mean())
    assert 5 < np.mean(told) < 12


@pytest.mark.parametrize(("moving", "factor"), [(True, 5.0), (False, 0.2)])
def test_the_answer_is_not_the_priors(ur5: Robot, moving: bool, factor: float) -> None:
    """Its force times or divided by five moves no force in contact beyond the stated band."""
    prior = replace(PRIOR, force=factor * PRIOR.force)
    for axis in range(3):
        run = free_run(ur5, seed=40 + axis, moving=moving)
        touched = run.pushed(push(run, axis, 50.0, 10.0, 14.0))
        usual, other = touched.estimate(), touched.estimate(prior)
        during = (run.time > 10) & (run.time < 14)
        moved = np.abs(other.wrench - usual.wrench)[during, :3]
        assert (moved <= 1.96 * usual.std[during, :3]).all()


def gears_of(run: Free, loss: float) -> Gears:
    """Gears that carry 20 Nm, lose so much per Nm, and rub with 5 Nm."""
    turning = np.sign(run.qd)
    return Gears(np.full_like(run.qd, 20.0), loss * turning, 5.0 * turning)


def test_what_gears_lose_of_a_contact_is_given_back(ur5: Robot) -> None:
    run = free_run(ur5, seed=50, scale=0.2)
    during, gears = between(run.time, 11.0, 14.0) > 0, gears_of(run, 0.15)
    wrench = push(run, 0, 80.0, 10.0, 15.0)
    felt = replace(run, torque=run.torque + gears.felt(torque_of(run.jacobian, wrench)))
    wrong, right = (
        np.abs(felt.estimate(gears=own).wrench - wrench)[during, :3].mean() for own in (None, gears)
    )
    assert right < 3
    assert wrong > 2 * right


@pytest.mark.parametrize("scale", [-0.15, 0.15])
def test_a_run_that_rubs_otherwise_is_not_touched(ur5: Robot, scale: float) -> None:
    """All joints rub more, or less, than in the fit; a push in that run is told all the same."""
    run = free_run(ur5, seed=51, scale=0.3)
    gears = gears_of(run, 0.0)
    friction = 4 * gears.friction  # Nm: several times what is left without contact
    gears = replace(gears, friction=friction)
    warm = replace(run, torque=run.torque - scale * friction)
    assert contacts(warm.estimate())
    assert not contacts(warm.estimate(gears=gears))
    wrench = push(run, 2, 60.0, 10.0, 12.0)
    touched = warm.pushed(wrench).estimate(gears=gears)
    assert len(contacts(touched)) == 1
    inside = between(run.time, 10.3, 11.7) > 0
    assert coverage(touched.wrench[inside], touched.std[inside], wrench[inside])[:3].min() > 0.9


# Sampling


@pytest.mark.parametrize("axis", [0, 2])
def test_results_do_not_depend_on_the_sample_rate(ur5: Robot, axis: int) -> None:
    """At 125 and at 500 Hz, of one and the same recording."""
    fast = free_run(ur5, seed=60, seconds=16.0, period=0.002)
    touched = fast.pushed(push(fast, axis, 40.0, 8.0, 10.0))
    slow = Free(*(values[::4] for values in vars(touched).values()))
    one, other = touched.estimate(), slow.estimate()
    for name in ("wrench", "std", "background", "least_squares"):
        often, seldom = getattr(one, name)[::4], getattr(other, name)
        size = np.abs(seldom).max()
        np.testing.assert_allclose(often, seldom, atol=0.01 * size, err_msg=name)
    np.testing.assert_allclose(probability(one)[::4], probability(other), atol=0.01)


def test_a_rate_that_the_step_does_not_divide(ur5: Robot) -> None:
    """At 100 Hz samples are weighed each 30 ms, at 125 Hz each 32."""
    fast = free_run(ur5, seed=61, seconds=16.0, period=0.002)
    touched = fast.pushed(push(fast, 1, 40.0, 8.0, 10.0))
    means = []
    for every in (4, 5):
        part = Free(*(values[::every] for values in vars(touched).values()))
        estimate, during = part.estimate(), (part.time > 8.2) & (part.time < 9.8)
        means.append((estimate.wrench[during, :3].mean(axis=0), estimate.std[during].mean(axis=0)))
    np.testing.assert_allclose(means[0][0], means[1][0], atol=0.03 * 40)
    np.testing.assert_allclose(means[0][1], means[1][1], rtol=0.05)


# Gaps, missing samples, singularities


def test_a_gap_is_a_new_recording(ur5: Robot) -> None:
    run = free_run(ur5, seed=70, seconds=12.0)
    touched = run.pushed(push(run, 2, 40.0, 8.0, 10.0))
    count = len(run.time)
    segment = np.repeat([0, 1], [count // 2, count - count // 2])
    both, half = touched.estimate(segment=segment), slice(count // 2, None)
    alone = Free(*(values[half] for values in vars(touched).values())).estimate()
    for name in {*StretchEstimate._fields} - {"link", "off_flange"}:  # told in contacts alone
        own, expected = getattr(both, name)[half], getattr(alone, name)
        np.testing.assert_allclose(own, expected, err_msg=name)


def test_what_was_not_measured_in_a_contact_is_not_known_to_be_zero(ur5: Robot) -> None:
    run = free_run(ur5, seed=71)
    touched = run.pushed(push(run, 2, 60.0, 10.0, 14.0))
    holes = touched.torque.copy()
    hole, beside = (run.time >= 11.5) & (run.time < 12), (run.time > 12.5) & (run.time < 13.5)
    holes[hole] = np.nan
    estimate = replace(touched, torque=holes).estimate()
    assert np.isfinite(estimate.std).all()
    held = np.abs(estimate.wrench[hole, 2] - 60) <= 1.96 * estimate.std[hole, 2]
    assert held.all()
    assert estimate.std[hole, 2].min() > 2 * estimate.std[beside, 2].max()
    whole = touched.estimate()
    np.testing.assert_allclose(estimate.wrench[beside], whole.wrench[beside], atol=2.0)


def test_where_the_pose_is_unknown_nothing_is_told(ur5: Robot) -> None:
    run = free_run(ur5, seed=72, seconds=10)
    J = run.jacobian.copy()
    J[100:110] = np.nan
    estimate = replace(run, jacobian=J).estimate()
    for name in {*StretchEstimate._fields} - {"link", "off_flange"}:  # told in contacts alone
        values = getattr(estimate, name)
        unknown = np.isnan(values.reshape(len(values), -1)).all(axis=1)
        np.testing.assert_array_equal(np.flatnonzero(unknown), np.arange(100, 110))
        assert np.isfinite(np.delete(values, np.arange(100, 110), axis=0)).all()


def test_between_the_samples_used_a_pose_is_unknown_beside_an_unknown_one(ur5: Robot) -> None:
    run = free_run(ur5, seed=72, seconds=4, period=0.008)
    J = run.jacobian.copy()
    J[99:102] = np.nan  # the sample used is 100
    wrench = replace(run, jacobian=J).estimate().wrench
    np.testing.assert_array_equal(np.flatnonzero(np.isnan(wrench).any(axis=1)), range(97, 104))


def test_through_a_singularity_no_force_explodes(ur5: Robot) -> None:
    run = free_run(ur5, seed=73, around=WRIST)
    wrench = push(run, 1, 40.0, 8.0, 12.0)
    estimate = run.pushed(wrench).estimate()
    assert np.isfinite(estimate.wrench).all()
    assert np.linalg.norm(estimate.wrench[:, :3], axis=1).max() < 120
    assert coverage(estimate.wrench, estimate.std, wrench)[:3].min() > 0.9


def test_a_force_on_a_resting_arm_is_averaged_over_its_filter_s_time(ur5: Robot) -> None:
    """Its steps from sample to sample are far smaller than in motion."""
    steps = []
    for moving in (True, False):
        run = free_run(ur5, seed=3, moving=moving)
        found = run.pushed(push(run, 2, 60.0, 4.0, 8.0)).estimate().wrench[:, 2]
        steps.append(np.diff(found[(run.time > 4.8) & (run.time < 7.2)]).std())
    assert steps[1] < 0.3 * steps[0]


# The gate alone


def test_a_quiet_force_is_a_fifth_of_what_a_standard_deviation_is_worth() -> None:
    """By the force's columns alone; of another arm, by the median over samples."""
    jacobian = np.zeros((3, 6, 6))
    jacobian[:, :3, :3] = np.array([0.5, 1.0, 4.0])[:, None, None] * np.eye(3)
    jacobian[:, 3:] = 100.0
    variance = np.full((3, 6), 9.0)
    # each axis turns one joint by 1 m, so that a mean axis has an information of 1 / 9
    assert quiet_force(jacobian, variance) == pytest.approx(0.2 * 3.0)


def test_a_contact_hides_in_stiction_only_while_the_whole_arm_rests() -> None:
    random, still = np.random.default_rng(0), np.array([[True] * 6, [True] * 5 + [False]])
    quick, spread, hidden = random.uniform(1, 2, (3, 2, 6))
    hiding = TorqueVariances(quick, spread, hidden, still).hiding()
    np.testing.assert_array_equal(hiding, [hidden[0], spread[1]])


def test_what_is_left_of_a_load_may_be_no_contact(ur5: Robot) -> None:
    """20 Nm of load, misjudged by a tenth from 8 s on: with that doubt, nothing touches the arm."""
    run = free_run(ur5, seed=82, scale=0.3)
    load = np.array([0.0, 40.0, 30.0, 5.0, 0.0, 0.0]) * between(run.time, 8.0, 24.0)[:, None]
    misjudged = run.torque + 0.1 * load
    sure, doubted = (
        run.estimate(torque=misjudged, doubt=doubt) for doubt in (None, 0.1 * np.abs(load))
    )
    assert probability(doubted).max() < 0.5
    assert (doubted.std[:, :3].mean(axis=0) > sure.std[:, :3].mean(axis=0)).all()
    assert coverage(doubted.wrench, doubted.std, np.zeros_like(doubted.wrench))[:3].min() > 0.95


def test_the_band_of_a_shut_gate_is_that_of_a_mixture(ur5: Robot) -> None:
    """Forces drawn from it are inside in 95 of 100 cases: few are of a missed contact."""
    run, random = free_run(ur5, seed=82, seconds=6.0, scale=0.05), np.random.default_rng(0)
    for found in (0, 60):
        estimate = run.pushed(push(run, 2, 60.0, 1.0, 1.0 + found * PERIOD)).estimate()
        shut = (estimate.wrench == 0).all(axis=1)
        hiding = TorqueVariances.of(run.states, MODEL, np.zeros(run.torque.shape)).hiding()
        share, variance = missed_contacts(run.jacobian, MISSED_DEVIATIONS**2 * hiding, PRIOR)
        quiet = Observations.of(run.input(), run.jacobian, MODEL, PRIOR).quiet
        chance = probability_while_shut(share, ~shut, PERIOD, PRIOR)
        drawn = random.uniform(size=(400, *chance.shape)) < chance
        std = np.where(drawn, np.sqrt(variance), np.sqrt(np.diag(quiet)))
        force = std * random.normal(size=drawn.shape)
        inside = np.abs(force) <= 1.96 * estimate.std
        np.testing.assert_allclose(inside[:, shut].mean(axis=(0, 1)), 0.95, atol=0.005)


def test_where_contacts_are_found_more_are_missed(ur5: Robot) -> None:
    """The band of a shut gate widens with the time in contact, and is a free arm's without any."""
    run = free_run(ur5, seed=83, moving=False, scale=0.1)
    free = run.estimate().std[-100:, :3]
    np.testing.assert_array_less(free, PRIOR.force / 5)
    wrench = sum(push(run, 2, 60.0, start, start + 2.0) for start in (3.0, 8.0, 13.0))
    touched = run.pushed(np.asarray(wrench)).estimate()
    assert len(contacts(touched)) == 3
    np.testing.assert_array_less(1.2 * free, touched.std[-100:, :3])


@pytest.mark.parametrize(("most", "found"), [(0.49, False), (0.5, True)])
def test_a_contact_is_from_even_odds_to_one_in_ten_and_a_margin(most: float, found: bool) -> None:
    """Of 0.15 s at both ends, within the record."""
    probability = np.zeros(300)
    probability[100:110], probability[110:115], probability[115] = 0.11, most, 0.1
    assert contact_spans(probability, 0.01) == [(85, 130)] * found
    probability[:2] = probability[125:127] = most
    assert contact_spans(probability, 0.01) == [(0, 17), (85, 142)] * found
