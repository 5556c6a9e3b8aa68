"""The wrench of one contact: its limits, and what its size is learnt from."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.made_up_torques import (
    MODEL,
    PRIOR,
    REGULAR,
    between,
    free_run,
    jacobians,
    torque_of,
)
from ur5lib.force.contact_wrench import (
    BREAKAWAY_SHARE,
    STATIC_SPEED,
    at_rest,
    contact_wrench,
    learned_size,
    least_squares_wrench,
    regularised_wrench,
    static_wrench,
    torque_std,
)
from ur5lib.robots.description import Robot
from ur5lib.timeseries.metrics import coverage

COUNT, WORTH = 100, 0.032 / 0.25
LOSSLESS = replace(PRIOR, load_friction=0.0)
NOISE = np.array([1.2, 1.5, 1.0, 0.4, 0.3, 0.3])  # Nm


def contact(
    ur5: Robot, wrench: np.ndarray, seed: int, noise: float = 1.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Torque, Jacobian and noise of 3.2 s around a regular pose."""
    random = np.random.default_rng(seed)
    J = jacobians(ur5, REGULAR + random.uniform(-0.1, 0.1, (COUNT, 6)))
    deviation = noise * NOISE
    torque = torque_of(J, np.tile(wrench, (COUNT, 1))) + deviation * random.normal(size=(COUNT, 6))
    return torque, J, np.tile(np.diag(deviation**2), (COUNT, 1, 1))


def test_a_large_wrench_with_moments_is_what_the_torques_say(ur5: Robot) -> None:
    own = contact(ur5, np.array([300.0, -200, 400, 30, -40, 50]), seed=1, noise=0.01)
    chosen = contact_wrench(*own, WORTH, LOSSLESS).mean
    expected = np.linalg.solve(own[1].mT, own[0][..., None])[..., 0]
    np.testing.assert_allclose(chosen, expected, atol=2.0)


def test_least_squares_are_the_normal_equations(ur5: Robot) -> None:
    """Of the whitened problem, sample by sample, solved by another routine."""
    torque, J, noise = contact(ur5, np.array([10.0, 20, -5, 1, 0, 2]), seed=2)
    plain = least_squares_wrench(torque, J, noise)
    for t in (0, 50, 99):
        root = np.linalg.inv(np.linalg.cholesky(noise[t]))
        columns = root @ J[t, :3].T
        expected = np.linalg.lstsq(columns, root @ torque[t], rcond=None)[0]
        np.testing.assert_allclose(plain.mean[t, :3], expected, rtol=1e-8)
        covariance = np.linalg.inv(columns.T @ columns)
        np.testing.assert_allclose(plain.variance[t, :3], np.diag(covariance))
    assert (plain.mean[:, 3:] == 0).all()


def test_an_axis_that_no_torque_shows_keeps_its_whole_prior(ur5: Robot) -> None:
    """The learnt size is that of the others; along them, a part of what it leaves counts."""
    torque, J, noise = contact(ur5, np.array([10.0, 20, 0, 0, 0, 0]), seed=5)
    J[:, 2] = 0.0
    size = learned_size(torque, J, noise, WORTH, LOSSLESS)
    told = contact_wrench(torque, J, noise, WORTH, LOSSLESS)
    np.testing.assert_allclose(told.variance[:, 2], size[2, 2])
    noisy = regularised_wrench(torque, J, noise, size).covariance
    lever = replace(LOSSLESS, lever=1e-9)
    own = contact_wrench(torque, J, noise, WORTH, lever).variance
    assert (own[:, :2] < np.linalg.diagonal(noisy)[:, :2]).all()


def test_load_friction_widens_the_band_in_proportion(ur5: Robot) -> None:
    """Each joint takes up a tenth of what it carries of a contact: J^-T diag(0.1 J^T F)² J^-1."""
    wrench = np.array([0.0, 2000.0, 0, 100.0, 100.0, 100.0])  # large: its size no longer matters
    own = contact(ur5, wrench, seed=4, noise=0.01)
    without = contact_wrench(*own, WORTH, LOSSLESS)
    with_it = contact_wrench(*own, WORTH, replace(LOSSLESS, load_friction=0.1))
    np.testing.assert_array_equal(with_it.mean, without.mean)
    root = np.linalg.inv(own[1].mT) * (0.1 * torque_of(own[1], without.mean))[:, None]
    expected = (root**2).sum(axis=2)
    np.testing.assert_allclose((with_it.variance - without.variance), expected, rtol=0.05)


def test_bands_hold_forces_of_motors_whose_constants_are_hardly_known(ur5: Robot) -> None:
    """Errors of 30 %, as of known constants; with their width, the band holds 90 % and more."""
    doubt = 0.3 * np.eye(6)[1]
    held: dict[bool, list[np.ndarray]] = {True: [], False: []}
    for seed in range(50):
        random = np.random.default_rng(1000 + seed)
        force = 30.0 * np.array([1.0, 0, 0]) @ Rotation.random(rng=random).as_matrix()
        torque, J, noise = contact(ur5, np.append(force, np.zeros(3)), seed, noise=0.3)
        own = torque * (1 + doubt * random.standard_normal(6)), J, noise
        for known, lost in ((True, np.hypot(PRIOR.load_friction, doubt)), (False, 0.1)):
            found = contact_wrench(*own, WORTH, replace(PRIOR, load_friction=lost))
            error = found.mean[COUNT // 2, :3] - force
            held[known].append(np.abs(error) < 1.96 * np.sqrt(found.variance[COUNT // 2, :3]))
    assert 0.9 <= np.mean(held[True]) <= 0.99
    assert np.mean(held[False]) < 0.9


def test_an_estimate_widens_its_band_in_contact_by_the_doubt_of_constants(ur5: Robot) -> None:
    """And changes nothing else: the wrench, and the band where no contact is found."""
    free = free_run(ur5, 0, seconds=12.0, moving=False)
    force = 60.0 * between(free.time, 4, 7)[:, None] * [0.0, 0.6, 0.8]
    pushed = free.pushed(free.wrench(force))
    doubtful = replace(MODEL, constants_doubt=np.full(6, 0.3))
    plain, wider = pushed.estimate(), pushed.estimate(model=doubtful)
    np.testing.assert_array_equal(wider.wrench, plain.wrench)
    touched = (plain.wrench != 0).any(axis=1)
    assert touched[(free.time > 4.5) & (free.time < 6.5)].all()
    assert (wider.std[touched, :3] > plain.std[touched, :3]).all()
    np.testing.assert_array_equal(wider.std[~touched], plain.std[~touched])


@pytest.mark.parametrize("size", [3.0, 15.0, 80.0])
@pytest.mark.parametrize("lever", [0.0, 0.15])
def test_its_band_holds_forces_of_all_sizes(ur5: Robot, size: float, lever: float) -> None:
    """By all axes together: a moment of 15 cm times 15 N is in part taken for a force along z."""
    inside = []
    for seed in range(40):
        random = np.random.default_rng(100 + seed)
        force, off = (one / np.linalg.norm(one) for one in random.normal(size=(2, 3)))
        wrench = size * np.concatenate([force, lever * np.cross(off, force)])
        torque, J, noise = contact(ur5, wrench, seed)
        estimate = contact_wrench(0.97 * torque, J, noise, WORTH, PRIOR)
        inside.append(coverage(estimate.mean, estimate.variance**0.5, np.tile(wrench, (COUNT, 1))))
    assert np.mean(inside, axis=0)[:3].mean() > 0.9


# Its size


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("size", [0.0, 5.0, 500.0])
def test_a_learned_size_is_a_covariance(ur5: Robot, seed: int, size: float) -> None:
    wrench = size * np.random.default_rng(seed).normal(size=6)
    learned = learned_size(*contact(ur5, wrench, seed), WORTH, PRIOR)
    np.testing.assert_allclose(learned, learned.T)
    assert np.linalg.eigvalsh(learned).min() > 0
    np.testing.assert_array_equal(learned[3:, 3:], learned[3, 3] * np.eye(3))
    assert (learned[:3, 3:] == 0).all()


def test_a_size_has_the_direction_of_the_force(ur5: Robot) -> None:
    force = np.array([100.0, 0, 0, 0, 0, 0])
    learned = learned_size(*contact(ur5, force, seed=6, noise=0.1), WORTH, PRIOR)
    count = WORTH * COUNT
    expected = (count * 100**2 + 2 * PRIOR.force**2) / (count + 1)
    assert learned[0, 0] == pytest.approx(expected, rel=0.05)
    assert learned[0, 0] > 50 * learned[1, 1]


@pytest.mark.parametrize("lever", [0.0, 0.3])
def test_a_short_contact_has_the_usual_lever(ur5: Robot, lever: float) -> None:
    """Whatever its moment seems to be; in a long one, that is what counts."""
    wrench = np.array([0.0, 200, 0, 200 * lever, 0, 0])
    short, long = (
        learned_size(*contact(ur5, wrench, seed=6, noise=0.1), worth, PRIOR) for worth in (1e-3, 10)
    )
    levers = [np.sqrt(own[3, 3] / (np.trace(own[:3, :3]) / 3)) for own in (short, long)]
    assert levers[0] == pytest.approx(PRIOR.lever, rel=0.5)
    assert abs(levers[1] - lever) < 0.02


def test_what_tells_nothing_keeps_the_usual_size(ur5: Robot) -> None:
    """Not one sample is known: the contact is as before, of twice the usual variance."""
    _, J, noise = contact(ur5, np.zeros(6), seed=7)
    unknown = np.full((COUNT, 6), np.nan)
    learned = learned_size(unknown, J, noise, WORTH, PRIOR)
    np.testing.assert_allclose(learned, 2 * PRIOR.usual())


def near_singularities(
    ur5: Robot, arms: int
) -> Iterator[tuple[np.ndarray, tuple[np.ndarray, np.ndarray, np.ndarray]]]:
    """Forces (3,) of 10 to 80 N, swelling and ebbing, and what joints feel of them: gears and dry
    friction take a part, and their errors last as long as the contact.
    In turn, the wrist, the elbow and the shoulder are nearly singular.
    """
    swell = np.sin(np.linspace(0.2, np.pi - 0.2, COUNT))[:, None]
    noise, taken = 2 * NOISE, 0.3 * MODEL.breakaway
    for seed in range(arms):
        random = np.random.default_rng(seed)
        q = random.uniform(-2.5, 2.5, 6)
        singular = [(4,), (2,), (1, 2, 3, 4)][seed % 3]
        q[list(singular)] = random.normal(0, 0.05, len(singular))
        q[1] -= np.pi / 2 * (len(singular) > 1)
        J = jacobians(ur5, q + np.linspace(0, 0.05, COUNT)[:, None] * random.normal(size=6))
        force = random.normal(size=3)
        force *= random.uniform(10, 80) / np.linalg.norm(force)
        wrench = np.append(force, random.normal(0, 0.017 * np.linalg.norm(force), 3))
        torque = torque_of(J, swell * wrench) * (1 + random.normal(0, 0.1, 6))
        torque += noise * random.normal(size=6) + taken * random.uniform(-1, 1, 6)
        yield force, (torque, J, np.tile(np.diag(noise**2 + taken**2), (COUNT, 1, 1)))


def test_near_singularities_no_constant_of_the_prior_decides(ur5: Robot) -> None:
    """Each doubled and halved moves no force by more than half of its band. It holds fewer than
    95 %: errors that last are taken for independent ones, and the contact's size for learnt.
    """
    middle, inside = COUNT // 2, []
    for force, own in near_singularities(ur5, 50):
        told = contact_wrench(*own, WORTH, PRIOR)
        half = 1.96 * np.sqrt(told.variance[middle, :3])
        inside.append(np.abs(told.mean[middle, :3] - force) <= half)
        for factor in (0.5, 2.0):
            priors = [
                replace(PRIOR, **{name: factor * getattr(PRIOR, name)})
                for name in ("force", "lever", "lever_weight", "load_friction")
            ]
            for other in (contact_wrench(*own, WORTH, prior) for prior in priors):
                assert (np.abs(other.mean - told.mean)[middle, :3] <= half).all()
    assert np.mean(inside) >= 0.82


def test_unknown_samples_do_not_shrink_a_contact(ur5: Robot) -> None:
    """Half of a contact has no torque: the other half is told as if that half were not there."""
    wrench = np.array([0.0, 50, 0, 0, 0, 0])
    torque, J, noise = contact(ur5, wrench, seed=8)
    torque[COUNT // 2 :] = np.nan
    half = contact_wrench(torque[:50], J[:50], noise[:50], WORTH, PRIOR)
    whole = contact_wrench(torque, J, noise, WORTH, PRIOR)
    np.testing.assert_allclose(whole.mean[:48], half.mean[:48], rtol=1e-3, atol=1e-3)
    assert (whole.mean[50:] == 0).all()
    assert (whole.variance[50:, 1] > 4 * half.variance[:40, 1].max()).all()


def test_moments_are_uncertain_by_a_lever_of_five_centimetres(
    ur5: Robot, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of whatever force; the force is not."""
    own = contact(ur5, np.array([300.0, -200, 400, 0, 0, 0]), seed=11)
    told = contact_wrench(*own, WORTH, LOSSLESS)
    monkeypatch.setattr("ur5lib.force.contact_wrench.UNRESOLVED_LEVER", 0.0)
    exact = contact_wrench(*own, WORTH, LOSSLESS)
    np.testing.assert_array_equal(told.variance[:, :3], exact.variance[:, :3])
    force = np.linalg.norm(told.mean[:, :3], axis=1)[:, None]
    added = told.variance[:, 3:] - exact.variance[:, 3:]
    np.testing.assert_allclose(added, np.tile((0.05 * force) ** 2, 3))


# A resting arm without any fit: exact without errors, inside its band with them


TORQUE_MAX = np.array([150.0, 150.0, 150.0, 28.0, 28.0, 28.0])


def regular_jacobians(count: int) -> np.ndarray:
    """Regular Jacobians of an arm of 0.8 m, (count, 6, 6)."""
    rng = np.random.default_rng(1)
    linear = rng.normal(size=(count, 3, 6)) * np.array([0.5, 0.5, 0.4, 0.1, 0.1, 0.05])
    return np.concatenate([linear, rng.normal(size=(count, 3, 6))], axis=1)


def test_the_force_is_exact_without_friction_and_with_right_constants() -> None:
    jacobian, wrench = regular_jacobians(50), np.tile([60.0, -80.0, 30.0, 1.0, -2.0, 0.5], (50, 1))
    torque = (jacobian.mT @ wrench[..., None])[..., 0]
    found, std = static_wrench(torque, np.full((50, 6), 1e-4), jacobian, 15.0)
    assert np.abs(found - wrench).max() < 1e-2
    assert (std[:, :3] < 1).all()


def test_without_any_torque_known_the_prior_is_left() -> None:
    _, std = static_wrench(np.zeros((1, 6)), np.full((1, 6), 1e9), regular_jacobians(1), 15.0)
    assert std[0] == pytest.approx([105.0] * 3 + [10.5] * 3)


def test_the_band_holds_under_any_friction_and_wrong_constants() -> None:
    """Friction anywhere within the breakaway torque, constants that are off by 30 % (one std)."""
    rng = np.random.default_rng(2)
    count, jacobian = 4000, regular_jacobians(4000)
    wrench = rng.normal(size=(count, 6)) * np.array([105.0] * 3 + [10.5] * 3)
    external = (jacobian.mT @ wrench[..., None])[..., 0]
    gravity = rng.uniform(-0.3, 0.3, (count, 6)) * TORQUE_MAX
    friction = rng.uniform(-BREAKAWAY_SHARE, BREAKAWAY_SHARE, (count, 6)) * TORQUE_MAX
    motor = gravity - external + friction
    measured = motor * (1 + 0.3 * rng.normal(size=(count, 6)))
    std = torque_std(motor, np.full(6, 0.3), TORQUE_MAX)
    found, deviation = static_wrench(gravity - measured, std, jacobian, 15.0)
    held = (np.abs(found - wrench) <= 1.96 * deviation).mean(axis=0)
    assert ((held > 0.93) & (held < 0.97)).all(), held


def test_motion_is_no_rest_and_unknown_torque_is_no_force() -> None:
    qd = np.zeros((3, 6))
    qd[1, 4] = 2 * STATIC_SPEED
    assert at_rest(qd).tolist() == [True, False, True]
    torque = np.zeros((3, 6))
    torque[1, 0] = np.nan
    found, std = static_wrench(torque, np.ones((3, 6)), regular_jacobians(3), 15.0)
    assert np.isfinite(found).all(axis=1).tolist() == [True, False, True]
    assert np.isnan(std[1]).all()
