"""What recordings can tell, in words."""

from functools import cache

import numpy as np
import pytest

from tests.identification.test_base_parameters import (
    blocks,
    columns,
    fit,
    parameters,
    sines,
    ur5_base,
)
from ur5lib.errors import Remark
from ur5lib.identification.base_parameters import prior_width, stack
from ur5lib.identification.excitation import candidate_motions, check_excitation
from ur5lib.records.models import Excitation
from ur5lib.robots.description import Robot
from ur5lib.timeseries.arrays import Array


@cache
def candidates() -> dict[str, Array]:
    return {
        name: columns("ur5", *motion) for name, motion in candidate_motions(6, 1.5, 3, 300).items()
    }


def check(*motion: Array, noise: float = 0.01) -> Excitation:
    rows = columns("ur5", *motion)
    data = stack(blocks(rows, np.zeros(rows.shape[:2])))
    return check_excitation(data, ur5_base(), prior_width(66), np.full(6, noise), candidates())


def told(advice: list[Remark]) -> set[tuple[str, str]]:
    """Owner and name of the parameters that motions would determine."""
    owned = [own for one in advice for own in one.text.partition("would determine ")[2].split("; ")]
    parts = (own.rpartition(" of ") for own in owned)
    return {(owner, name) for names, _, owner in parts for name in names.split(", ")}


def test_candidates_fill_the_range_and_no_more() -> None:
    for q, qd, qdd in candidate_motions(6, 2.0, 5.0).values():
        for values, limit in ((q, np.pi), (qd, 2.0), (qdd, 5.0)):
            assert values.shape == (1000, 6)
            reach = np.abs(values).max(axis=0)
            assert (reach <= limit).all()
            assert ((reach > 0.98 * limit) | (reach == 0)).all()
            assert (np.abs(values.mean(axis=0)) < 0.1 * limit).all()


def test_candidates_are_named_by_the_joints_that_move() -> None:
    """None, each alone, each two, all; in the same poses."""
    motions = candidate_motions(6, 2.0, 5.0, 50)
    assert len(motions) == 1 + 6 + 15 + 1
    for name, (q, qd, qdd) in motions.items():
        np.testing.assert_array_equal(q, motions["Holding still"][0])
        moving = np.flatnonzero((qd != 0).any(axis=0))
        np.testing.assert_array_equal(np.flatnonzero((qdd != 0).any(axis=0)), moving)
        joints = " and ".join(f"joint {joint + 1}" for joint in moving)
        joints = "all joints" if len(moving) == 6 else joints
        fast = f"Moving {joints} at up to 2 rad/s and 5 rad/s²"
        assert name == (fast if joints else "Holding still")


def test_a_condition_number_is_of_columns_by_the_width_of_their_parameters() -> None:
    rows, base = columns("ur5", *sines(20)), ur5_base()
    noise = np.array([1.0, 2, 3, 0.5, 0.1, 0.2])
    data = stack(blocks(rows, np.zeros(rows.shape[:2])))
    found = check_excitation(data, base, prior_width(66), noise, candidates())
    weighted = (rows / noise[:, None] * prior_width(66)).reshape(-1, 66)
    rotors = [column for column in base.columns if column >= 60]
    for group, chosen in (("all", base.columns), ("rotors", rotors)):
        expected = np.linalg.cond(weighted[:, chosen])
        assert found.condition[group] == pytest.approx(expected, rel=1e-6)


def test_rich_motion_needs_no_advice() -> None:
    found = check(*sines(60))
    assert found.condition.keys() == {"gravity", "inertia", "rotors", "all"}
    assert max(found.condition.values()) < 1000
    assert (found.combinations, found.undetermined, found.advice) == (40, [], [])


def test_a_standstill_tells_only_its_gravity_torques() -> None:
    q = np.repeat([[0.1, -1, 1.2, 0.3, 0.9, 0.2]], 500, axis=0)
    found = check(q, 0 * q, 0 * q)
    assert found.condition["rotors"] == found.condition["inertia"] == np.inf
    assert found.combinations == 5  # joint 1 is vertical
    assert len(found.undetermined) == 40
    assert ("joint 6", "rotor inertia") in told(found.advice)
    assert found.advice[0].motion.startswith("Moving")


@pytest.mark.parametrize("joint", range(6))
def test_the_joint_that_rested_is_the_one_to_move(joint: int) -> None:
    found = check(*sines(100, still=(joint,)), noise=0.05)
    own = "I_zz of link" if joint < 2 else "rotor inertia of joint"
    assert f"{own} {joint + 1}" in found.undetermined
    missing = f"{own.split(' of ')[1]} {joint + 1}", own.split(" of ")[0]
    advice = next(one for one in found.advice if missing in told([one]))
    assert f"joint {joint + 1}" in advice.motion


def test_hopeless_noise_is_called_hopeless() -> None:
    found = check(*sines(20), noise=1e4)
    assert found.combinations == 0
    assert len(found.advice) == 1
    assert found.advice[0].code == "no motion determines"


def test_advice_keeps_its_promise(ur5: Robot) -> None:
    """With the advised motion added, the parameters that it was to tell are determined in a fit."""
    rows = columns("ur5", *sines(60, still=(5,)))
    before = check(*sines(60, still=(5,)))
    advised = [one.motion for one in before.advice]
    more = np.concatenate([rows, *(candidates()[name] for name in advised)])
    noise = np.random.default_rng(0).normal(0, 0.01, more.shape[:2])
    truth, prior = parameters(ur5, "C+rotors"), parameters(ur5, "C")
    found = fit(more, more @ truth + noise, prior)
    assert before.undetermined
    assert found.determined(ur5_base().groups).all()
