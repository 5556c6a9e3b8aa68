"""The family of friction terms."""

import numpy as np
import pytest

from ur5lib.robots.friction import (
    BASE,
    CONSIDERED,
    FAMILY,
    JointMotion,
    Term,
    friction_direction,
    is_dissipative,
    karnopp_direction,
    resting,
)
from ur5lib.timeseries.segments import DEAD_ZONE

RANDOM = np.random.default_rng(0)
Q, QD, TORQUE = RANDOM.normal(size=(3, 200)) * [[2.0], [1.0], [20.0]]
MOTION = JointMotion(Q, QD, TORQUE, np.sign(QD))
BACK = JointMotion(Q, -QD, TORQUE, -np.sign(QD))


@pytest.mark.parametrize("term", [*BASE, *FAMILY])
def test_a_term_has_a_column_for_each_of_its_names(term: Term) -> None:
    assert term.columns(MOTION).shape == (200, len(term.names()))


@pytest.mark.parametrize(
    "term", [t for t in (*BASE, *FAMILY) if t.kind not in ("asymmetric", "periodic")]
)
def test_friction_turns_with_the_velocity(term: Term) -> None:
    np.testing.assert_allclose(term.columns(BACK), -term.columns(MOTION))
    assert (term.columns(MOTION)[:, 0] * MOTION.qd >= 0).all()


def test_names_tell_terms_apart() -> None:
    names = [name for term in (*BASE, *FAMILY) for name in term.names()]
    assert len(set(names)) == len(names)


def creep(steps: list[float], segment: list[int] | None = None) -> np.ndarray:
    """Direction of the friction of a joint that creeps by these steps, over 1e-4 rad."""
    q = np.cumsum([0.0, *steps])
    return friction_direction(q, np.array(segment or [0] * len(q)), 1e-4)


def test_friction_keeps_its_direction_after_a_move() -> None:
    held = creep([1e-3, 0, 0, 0])
    np.testing.assert_allclose(held[1:], 1.0, atol=1e-4)
    assert creep([-1e-3])[-1] == pytest.approx(-1.0, abs=1e-4)


def test_creep_is_elastic_at_first_and_never_more_than_all() -> None:
    assert creep([1e-6])[-1] == pytest.approx(0.01, rel=0.01)
    assert np.abs(creep(list(RANDOM.normal(size=300) * 1e-4))).max() <= 1


def test_friction_turns_over_a_distance_however_finely_it_is_sampled() -> None:
    coarse, fine = creep([1e-3, -5e-5]), creep([1e-3, *[-5e-7] * 100])
    assert coarse[-1] == pytest.approx(2 * np.exp(-0.5) - 1, abs=1e-4)
    assert fine[-1] == pytest.approx(coarse[-1])


def test_karnopp_sticks_in_the_dead_zone_and_reverses_at_once() -> None:
    qd = DEAD_ZONE * np.array([0.5, 2, 0.5, -0.9, -1.1, -0.1, 0.1, 3, 0.2])
    segment = np.array([0, 0, 0, 0, 0, 0, 0, 1, 2])
    direction = karnopp_direction(qd, segment)
    np.testing.assert_array_equal(direction, [0, 1, 1, 1, -1, -1, -1, 1, 0])


def test_nothing_is_known_of_friction_where_a_segment_begins() -> None:
    np.testing.assert_array_equal(creep([1e-3, 0, 0], [0, 0, 1, 1])[2:], 0.0)


def test_what_is_expected_of_a_term_has_a_number_for_each_coefficient() -> None:
    for term in (*BASE, *CONSIDERED, *FAMILY):
        assert len(term.expected(torque_max=150.0)) == len(term.names())
    assert CONSIDERED[0].expected(150.0) == [0.75, 0.75]
    assert Term("coulomb").expected(150.0) == [150.0]
    assert Term("load").expected(150.0) == Term("load").expected(28.0) == [0.1]  # whatever motor


def test_friction_that_drives_is_told() -> None:
    terms = (Term("coulomb"), Term("viscous"), Term("load"))
    speed, load = np.linspace(-1, 1, 21), np.array([0.0, 100.0])
    assert is_dissipative(terms, np.array([1.0, -0.5, 0.0]), speed, load)
    assert not is_dissipative(terms, np.array([1.0, -2.0, 0.0]), speed, load)
    assert not is_dissipative(terms, np.array([1.0, 0.0, -0.1]), speed, load)


def test_what_depends_on_the_position_is_not_taken_for_friction() -> None:
    terms = (*BASE, Term("periodic", 1))
    assert is_dissipative(
        terms, np.array([1.0, 1.0, 0.0, 9.0, 9.0]), np.array([-1.0, 1.0]), np.zeros(1)
    )


VALUES = {  # at q = 0.5 rad, q̇ = -0.4 rad/s, 20 Nm, direction -0.9, worked out by hand
    Term("coulomb"): [-0.9],
    Term("viscous"): [-0.4],
    Term("load"): [-18.0],
    Term("stribeck", 0.2): [-0.9 * np.exp(-4)],
    Term("saturating", 0.2): [-np.tanh(2)],
    Term("quadratic"): [-0.16],
    Term("cubic"): [-0.064],
    Term("asymmetric"): [0.4],
    Term("periodic", 2.0): [np.sin(1.0), np.cos(1.0)],
}


@pytest.mark.parametrize("term", VALUES, ids=lambda term: term.kind)
def test_a_term_has_its_value(term: Term) -> None:
    motion = JointMotion(*(np.array([value]) for value in (0.5, -0.4, 20.0, -0.9)))
    np.testing.assert_allclose(term.columns(motion), [VALUES[term]])


def test_the_dead_zone_is_a_fiftieth_of_a_radian_per_second() -> None:
    """At its edge friction is stiction for a quarter: 1 - tanh(1)."""
    np.testing.assert_allclose(resting(np.array([0.02, -0.02])), 1 - np.tanh(1))


def test_motion_without_a_distance_changes_nothing() -> None:
    """Direction is exact from sample to sample: 1 - exp(-1) after the distance itself."""
    assert creep([1e-4])[-1] == pytest.approx(1 - np.exp(-1))
    assert creep([0.0])[-1] == 0.0
    assert creep([1e-3, -1e-4])[-1] == pytest.approx(2 * np.exp(-1) - 1, abs=1e-4)
