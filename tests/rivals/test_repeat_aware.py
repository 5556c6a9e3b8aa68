"""Runs of one trajectory, whose friction repeats in a way that no formula knows."""

from dataclasses import replace

import numpy as np

from tests.rivals.synthetic_run import synthetic_run
from ur5lib.force.external_torque import JointState, is_still
from ur5rivals.estimators.repeat_aware import learn, noise_of_repeats, repeated
from ur5rivals.force import learned_noise
from ur5rivals.run import Run


def run(seed: int, noise: float = 0.05, *repeats: Run) -> Run:
    """One trajectory, with friction by place and direction that no fit knows."""
    one = synthetic_run()
    error = np.random.default_rng(seed).normal(0, noise, one.q.shape)
    torque = np.sin(7 * one.q) + 2 * np.sign(one.qd) + error
    return replace(one, name=f"run_{seed}", smoothed=torque, repeats=repeats)


def test_what_repeats_is_subtracted_by_place_and_direction() -> None:
    judged = run(0, 0.05, run(1))
    moves = ~is_still(judged.states)
    assert judged.smoothed[moves].std() > 1.5
    assert repeated(judged)[moves].std() < 0.15


def test_another_place_tells_nothing() -> None:
    far = run(1)
    judged = run(0, 0.05, replace(far, q=far.q + 1.0))
    np.testing.assert_array_equal(repeated(judged), judged.smoothed)


def test_repeats_are_known_far_better_than_friction_in_motion() -> None:
    one, two = run(1), run(2)
    runs = replace(one, repeats=(two,)), replace(two, repeats=(one,))
    usual = learned_noise(lambda own: own.smoothed, [one, two])
    noise = noise_of_repeats(usual, runs)
    assert (noise.spread[0] < 0.5 * usual.spread[0]).all()
    np.testing.assert_array_equal(
        noise.spread[JointState.RESTING :], usual.spread[JointState.RESTING :]
    )


def test_one_run_does_not_tell_how_well_it_repeats() -> None:
    usual = learned_noise(lambda own: own.smoothed, [run(1)])
    assert noise_of_repeats(usual, [run(1)]) is usual


def test_where_nothing_repeats_nothing_is_claimed() -> None:
    assert learn([run(1)]).method(run(0)) is None
