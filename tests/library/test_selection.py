"""Which friction terms are taken, and what of the recordings counts for it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.library.current_study import (
    CONSTANT,
    PERIOD,
    PRESLIDING,
    cut,
    make_record,
    prior,
    smooth,
)
from ur5lib.identification.prior import Prior, Typical
from ur5lib.identification.samples import (
    Record,
    Samples,
    blocks,
    columns_of,
    joint_samples,
    record_paths,
    smoothed_moving,
)
from ur5lib.identification.selection import (
    HELD,
    choose_terms,
    held_current,
    left_out_errors,
    left_out_residuals,
    regress_samples,
)
from ur5lib.robots.friction import BASE, Term

COULOMB, VISCOUS, LOAD = BASE
ASYMMETRIC, QUADRATIC = Term("asymmetric"), Term("quadratic")
WAYS = [PRESLIDING] * 6


def known(joint: int) -> Prior:
    return prior().of_joint(joint)


def made(joint: int, friction: dict[Term, float], records: int = 6, pace: float = 1.0) -> Samples:
    """Samples of a joint with a friction [Nm, ...], without noise, at some 1 rad/s times a pace."""
    study = []
    for seed in range(records):
        record = make_record(seed)
        record = replace(record, q=pace * record.q, qd=pace * record.qd)
        columns, _ = columns_of(record.joint(joint, PRESLIDING), tuple(friction))
        current = record.current.copy()
        current[:, joint] = columns @ [1.0, -0.4, *friction.values()] / CONSTANT[joint]
        study.append(replace(record, current=current))
    return joint_samples(study, smooth, (ASYMMETRIC, QUADRATIC), WAYS)[joint]


@pytest.mark.parametrize(
    ("joint", "friction", "more"),
    [
        (1, {COULOMB: 6, VISCOUS: 4, LOAD: 0.05, ASYMMETRIC: 3}, (ASYMMETRIC,)),
        (1, {COULOMB: 6, VISCOUS: 4, LOAD: -0.3, ASYMMETRIC: 3}, ()),  # drives beyond 20 Nm
        (1, {COULOMB: 3, VISCOUS: 4, LOAD: 0.05, QUADRATIC: 3}, (QUADRATIC,)),
        (1, {COULOMB: 3, VISCOUS: 4, LOAD: 0.05, QUADRATIC: -8}, ()),  # drives at 1 rad/s
        (0, {COULOMB: 3, VISCOUS: 9, LOAD: 0, QUADRATIC: -8}, (QUADRATIC,)),
        (1, {COULOMB: 6, VISCOUS: 4, LOAD: 0.05, ASYMMETRIC: 3, QUADRATIC: 6}, None),  # both
    ],
)
def test_a_term_is_taken_that_explains_the_current_and_brakes(
    joint: int, friction: dict[Term, float], more: tuple[Term, ...] | None
) -> None:
    chosen = choose_terms(made(joint, friction), known(joint))
    assert chosen[: len(BASE)] == BASE
    if more is None:
        assert {*chosen[len(BASE) :]} == {ASYMMETRIC, QUADRATIC}
    else:
        assert chosen[len(BASE) :] == more


def test_what_drives_beyond_the_speeds_of_a_recording_may_be_taken() -> None:
    """3 + 9 v - 8 v² brakes up to half a radian per second, not at two."""
    slow = made(0, {COULOMB: 3, VISCOUS: 9, LOAD: 0, QUADRATIC: -8}, pace=0.5)
    assert choose_terms(slow, known(0)) == (*BASE, QUADRATIC)


def test_with_one_path_no_term_can_be_left_out() -> None:
    alone = made(1, {COULOMB: 6, VISCOUS: 4, LOAD: 0.05, ASYMMETRIC: 3}, records=1)
    assert choose_terms(alone, known(1)) == BASE
    assert np.isnan(left_out_residuals(alone, BASE, known(1))).all()
    assert len(left_out_errors(alone, BASE, known(1))) == 0


@pytest.mark.parametrize(("count", "units"), [(19, 4), (20, 5)])
def test_a_unit_counts_from_twenty_samples_on(count: int, units: int) -> None:
    """Two seconds; of each the root mean square of what the others predict of it."""
    samples = made(1, {COULOMB: 6, VISCOUS: 4, LOAD: 0.05, ASYMMETRIC: 3}, records=5)
    kept = np.ones(len(samples.current), bool)
    kept[np.flatnonzero(samples.path == 2)[count:]] = False
    part = samples.where(kept)
    part = replace(part, unit=part.path)
    errors = left_out_errors(part, BASE, known(1))
    assert len(errors) == units
    residual = left_out_residuals(part, BASE, known(1))
    np.testing.assert_allclose(errors[0], np.sqrt(np.mean(residual[part.unit == 0] ** 2)))


def test_friction_at_rest_beyond_that_in_motion_comes_back_from_many_stops() -> None:
    """Though a fifth of the samples is off by an ampere; from none, it is the usual share."""
    samples = made(1, {COULOMB: 6, VISCOUS: 4, LOAD: 0.05}, records=30)
    coefficients = regress_samples(samples, BASE, known(1)).coefficients
    for held in (0.3, -0.2):
        current = samples.design(BASE) @ coefficients + held * samples.held
        current[::5] += 1.0
        stopped = replace(samples, current=current)
        assert held_current(stopped, BASE, coefficients) == pytest.approx(held, abs=0.05)
    never = samples.where(samples.moving)
    assert held_current(never, BASE, coefficients) == pytest.approx(HELD * coefficients[2])


def test_a_single_pose_counts_for_friction_at_rest_as_much_as_other_arms() -> None:
    """However long it lasts: dry friction held the joint there, as it will not elsewhere."""
    samples = made(1, {COULOMB: 6, VISCOUS: 4, LOAD: 0.05}, records=1)
    coefficients = regress_samples(samples, BASE, known(1)).coefficients
    pose = np.flatnonzero(~samples.moving)[:1].repeat(100)
    one = replace(samples.where(pose), held=np.ones(100))
    for drawn in (-2.0, 0.0):  # times Coulomb friction, beyond that in motion
        current = one.design(BASE) @ coefficients + drawn * coefficients[2]
        found = held_current(replace(one, current=current), BASE, coefficients)
        assert found / coefficients[2] == pytest.approx((HELD + drawn) / 2)


def test_a_moment_of_motion_hardly_moves_what_is_known() -> None:
    """Two blocks leave no residual of five coefficients, which makes none of them sure."""
    samples = made(1, {COULOMB: 6, VISCOUS: 4, LOAD: 0.05}, records=1)
    few = samples.where(np.flatnonzero(samples.moving)[:15])
    bent = replace(few, current=few.current + 0.01 * np.linspace(-1, 1, 15) ** 2)
    typical = {
        name: Typical(np.array([mean]), np.array([0.2 * mean]))
        for name, mean in (("coulomb", 6.0), ("viscous", 4.0), ("load", 0.05))
    }
    prior = replace(known(1), typical=typical)
    normal = prior.over([BASE])
    moved = regress_samples(bent, BASE, prior).coefficients - normal.mean
    std = np.sqrt(np.diag(np.linalg.inv(normal.precision)))
    assert (np.abs(moved[2:]) < 0.5 * std[2:]).all()


def steady() -> Record:
    """All joints turn at 0.5 rad/s, forwards, for 6 s, without torque or current."""
    count = round(6.0 / PERIOD)
    q = 0.5 * PERIOD * np.arange(count)[:, None] + np.arange(6.0)
    return Record("steady", PERIOD, np.zeros(count, int), q, 0 * q + 0.5, 0 * q, 0 * q)


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
        samples = joint_samples([slow], lambda values, _: values, (), WAYS)
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


def test_a_joint_moves_above_the_dead_zone_for_nine_tenths_of_a_lowpass() -> None:
    record = replace(steady(), qd=np.tile([0.019, 0.021, -0.019, -0.021, 0, np.nan], (300, 1)))
    moves = smoothed_moving(record, lambda values, _: values)
    np.testing.assert_array_equal(moves, np.tile([0, 1, 0, 1, 0, 0], (300, 1)))
    for share, told in ((0.85, False), (0.95, True)):
        assert (smoothed_moving(record, lambda values, _, s=share: s * values)[:, 1] == told).all()
