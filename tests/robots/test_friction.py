"""The terms of friction."""

import numpy as np
import pytest

from ur5lib.robots.friction import (
    BASE_TERMS,
    TERMS,
    JointMotion,
    Track,
    direction_after,
    direction_between,
    friction_columns,
    friction_direction,
    rest_factor,
    unknown_after,
    unknown_share,
)

RANDOM = np.random.default_rng(0)
Q, QD, TORQUE = RANDOM.normal(size=(3, 200)) * [[2.0], [1.0], [20.0]]
MOTION = JointMotion(Q, QD, TORQUE, np.sign(QD))
PARTS = slice(0, 30), slice(29, 59), slice(58, 90)  # each begins where the one before ends
BACK = JointMotion(Q, -QD, TORQUE, -np.sign(QD))


@pytest.mark.parametrize("term", BASE_TERMS)
def test_friction_turns_with_the_velocity(term: str) -> None:
    np.testing.assert_allclose(friction_columns(BACK, [term]), -friction_columns(MOTION, [term]))
    assert (friction_columns(MOTION, [term])[:, 0] * MOTION.qd >= 0).all()


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


def test_nothing_is_known_of_friction_where_a_segment_begins() -> None:
    np.testing.assert_array_equal(creep([1e-3, 0, 0], [0, 0, 1, 1])[2:], 0.0)


def test_load_friction_is_expected_whatever_the_motor() -> None:
    assert TERMS["coulomb"].expected(150.0) == 150.0
    assert TERMS["load"].expected(150.0) == TERMS["load"].expected(28.0) == 0.1


def test_terms_have_their_values() -> None:
    """At q = 0.5 rad, q̇ = -0.4 rad/s, 20 Nm and a direction of -0.9."""
    motion = JointMotion(*(np.array([value]) for value in (0.5, -0.4, 20.0, -0.9)))
    np.testing.assert_allclose(friction_columns(motion, BASE_TERMS), [[-0.9, -0.4, -18.0]])


def test_the_dead_zone_is_a_fiftieth_of_a_radian_per_second() -> None:
    """At its edge friction is stiction for a quarter: 1 - tanh(1)."""
    np.testing.assert_allclose(rest_factor(np.array([0.02, -0.02])), 1 - np.tanh(1))


def test_motion_without_a_distance_changes_nothing() -> None:
    """Direction is exact from sample to sample: 1 - exp(-1) after the distance itself."""
    assert creep([1e-4])[-1] == pytest.approx(1 - np.exp(-1))
    assert creep([0.0])[-1] == 0.0
    assert creep([1e-3, -1e-4])[-1] == pytest.approx(2 * np.exp(-1) - 1, abs=1e-4)


def test_a_slow_log_has_the_direction_of_a_fast_one() -> None:
    """On the mean about each sample: a joint may reverse between those that are 0.1 s apart."""
    time = np.arange(0, 10, 0.01)
    q, qd = 1e-3 * np.sin(5 * time), 5e-3 * np.cos(5 * time)
    segment = np.zeros(len(q), int)
    fast = np.convolve(friction_direction(q, segment), np.ones(11) / 11, "same")[10:-10:10]
    slow = direction_between(q[::10], qd[::10], segment[::10], 0.1)[1:-1]
    np.testing.assert_allclose(slow[:-1], fast[: len(slow) - 1], atol=0.02)
    assert np.abs(friction_direction(q[::10], segment[::10])[1:-1] - fast).max() > 0.2
    np.testing.assert_array_equal(
        direction_between(q, qd, segment, 0.01), friction_direction(q, segment)
    )


def test_a_slow_log_tells_no_direction_across_a_gap() -> None:
    """As a fast one: a joint that rests after it may have come from either side."""
    q, segment = np.repeat([0.0, 1.0], 3), np.repeat([0, 1], 3)
    for period in (0.1, 0.008):
        np.testing.assert_array_equal(direction_between(q, 0 * q, segment, period), np.zeros(6))


def test_direction_goes_on_from_the_motions_before() -> None:
    """The third part of a motion has the directions of the whole."""
    q, qd, one = 2e-4 * np.sin(np.linspace(0, 9, 90)), np.zeros(90), np.zeros(90, int)
    *before, last = (Track(q[part], qd[part], one[part], 0.01) for part in PARTS)
    start = direction_after(before, 3e-4)
    whole = friction_direction(q, one, 3e-4)[PARTS[-1]]
    np.testing.assert_allclose(direction_between(*last, 3e-4, start), whole)


def test_earlier_motion_before_a_gap_says_nothing() -> None:
    ends = Track(np.array([0.0, 1.0]), np.zeros(2), np.array([0, 1]), 0.01)
    assert direction_after([Track(*ends[:2], np.zeros(2, int), 0.01), ends]) == 0.0


def test_unknown_share_fades_with_what_a_joint_reached() -> None:
    """Not with its path, which noise makes long; after a gap, all is unknown again."""
    q, segment = 1e-3 * np.array([0, 1, 0, 0.5, 0, 2]), np.array([0, 0, 0, 0, 1, 1])
    share = unknown_share(q, segment, 0.5)
    np.testing.assert_allclose(share[:4], 0.5 * np.exp([0, -1, -1, -1]))
    np.testing.assert_allclose(share[4:], np.exp([0, -2]))
    track = Track(q, 0 * q, segment, 0.01)
    assert unknown_after([track, track]) == pytest.approx(np.exp(-2))
    assert unknown_after([]) == 1.0
