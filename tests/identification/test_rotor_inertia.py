"""Rotor inertias: known ones come back, and the real ones are the maker's."""

from dataclasses import astuple

import numpy as np

from tests.real_arms import RealStudy
from ur5lib.identification.controllers_torques import rotor_samples
from ur5lib.identification.rotor_inertia import RotorFit, fit_rotor_inertia, with_rotors
from ur5lib.records.models import Rotors, Terms
from ur5lib.robots.description import Robot
from ur5lib.robots.inertia import rigid_bodies
from ur5lib.steps.identify_model import commanded
from ur5lib.timeseries.arrays import Array

Sample = tuple[Array, Array, Array]  # residual, qd, qdd
UR10E_FITTED = [
    "ur-20_01_17-ptp_10_points",
    "ur-20_01_31-unload",
    "ur-20_02_12-50sec_12harm",
    "ur-20_02_19_14harm50sec",
]
MAKER = np.array([6.02, 6.02, 1.915, 0.612, 0.612, 0.612])  # rotors times gear ratio squared
INERTIA = np.array([1.6, 1.6, 1.9, 0.16, 0.16, 0.16])


def made_up(seed: int, count: int = 2000, error: float = 0.05) -> Sample:
    """A recording whose links' model errs by slow waves of its own."""
    random = np.random.default_rng(seed)
    time = 0.008 * np.arange(count)[:, None]
    speed, phase = random.uniform(1, 4, (2, 6))
    qd = np.sin(speed * time + phase)
    qdd = speed * np.cos(speed * time + phase)
    wave = error * np.sin(random.uniform(0.5, 3, 6) * time + random.uniform(0, 6, 6))
    return INERTIA * qdd + wave, qd, qdd


def fit(recordings: list[Sample]) -> RotorFit:
    return fit_rotor_inertia(*zip(*recordings, strict=True))


def test_all_four_terms_come_back() -> None:
    _, qd, qdd = made_up(0)
    terms = np.random.default_rng(1).normal(size=(4, 6))
    residual = terms[0] * qdd + terms[1] + terms[2] * np.sign(qd) + terms[3] * qd
    found = fit([(residual, qd, qdd)])
    np.testing.assert_allclose(astuple(found.value), terms, atol=1e-6)
    np.testing.assert_allclose(astuple(found.std_error), 0, atol=1e-6)


def test_standard_errors_hold_what_they_promise() -> None:
    """Errors alike through a motion: the jackknife sees them, one of single samples would not."""
    scores = []
    for trial in range(20):
        found = fit([made_up(10 * trial + k, 1000) for k in range(6)])
        scores.append((found.value.inertia - INERTIA) / found.std_error.inertia)
    assert 0.6 < np.sqrt(np.mean(np.square(scores))) < 2.0


def test_the_standard_error_is_the_jackknife_s() -> None:
    """√((n - 1) / n Σ (θ without k - mean)²) of n recordings, by fits without each."""
    recordings = [made_up(seed, 500) for seed in range(3)]
    without = [astuple(fit(recordings[:k] + recordings[k + 1 :]).value) for k in range(3)]
    squares = np.sum((np.array(without) - np.mean(without, axis=0)) ** 2, axis=0)
    found = astuple(fit(recordings).std_error)
    np.testing.assert_allclose(found, np.sqrt(2 / 3 * squares), rtol=1e-9)


def test_a_stretch_of_contact_does_not_decide() -> None:
    recordings = [made_up(seed) for seed in range(4)]
    pushed = [(residual.copy(), qd, qdd) for residual, qd, qdd in recordings]
    rows = pushed[0][2][:200] > 0
    pushed[0][0][:200][rows] += 20.0
    moved = fit(pushed).value.inertia - fit(recordings).value.inertia
    assert (np.abs(moved) < 0.02).all()


def test_missing_rows_and_order_change_nothing() -> None:
    recordings = [made_up(seed) for seed in range(3)]
    holed = [tuple(np.insert(part, 100, np.nan, axis=0) for part in one) for one in recordings]
    plain = fit(recordings)
    for other in (fit(holed), fit(recordings[::-1])):
        for mine, its in ((other.value, plain.value), (other.std_error, plain.std_error)):
            np.testing.assert_allclose(astuple(mine), astuple(its), rtol=1e-4, atol=1e-8)


def test_a_joint_that_kept_still_tells_nothing() -> None:
    residual, qd, qdd = made_up(0)
    qd[:, 2] = qdd[:, 2] = 0.0
    found = fit([(residual, qd, qdd)])
    np.testing.assert_array_equal(np.isnan(found.value.inertia), np.arange(6) == 2)
    np.testing.assert_array_equal(np.isnan(found.std_error.inertia), np.arange(6) == 2)


def test_an_inertia_that_is_not_determined_is_that_of_the_description(ur5: Robot) -> None:
    """Joints at rest had fits of 166 ± 291 and -7068 kg m²; the first was used."""
    value, std = INERTIA.copy(), np.full(6, 0.01)
    value[[1, 3, 4]], std[[1, 3, 4]] = [-7068.0, 166.0, np.nan], [3081.0, 291.0, np.nan]
    zero = np.zeros(6)
    fits = [Terms(inertia, zero, zero, zero) for inertia in (value, std)]
    changed = with_rotors(ur5, Rotors(["moved"], *fits))
    described = rigid_bodies(ur5, f"{ur5.chosen_model}+rotors").rotor_inertia
    found = changed.models[f"{ur5.chosen_model}+rotors"].rotor_inertias
    np.testing.assert_allclose(found, np.where([1, 0, 1, 0, 0, 1], INERTIA, described))
    unknown = [Terms(inertia, zero, zero, zero) for inertia in (value, np.full(6, 1e3))]
    assert with_rotors(ur5, Rotors(["rested"], *unknown)) is ur5


# The real arms


def sample(study: RealStudy, name: str) -> Sample:
    one = study.recording(name)
    run = commanded(one.robot, one.signals, one.motion)
    found = rotor_samples(run, study.motion_lowpass)
    assert found is not None
    return found


def test_the_rotors_of_the_ur10e_are_the_makers(real_ur10e: RealStudy) -> None:
    """Within 3 % of the maker's files; from measured motion, as logs hold no targets but torque."""
    found = fit([sample(real_ur10e, name) for name in UR10E_FITTED])
    np.testing.assert_allclose(found.value.inertia, MAKER, rtol=0.03)
    assert (found.std_error.inertia < 0.01 * MAKER).all()
