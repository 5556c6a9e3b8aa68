"""F̂ᵐᵃᵖ of a sample, and the background, by identities."""

import numpy as np
import pytest

from tests.made_up_torques import ELBOW, MODEL, PRIOR, REGULAR, WRIST, jacobians
from ur5lib.force.background import smooth
from ur5lib.force.contact_prior import ContactPrior, typical_force, wrench_covariance
from ur5lib.force.contact_wrench import regularised_wrench
from ur5lib.force.wrench_estimate import smoothed
from ur5lib.robots.description import Robot, load_robot, robot_path

RANDOM = np.random.default_rng(0)


# F̂ᵐᵃᵖ of one sample


def test_it_is_the_information_form(ur5: Robot) -> None:
    """(J S^-1 J^T + P^-1)^-1 J S^-1 tau, by the matrix inversion lemma."""
    J = jacobians(ur5, RANDOM.uniform(-3, 3, (50, 6)))
    torque = RANDOM.normal(size=(50, 6))
    root = RANDOM.normal(size=(50, 6, 6))
    noise, prior = root @ root.mT + np.eye(6), PRIOR.usual()
    weighted = J @ np.linalg.inv(noise)
    covariance = np.linalg.inv(weighted @ J.mT + np.linalg.inv(prior))
    estimate = regularised_wrench(torque, J, noise, prior)
    np.testing.assert_allclose(estimate.covariance, covariance, atol=1e-8)
    expected = (covariance @ weighted @ torque[..., None])[..., 0]
    np.testing.assert_allclose(estimate.mean, expected, atol=1e-8)


def test_without_torques_the_prior_stays() -> None:
    torque = np.array([[1.0, 2, 3, 4, 5, np.nan]])
    eye = np.eye(6)[None]
    estimate = regularised_wrench(torque, eye, eye, PRIOR.usual())
    assert (estimate.mean == 0).all()
    np.testing.assert_array_equal(estimate.covariance[0], PRIOR.usual())


@pytest.mark.parametrize("pose", [ELBOW, WRIST])
def test_at_a_singularity_the_unseen_keeps_its_prior(ur5: Robot, pose: np.ndarray) -> None:
    J = jacobians(ur5, pose[None])
    direction = np.linalg.svd(J[0])[0][:, -1]
    noise = np.eye(6)[None] * 0.01
    prior = 100.0 * np.eye(6)
    estimate = regularised_wrench(np.full((1, 6), 5.0), J, noise, prior)
    assert direction @ estimate.covariance[0] @ direction == pytest.approx(100, rel=1e-6)
    assert abs(direction @ estimate.mean[0]) < 1e-6


def test_force_only_has_no_moments(ur5: Robot) -> None:
    J = jacobians(ur5, REGULAR[None])
    noise = np.eye(6)[None]
    force_only = np.diag([15.0**2] * 3 + [0.0] * 3)
    estimate = regularised_wrench(np.ones((1, 6)), J, noise, force_only)
    assert (estimate.mean[0, 3:] == 0).all()
    assert np.abs(estimate.mean[0, :3]).min() > 0


def test_near_a_singularity_the_band_widens_and_nothing_jumps(ur5: Robot) -> None:
    """Towards the stretched elbow, with the same torque, from far to all the way."""
    angles = np.linspace(1.2, 0, 600)
    q = np.tile(REGULAR, (600, 1))
    q[:, 2] = angles
    J = jacobians(ur5, q)
    noise = np.tile(np.diag(MODEL.change[0] ** 2), (600, 1, 1))
    estimate = regularised_wrench(np.full((600, 6), 2.0), J, noise, PRIOR.usual())
    band = np.linalg.eigvalsh(estimate.covariance[:, :3, :3])[:, -1] ** 0.5
    assert band[-1] > band[0]
    assert band[-1] <= PRIOR.force * (1 + 1e-9)
    assert np.abs(np.diff(estimate.mean, axis=0)).max() < 0.2


def test_a_prior_says_how_large_a_force_and_its_moment_are() -> None:
    covariance = wrench_covariance(20.0, 0.1)
    np.testing.assert_allclose(np.sqrt(np.diag(covariance)), [20, 20, 20, 2, 2, 2])
    prior = ContactPrior(15.0)
    forces = [np.sqrt(own[0, 0]) for own in (prior.usual(), prior.unknown())]
    assert forces == pytest.approx([15.0, 45.0])
    levers = [np.sqrt(own[3, 3] / own[0, 0]) for own in (prior.usual(), prior.unknown())]  # m
    assert levers == pytest.approx([prior.lever] * 2)


@pytest.mark.parametrize(
    ("arm", "force"), [("ur3", 9), ("ur5", 15), ("ur10e", 37), ("ur16e", 47), ("ur20", 59)]
)
def test_a_typical_contact_grows_with_the_payload(arm: str, force: float) -> None:
    """Of an arm without one, with its links' mass."""
    robot = load_robot(robot_path(arm))
    assert typical_force(robot) == pytest.approx(force, abs=0.5)
    unrated = typical_force(robot.model_copy(update={"rated_payload": None}))
    assert 0.5 < unrated / force < 2


def test_a_force_is_averaged_where_the_arm_rests_alone() -> None:
    """A constant one stays, up to the ends of the rest; what moves is no part of the mean."""
    resting, samples = np.zeros(500, bool), 5.0
    resting[100:300] = True
    wrench = np.where(resting[:, None], 30.0, -80.0) * np.ones(6)
    np.testing.assert_allclose(smoothed(wrench, resting, samples), wrench)
    noisy = wrench + RANDOM.normal(size=wrench.shape)
    found = smoothed(noisy, resting, samples)
    np.testing.assert_array_equal(found[~resting], noisy[~resting])
    # white noise under a normal weight of 5 samples: 1 / sqrt(2 √π 5)
    assert (found - wrench)[120:280].std() == pytest.approx(0.24, abs=0.05)


# Background


def test_the_smoother_is_the_normal_distribution_it_stands_for() -> None:
    """Mean and covariance given all measurements, by one large linear system for each joint."""
    count, decay = 12, RANDOM.uniform(0.5, 0.99, (12, 6))
    spread = np.tile(RANDOM.uniform(1, 4, 6), (count, 1))
    noise = np.tile(np.diag(RANDOM.uniform(0.5, 2, 6)), (count, 1, 1))
    measured = RANDOM.normal(size=(count, 6))
    measured[4:6] = np.nan
    friction, scale_std = RANDOM.normal(size=(count, 6)), 0.4
    smoothed = smooth(measured, noise, spread, decay, friction, scale_std)
    for joint in range(6):
        between = np.eye(count)
        for s, t in np.ndindex(count, count):
            between[s, t] = decay[min(s, t) + 1 : max(s, t) + 1, joint].prod()
        own = friction[:, joint]
        prior = spread[0, joint] * between + scale_std**2 * np.outer(own, own)
        known = np.isfinite(measured[:, joint])
        total = prior[np.ix_(known, known)] + noise[0, joint, joint] * np.eye(known.sum())
        gain = prior[:, known] @ np.linalg.inv(total)
        np.testing.assert_allclose(smoothed.mean[:, joint], gain @ measured[known, joint])
        variance = np.diag(prior - gain @ prior[known])
        np.testing.assert_allclose(smoothed.covariance[:, joint, joint], variance)
