"""F̂ᵐᵃᵖ and its band, where the wrench is known: identities first, then simulated recordings."""

from itertools import pairwise

import numpy as np
import pytest
import torch

from ur5lib.dynamics.arm import build_arm
from ur5lib.dynamics.kinematics import jacobian
from ur5lib.force.background import smooth
from ur5lib.force.current_based import wrench_from_torque
from ur5lib.force.external_torque import joint_states
from ur5lib.force.hidden_markov import log_odds, probability
from ur5lib.force.hypotheses import ContactPrior
from ur5lib.force.map_estimate import regularised_wrench
from ur5lib.force.residual_model import ResidualModel
from ur5lib.force.wrench_estimate import WrenchEstimate, estimate_wrench
from ur5lib.metrics import coverage
from ur5lib.robots.description import Robot

RANDOM = np.random.default_rng(0)
PERIOD = 0.05
PRIOR = ContactPrior()
MODEL = ResidualModel(  # of the size found on the thesis's UR5
    spread=np.array([[1.4, 1.3, 1.7, 0.7, 0.4, 0.7], [4, 6, 5, 2, 1, 3], [4, 4, 4, 2, 0.7, 3]]),
    change=np.array(
        [[1, 0.8, 0.8, 0.3, 0.2, 0.3], [2, 4, 3, 0.8, 0.6, 1.5], [1, 1, 1, 0.3, 0.2, 0.5]]
    ),
    rate=np.array([0.25, 0.06, 0.033]),
    correlation=np.eye(6),
    independent=0.25,
)
REGULAR = np.array([0.3, -1.2, 1.4, -1.0, 1.2, 0.4])
ELBOW, WRIST = REGULAR * [1, 1, 0, 1, 1, 1], REGULAR * [1, 1, 1, 1, 0, 1]


def jacobians(ur5: Robot, q: np.ndarray) -> np.ndarray:
    return jacobian(build_arm(ur5, "C"), torch.tensor(q)).numpy()


def torque_of(J: np.ndarray, wrench: np.ndarray) -> np.ndarray:
    return (J.mT @ wrench[..., None])[..., 0]


# F̂ᵐᵃᵖ of one sample


def test_certain_torques_give_the_exact_wrench(ur5: Robot) -> None:
    """With little noise and a wide prior, F̂ᵐᵃᵖ is J^-T tau."""
    J = jacobians(ur5, REGULAR + RANDOM.uniform(-0.3, 0.3, (50, 6)))
    torque = RANDOM.normal(size=(50, 6))
    noise, prior = np.tile(1e-10 * np.eye(6), (50, 1, 1)), 1e6 * np.eye(6)
    exact = wrench_from_torque(J, torque, 1e-6)
    estimate = regularised_wrench(torque, J, noise, prior)
    np.testing.assert_allclose(estimate.mean, exact, rtol=1e-4, atol=1e-4)


def test_it_is_the_information_form(ur5: Robot) -> None:
    """(J S^-1 J^T + P^-1)^-1 J S^-1 tau, by the matrix inversion lemma."""
    J = jacobians(ur5, RANDOM.uniform(-3, 3, (50, 6)))
    torque = RANDOM.normal(size=(50, 6))
    root = RANDOM.normal(size=(50, 6, 6))
    noise, prior = root @ root.mT + np.eye(6), PRIOR.in_contact()
    weighted = J @ np.linalg.inv(noise)
    covariance = np.linalg.inv(weighted @ J.mT + np.linalg.inv(prior))
    estimate = regularised_wrench(torque, J, noise, prior)
    np.testing.assert_allclose(estimate.covariance, covariance, atol=1e-8)
    expected = (covariance @ weighted @ torque[..., None])[..., 0]
    np.testing.assert_allclose(estimate.mean, expected, atol=1e-8)


def test_without_torques_the_prior_stays() -> None:
    torque = np.array([[1.0, 2, 3, 4, 5, np.nan]])
    eye = np.eye(6)[None]
    estimate = regularised_wrench(torque, eye, eye, PRIOR.in_contact())
    assert (estimate.mean == 0).all()
    np.testing.assert_array_equal(estimate.covariance[0], PRIOR.in_contact())


@pytest.mark.parametrize("pose", [ELBOW, WRIST])
def test_at_a_singularity_the_unseen_keeps_its_prior(ur5: Robot, pose: np.ndarray) -> None:
    J = jacobians(ur5, pose[None])
    direction = np.linalg.svd(J[0])[0][:, -1]
    noise = np.eye(6)[None] * 0.01
    prior = 100.0 * np.eye(6)
    estimate = regularised_wrench(np.full((1, 6), 5.0), J, noise, prior)
    assert direction @ estimate.covariance[0] @ direction == pytest.approx(100, rel=1e-6)
    assert abs(direction @ estimate.mean[0]) < 1e-6
    assert np.isnan(wrench_from_torque(J, np.full((1, 6), 5.0), 1e-6)).all()


def test_force_only_has_no_moments(ur5: Robot) -> None:
    J = jacobians(ur5, REGULAR[None])
    noise = np.eye(6)[None]
    force_only = ContactPrior(lever=0).in_contact()
    estimate = regularised_wrench(np.ones((1, 6)), J, noise, force_only)
    assert (estimate.mean[0, 3:] == 0).all()
    assert np.abs(estimate.mean[0, :3]).min() > 0


# Background and chain


def test_the_smoother_is_the_normal_distribution_it_stands_for() -> None:
    """Mean and covariance given all measurements, by one large linear system."""
    count, decay = 12, RANDOM.uniform(0.5, 0.99, (12, 6))
    spread = np.tile(np.diag(RANDOM.uniform(1, 4, 6)), (count, 1, 1))
    noise = np.tile(np.diag(RANDOM.uniform(0.5, 2, 6)), (count, 1, 1))
    measured = RANDOM.normal(size=(count, 6))
    measured[4:6] = np.nan
    smoothed = smooth(measured, noise, spread, decay)
    for joint in range(6):
        between = np.eye(count)
        for s, t in np.ndindex(count, count):
            between[s, t] = decay[min(s, t) + 1 : max(s, t) + 1, joint].prod()
        prior = spread[0, joint, joint] * between
        known = np.isfinite(measured[:, joint])
        total = prior[np.ix_(known, known)] + noise[0, joint, joint] * np.eye(known.sum())
        gain = prior[:, known] @ np.linalg.inv(total)
        np.testing.assert_allclose(smoothed.mean[:, joint], gain @ measured[known, joint])
        variance = np.diag(prior - gain @ prior[known])
        np.testing.assert_allclose(smoothed.covariance[:, joint, joint], variance)


def test_the_chain_is_bayes_rule_over_all_histories() -> None:
    count, start, stop = 6, 0.1, 0.3
    evidence = RANDOM.normal(0, 2, count)
    total = np.zeros((count, 2))
    for history in np.ndindex(*([2] * count)):
        weight = (start if history[0] else stop) / (start + stop)
        for before, after in pairwise(history):
            change = stop if before else start
            weight *= change if before != after else 1 - change
        weight *= np.exp(evidence @ np.array(history))
        total[np.arange(count), history] += weight
    odds = log_odds(evidence, start, stop)
    np.testing.assert_allclose(odds, np.log(total[:, 1] / total[:, 0]))
    np.testing.assert_allclose(probability(odds), total[:, 1] / total.sum(axis=1))


def test_overwhelming_evidence_overflows_nothing() -> None:
    odds = log_odds(np.array([1e4, -1e4, 1e4]), 0.01, 0.1)
    assert np.isfinite(odds).all()
    np.testing.assert_allclose(probability(odds), [1, 0, 1], atol=1e-9)


# Simulated recordings: a known wrench, a contact-free torque as MODEL has it, and gears' loss


def simulate(
    ur5: Robot, kind: str, q: np.ndarray, moving: bool, seed: int
) -> tuple[WrenchEstimate, np.ndarray, np.ndarray]:
    """The estimate, the wrench and the external torque of 40 s around a pose."""
    random = np.random.default_rng(seed)
    time = np.arange(0, 40, PERIOD)[:, None]
    phase = random.uniform(0.4, 0.8, 6) * time + random.uniform(0, 6, 6)
    swing = 0.4 * moving
    path, qd = q + swing * np.sin(phase), swing * np.gradient(np.sin(phase), PERIOD, axis=0)
    states = joint_states(qd, np.zeros(len(time), int), PERIOD)
    J = jacobians(ur5, path)
    sizes = random.normal(size=(5, 6)) * PRIOR.in_contact().diagonal() ** 0.5
    wrench = profile(kind, time) * sizes[(time[:, 0] // 8).astype(int)]
    torque = torque_of(J, wrench) + residual(states, random)
    segment = np.zeros(len(time), int)
    estimate = estimate_wrench(torque, J, states, segment, PERIOD, MODEL, PRIOR)
    return estimate, wrench, torque


def profile(kind: str, time: np.ndarray) -> np.ndarray:
    on = (time % 8 > 5) & (time % 8 < 6.5)
    return {
        "none": 0 * time,
        "constant": np.where((time > 16) & (time < 19), 1.0, 0.0),
        "steps": 1.0 * on,
        "sine": 1.4 * on * np.sin(2 * np.pi * (time % 8 - 5) / 1.5),
    }[kind]


def residual(states: np.ndarray, random: np.random.Generator) -> np.ndarray:
    """Slow and quick part of the contact-free torque, as `MODEL` has them."""
    spread, change = (MODEL.deviation(x, states) for x in (MODEL.spread, MODEL.change))
    steady = np.sqrt(np.maximum(spread**2 - change**2, 0))
    slow, quick = random.normal(size=6), random.normal(size=6)
    result = np.empty(states.shape)
    for t in range(len(states)):
        memories = [np.exp(-PERIOD * MODEL.rate[states[t]]), np.exp(-PERIOD / 0.125)]
        slow = memories[0] * slow + np.sqrt(1 - memories[0] ** 2) * random.normal(size=6)
        quick = memories[1] * quick + np.sqrt(1 - memories[1] ** 2) * random.normal(size=6)
        result[t] = steady[t] * slow + change[t] * quick
    return result


@pytest.mark.parametrize("kind", ["constant", "steps", "sine"])
@pytest.mark.parametrize("moving", [True, False], ids=["reversing", "resting"])
def test_a_known_wrench_lies_in_its_band(ur5: Robot, kind: str, moving: bool) -> None:
    """Around a regular pose, and through or at an elbow and a wrist singularity."""
    poses = enumerate([REGULAR, ELBOW, WRIST])
    runs = [simulate(ur5, kind, pose, moving, seed) for seed, pose in poses]
    estimate = np.concatenate([run[0].wrench for run in runs])
    std = np.concatenate([run[0].std for run in runs])
    wrench = np.concatenate([run[1] for run in runs])
    assert np.isfinite(estimate).all()
    assert np.isfinite(std).all()
    assert coverage(estimate, std, wrench)[:3].mean() > 0.9
    assert (np.abs(np.mean(estimate - wrench, axis=0)) < 0.5 * std.mean(axis=0)).all()
    for run in runs:  # no force beyond what the largest torque can be worth
        assert np.linalg.norm(run[0].wrench, axis=1).max() < np.abs(run[2]).max() / 0.1


def test_near_a_singularity_the_band_widens_and_nothing_jumps(ur5: Robot) -> None:
    """Towards the stretched elbow, with the same torque, from far to all the way."""
    angles = np.linspace(1.2, 0, 60)
    q = np.tile(REGULAR, (60, 1))
    q[:, 2] = angles
    J = jacobians(ur5, q)
    noise = np.tile(np.diag(MODEL.change[0] ** 2), (60, 1, 1))
    estimate = regularised_wrench(np.full((60, 6), 2.0), J, noise, PRIOR.in_contact())
    band = np.linalg.eigvalsh(estimate.covariance[:, :3, :3])[:, -1] ** 0.5
    assert band[-1] > band[0]
    assert band[-1] <= PRIOR.force * (1 + 1e-9)
    assert np.abs(np.diff(estimate.mean, axis=0)).max() < 1.0


def test_where_nothing_touches_it_says_so(ur5: Robot) -> None:
    estimate, _, _ = simulate(ur5, "none", REGULAR, True, seed=5)
    assert (probability(estimate.log_odds) > 0.5).mean() < 0.02
    assert np.abs(estimate.wrench[:, :3]).mean() < 0.3


def test_at_rest_stiction_may_hide_a_push(ur5: Robot) -> None:
    """Erratum 12: with no change of torque at all, the band at rest is far wider than in motion."""
    still, _, _ = simulate(ur5, "none", REGULAR, False, seed=6)
    moving, _, _ = simulate(ur5, "none", REGULAR, True, seed=6)
    assert np.median(still.std[:, :3]) > 2.5 * np.median(moving.std[:, :3])


def test_a_gap_is_a_new_recording(ur5: Robot) -> None:
    count = 600
    J = np.tile(jacobians(ur5, REGULAR[None]), (count, 1, 1))
    torque = residual(np.zeros((count, 6), int), RANDOM)
    states, segment = np.zeros((count, 6), int), np.repeat([0, 1], count // 2)
    both = estimate_wrench(torque, J, states, segment, PERIOD, MODEL, PRIOR)
    half = slice(count // 2, None)
    alone = estimate_wrench(
        torque[half], J[half], states[half], segment[half], PERIOD, MODEL, PRIOR
    )
    np.testing.assert_allclose(both.wrench[half], alone.wrench)
    np.testing.assert_allclose(both.log_odds[half], alone.log_odds)


def test_missing_torques_widen_the_band(ur5: Robot) -> None:
    torque = simulate(ur5, "steps", REGULAR, True, seed=7)[2]
    holes = torque.copy()
    holes[100:150] = np.nan
    J = np.tile(jacobians(ur5, REGULAR[None]), (len(torque), 1, 1))
    states, segment = np.zeros(torque.shape, int), np.zeros(len(torque), int)
    estimate = estimate_wrench(holes, J, states, segment, PERIOD, MODEL, PRIOR)
    assert np.isfinite(estimate.std).all()
    assert (estimate.wrench[100:150] == 0).all()


def test_where_the_pose_is_unknown_nothing_is_told(ur5: Robot) -> None:
    torque = simulate(ur5, "steps", REGULAR, True, seed=8)[2]
    J = np.tile(jacobians(ur5, REGULAR[None]), (len(torque), 1, 1))
    J[200:210] = np.nan
    states, segment = np.zeros(torque.shape, int), np.zeros(len(torque), int)
    estimate = estimate_wrench(torque, J, states, segment, PERIOD, MODEL, PRIOR)
    unknown = np.isnan(estimate.wrench).all(axis=1) & np.isnan(estimate.log_odds)
    np.testing.assert_array_equal(np.flatnonzero(unknown), np.arange(200, 210))
    assert np.isfinite(np.delete(estimate.std, np.arange(200, 210), axis=0)).all()
