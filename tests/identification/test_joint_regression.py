"""The regression of one joint, and what of the recordings counts for it."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from tests.current_study import (
    CONSTANT,
    PERIOD,
    cut,
    make_record,
    prior,
    smooth,
)
from ur5lib.identification.joint_regression import (
    HELD_FRICTION_SHARE,
    held_current,
    left_out_residuals,
    regress_samples,
)
from ur5lib.identification.prior import Prior, Typical
from ur5lib.identification.samples import (
    CurrentSamples,
    JointSamples,
    MotionState,
    blocks,
    columns_of,
    joint_samples,
    motion_states,
    record_paths,
    smoothed_moving,
)
from ur5lib.records.motion import Motion
from ur5lib.robots.friction import BASE_TERMS
from ur5lib.timeseries.arrays import Array

LOADED = (6.0, 4.0, 0.05)  # Coulomb, viscous and load friction


def known(joint: int) -> Prior:
    return replace(prior(), terms=BASE_TERMS).of_joint(joint)


def made(joint: int, friction: tuple[float, ...], records: int = 6) -> JointSamples:
    """Samples of a joint with a friction [Nm, ...], without noise, at some 1 rad/s."""
    study = []
    for seed in range(records):
        record = make_record(seed)
        columns = columns_of(record.joint(joint), BASE_TERMS)
        current = record.current.copy()
        current[:, joint] = columns @ [1.0, -0.4, *friction] / CONSTANT[joint]
        study.append(replace(record, current=current))
    return joint_samples(study, smooth)[joint].of(BASE_TERMS, ())


def test_a_single_path_is_judged_by_its_own_fit() -> None:
    samples = made(1, LOADED, records=1)
    coefficients = regress_samples(samples, known(1)).coefficients
    predicted = samples.columns @ coefficients
    predicted += samples.held @ held_current(samples, coefficients)
    np.testing.assert_allclose(left_out_residuals(samples, known(1)), samples.current - predicted)


def test_friction_at_rest_beyond_that_in_motion_comes_back_from_many_stops() -> None:
    """Though a fifth of the samples is off by an ampere; from none, it is the usual share."""
    samples = made(1, LOADED, records=30)
    coefficients = regress_samples(samples, known(1)).coefficients
    for held in (0.3, -0.2):
        current = samples.columns @ coefficients + held * samples.held[:, 0]
        current[::5] += 1.0
        stopped = replace(samples, current=current)
        assert held_current(stopped, coefficients) == pytest.approx(held, abs=0.05)
    never = samples.where(samples.moving)
    assert held_current(never, coefficients) == pytest.approx(HELD_FRICTION_SHARE * coefficients[2])


def test_a_single_pose_counts_for_friction_at_rest_as_much_as_other_arms() -> None:
    """However long it lasts: dry friction held the joint there, as it will not elsewhere."""
    samples = made(1, LOADED, records=1)
    coefficients = regress_samples(samples, known(1)).coefficients
    pose = np.flatnonzero(~samples.moving)[:1].repeat(100)
    one = replace(samples.where(pose), held=np.ones((100, 1)))
    for drawn in (-2.0, 0.0):  # times Coulomb friction, beyond that in motion
        current = one.columns @ coefficients + drawn * coefficients[2]
        found = held_current(replace(one, current=current), coefficients)
        assert found / coefficients[2] == pytest.approx((HELD_FRICTION_SHARE + drawn) / 2)


def test_a_moment_of_motion_hardly_moves_what_is_known() -> None:
    """Two blocks leave no residual of five coefficients, which makes none of them sure."""
    samples = made(1, LOADED, records=1)
    few = samples.where(np.flatnonzero(samples.moving)[:15])
    bent = replace(few, current=few.current + 0.01 * np.linspace(-1, 1, 15) ** 2)
    typical = {
        name: Typical(np.array([mean]), np.array([0.2 * mean]))
        for name, mean in (("coulomb", 6.0), ("viscous", 4.0), ("load", 0.05))
    }
    prior = replace(known(1), typical=typical)
    normal = prior.over(prior.terms)
    moved = regress_samples(bent, prior).coefficients - normal.mean
    std = np.sqrt(np.diag(np.linalg.inv(normal.precision)))
    assert (np.abs(moved[2:]) < 0.5 * std[2:]).all()


def steady() -> CurrentSamples:
    """All joints turn at 0.5 rad/s, forwards, for 6 s, without torque or current."""
    count = round(6.0 / PERIOD)
    q = 0.5 * PERIOD * np.arange(count)[:, None] + np.arange(6.0)
    return CurrentSamples("steady", PERIOD, np.zeros(count, int), q, 0 * q + 0.5, 0 * q, 0 * q)


@pytest.mark.parametrize(("period", "size"), [(0.02, 100), (0.3, 7), (1.5, 1), (5.0, 1)])
def test_a_block_is_of_two_seconds_within_a_segment(period: float, size: int) -> None:
    """Whatever the rate; a segment begins one, and the next goes on where the first would."""
    record = replace(steady(), period=period)
    running = np.arange(300) // size
    np.testing.assert_array_equal(blocks(record), running)
    split = replace(record, segment=np.repeat([0, 1], [150, 150]))
    within = 150 % size != 0
    np.testing.assert_array_equal(blocks(split), running + (np.arange(300) >= 150) * within)


def test_samples_are_a_tenth_of_a_second_apart() -> None:
    """Of a slow recording, each sample is one."""
    record = make_record(0)
    for every, count in ((1, 240), (5, 240), (10, 120)):
        slow = cut(record, slice(None, None, every), period=every * PERIOD)
        samples = joint_samples([slow], lambda values, _: values)
        assert [len(own.current) for own in samples] == [count] * 6
        np.testing.assert_array_equal(samples[2].current, record.current[:: max(5, every), 2])


@pytest.mark.parametrize(
    ("period", "every", "same"), [(0.02, 5, True), (0.02, 10, False), (0.1, 2, False)]
)
def test_paths_are_compared_at_a_tenth_of_a_second(period: float, every: int, same: bool) -> None:
    """One of so many samples of a run lies on the path of the other, all others far off."""
    count = 300
    line = 0.5 * period * np.arange(count)[:, None] + np.arange(6.0)
    away = 100.0 * (np.arange(count) % every != 0)[:, None]
    one = replace(steady(), period=period, q=line)
    other = replace(one, q=line + away)
    assert record_paths([one, other]).tolist() == [0, int(not same)]


def test_a_command_that_is_sent_again_is_one_path() -> None:
    """However the arm follows it; efforts that never change are none."""
    one = make_record(0)
    other = replace(one, q=one.q + 1.0)
    assert record_paths([one, make_record(1), other]).tolist() == [0, 1, 0]
    still = [replace(own, current=0 * own.current) for own in (one, other)]
    assert record_paths(still).tolist() == [0, 1]


def scaled(share: float, values: Array, _: object) -> Array:
    return share * values


def test_a_joint_moves_above_the_dead_zone_for_nine_tenths_of_a_lowpass() -> None:
    qd = np.tile([0.019, 0.021, -0.019, -0.021, 0, np.nan], (300, 1))
    record = replace(steady(), qd=qd, q=np.arange(300.0)[:, None] + 0 * qd)
    moves = smoothed_moving(record, lambda values, _: values)[1:]
    np.testing.assert_array_equal(moves, np.tile([0, 1, 0, 1, 0, 0], (299, 1)))
    for share, told in ((0.85, False), (0.95, True)):
        moves = smoothed_moving(record, partial(scaled, share))
        assert (moves[1:, 1] == told).all()


def test_the_side_of_friction_is_unknown_before_the_first_motion() -> None:
    """Not where the motion before is known, which came from there."""
    q, rest = np.repeat(np.linspace(0, 0.01, 60), 5)[:, None] * np.ones(6), np.zeros((300, 6))
    record = replace(steady(), q=q, qd=rest)
    state = motion_states(record, lambda values, _: values)[:, 0]
    assert (state == np.where(q[:, 0] < 2.3e-3, MotionState.UNKNOWN, MotionState.STANDING)).all()
    states = dict.fromkeys(("q", "qd", "qdd", "q_std", "qd_std", "qdd_std", "motor_qd"), q)
    before = Motion(time=PERIOD * np.arange(300), segment=record.segment, **states)
    known = replace(record, before=[before])
    assert (motion_states(known, lambda values, _: values) == MotionState.STANDING).all()
    assert record.joint(0).direction[0] == 0.0
    assert known.joint(0).direction[0] == pytest.approx(1.0)
