"""Links that are bodies."""

import numpy as np
import pytest

from tests.library.test_base_parameters import columns, fit, parameters, sines
from ur5lib.errors import RefusalError
from ur5lib.identification.base_parameters import Estimate, identified_model, torque_error
from ur5lib.identification.consistency import (
    LENGTH,
    MARGIN,
    consistent,
    pseudo_inertias,
    smallest_eigenvalues,
)
from ur5lib.robots.description import Robot, load_robot, robot_names, robot_path


def test_the_pseudo_inertia_of_points_is_their_second_moment() -> None:
    """Σ m [r 1] [r 1]ᵀ, with inertia Σ m (r·r 1 - r rᵀ) and first moment Σ m r (Wensing 2018)."""
    random = np.random.default_rng(0)
    mass, r = random.uniform(0.1, 1, 20), random.normal(0, 0.1, (20, 3))
    inertia = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(mass, r, strict=True))
    link = [mass.sum(), *(mass @ r), *inertia[[0, 0, 1, 0, 1, 2], [0, 1, 1, 2, 2, 2]]]
    points = np.column_stack([r / LENGTH, np.ones(20)])
    expected = (points * mass[:, None]).T @ points
    found = pseudo_inertias(np.append(np.tile(link, 6), np.zeros(6)))  # no rotors
    np.testing.assert_allclose(found, np.tile(expected, (6, 1, 1)), rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize("name", robot_names())
def test_published_models_are_bodies_up_to_their_digits(name: str) -> None:
    """The UR10e's link 6 is a plate to four decimals: (0.1, 0.4, 0.3) g m²."""
    robot = load_robot(robot_path(name))
    for model in robot.models:
        assert smallest_eigenvalues(parameters(robot, model)).min() > -1e-9, model


def test_what_is_a_body_stays_as_it_is(ur5: Robot) -> None:
    rows = columns("ur5", *sines(20))
    noise = np.random.default_rng(0).normal(0, 1e-4, rows.shape[:2])
    found = fit(rows, rows @ parameters(ur5, "C+rotors") + noise, parameters(ur5, "C+rotors"))
    assert smallest_eigenvalues(found.parameters).min() > MARGIN
    np.testing.assert_allclose(consistent(found), found.parameters, atol=1e-7)


def test_what_is_none_becomes_the_nearest(ur5: Robot) -> None:
    """A wrist of negative inertia and a rotor that helps: the fit believes them, a body cannot."""
    rows, truth = columns("ur5", *sines(20)), parameters(ur5, "C+rotors")
    truth[[59, 65]] = -0.05, -0.2
    torque = rows @ truth + np.random.default_rng(0).normal(0, 0.01, rows.shape[:2])
    found = fit(rows, torque, parameters(ur5, "C"))
    nearest = consistent(found)
    assert smallest_eigenvalues(found.parameters).min() < 0
    assert smallest_eigenvalues(nearest).min() > 0.5 * MARGIN
    before, after = (torque_error([(rows, torque)], p) for p in (found.parameters, nearest))
    assert after[5] > before[5] + 0.1  # what being a body costs here
    assert identified_model(ur5, nearest, "as near as it gets").rotor_inertias[5] > 0

    def distance(p: np.ndarray) -> float:
        return float(np.linalg.norm(np.linalg.solve(found.spread, p - found.parameters)))

    inside = parameters(ur5, "C")
    for step in (1e-3, 1e-2, 0.1, 1):
        assert distance(nearest) < distance(nearest + step * (inside - nearest))


def test_torques_of_no_bodies_are_refused() -> None:
    """As of a log whose torques belong to another arm, or to none."""
    estimate = Estimate(
        parameters=np.full(66, -5.0),
        scatter=np.zeros((1, 66)),
        spread=1e-6 * np.eye(66),
        rounding=1e-9 * np.eye(66),
        width=np.ones(66),
        noise=np.ones(6),
    )
    with pytest.raises(RefusalError, match="no bodies"):
        consistent(estimate)
