"""The family of friction terms."""

import numpy as np
import pytest

from ur5lib.identification.friction import (
    BASE,
    FAMILY,
    MOVING,
    JointMotion,
    Term,
    is_dissipative,
    locked_friction,
)

RANDOM = np.random.default_rng(0)
MOTION = JointMotion(*(RANDOM.normal(size=(3, 200)) * [[2.0], [1.0], [20.0]]))
BACK = JointMotion(MOTION.q, -MOTION.qd, MOTION.torque)


@pytest.mark.parametrize("term", [*BASE, *FAMILY])
def test_a_term_has_a_column_for_each_of_its_names(term: Term) -> None:
    assert term.columns(MOTION).shape == (200, len(term.names()))


@pytest.mark.parametrize(
    "term", [t for t in (*BASE, *FAMILY) if t.kind not in ("asymmetric", "periodic")]
)
def test_friction_turns_with_the_velocity(term: Term) -> None:
    np.testing.assert_allclose(term.columns(BACK), -term.columns(MOTION))
    assert (term.columns(MOTION)[:, 0] * MOTION.qd >= 0).all()


def test_asymmetry_does_not_turn() -> None:
    term = Term("asymmetric")
    np.testing.assert_array_equal(term.columns(BACK), term.columns(MOTION))


def test_names_tell_terms_apart() -> None:
    names = [name for term in (*BASE, *FAMILY) for name in term.names()]
    assert len(set(names)) == len(names)


def creep(steps: list[float], segment: list[int] | None = None) -> np.ndarray:
    """Locked friction of a joint that creeps by these steps, 1e-4 rad being all it can."""
    q = np.cumsum([0.0, *steps])[:, None]
    labels = np.array(segment or [0] * len(q))
    return locked_friction(q, np.zeros_like(q), labels, 1e-4)[:, 0]


def test_friction_stays_locked_in_after_a_move() -> None:
    held = creep([1e-3, 0, 0, 0])
    np.testing.assert_allclose(held[1:], 1.0, atol=1e-4)
    assert creep([-1e-3])[-1] == pytest.approx(-1.0, abs=1e-4)


def test_creep_is_elastic_at_first_and_never_more_than_all() -> None:
    assert creep([1e-6])[-1] == pytest.approx(0.01, rel=0.01)
    assert np.abs(creep(list(RANDOM.normal(size=300) * 1e-4))).max() <= 1


def test_nothing_is_known_of_friction_where_a_segment_begins() -> None:
    np.testing.assert_array_equal(creep([1e-3, 0, 0], [0, 0, 1, 1])[2:], 0.0)


def test_in_motion_coulomb_friction_takes_over() -> None:
    q = np.linspace(0, 1, 100)[:, None]
    assert (
        np.abs(locked_friction(q, np.full_like(q, 5 * MOVING), np.zeros(100, int), 1e-4)).max()
        < 1e-3
    )


def test_friction_that_drives_is_told() -> None:
    terms = (Term("coulomb"), Term("viscous"), Term("load"))
    speed, load = np.linspace(-1, 1, 21), np.array([0.0, 100.0])
    assert is_dissipative(terms, np.array([1.0, -0.5, 0.0]), speed, load)
    assert not is_dissipative(terms, np.array([1.0, -2.0, 0.0]), speed, load)
    assert not is_dissipative(terms, np.array([1.0, 0.0, -0.1]), speed, load)


def test_what_depends_on_the_position_is_not_taken_for_friction() -> None:
    terms = (*BASE, Term("periodic", 1))
    assert is_dissipative(terms, np.array([1.0, 1.0, 9.0, 9.0]), np.array([-1.0, 1.0]), np.zeros(1))
