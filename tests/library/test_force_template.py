"""Runs of one trajectory, whose friction repeats in a way that no formula knows."""

from dataclasses import replace

import numpy as np
import pytest

from ur5lib.force.external_torque import RESTING, STATES, STILL, joint_states
from ur5lib.force.force_input import ForceInput, extent, may_repeat
from ur5lib.force.residual_model import (
    ResidualModel,
    Stretch,
    few_paths,
    fit_residual_model,
)
from ur5lib.force.template import learn_repeats, repeat_aware, same_trajectory, template
from ur5lib.timeseries.segments import unbroken

PERIOD = 0.02
COUNT = 1500
CUTOFF = 2.0
BREAKAWAY = np.array([6.0, 6, 4, 2, 2, 2])


def run(
    seed: int, amplitude: float = 0.5, noise: float = 0.05, period: float = PERIOD
) -> ForceInput:
    """A trajectory of 6 s periods after 3 s of rest; friction by place and direction."""
    random = np.random.default_rng(seed)
    time = np.arange(0, COUNT * PERIOD, period) + random.uniform(0, 0.01) - 3
    phase = 2 * np.pi / 6 * np.maximum(time, 0)[:, None]
    q = amplitude * (1 - np.cos(phase)) * np.linspace(0.5, 1, 6)
    qd = amplitude * np.sin(phase) * np.linspace(0.5, 1, 6) * 2 * np.pi / 6
    place = np.sin(7 * q) + 2 * np.sign(qd)
    torque = place + random.normal(0, noise, q.shape)
    segment = np.zeros(len(time), int)
    return ForceInput(q, qd, torque, joint_states(qd, segment, period), segment, period)


def model_of(*runs: ForceInput) -> ResidualModel:
    stretches = [Stretch(one.torque, one.states, one.period) for one in runs]
    return fit_residual_model(stretches, CUTOFF, BREAKAWAY)


def test_the_template_is_matched_by_place_and_direction() -> None:
    judged, free = run(0), run(1)
    left = judged.torque - template(judged, [free])
    moves = judged.moves()
    assert np.isnan(left[~moves]).all()
    known = np.isfinite(left).all(axis=1)
    assert known[moves].mean() > 0.95
    fast = known & (np.abs(judged.qd).min(axis=1) > 0.1)
    assert left[fast].std() < 0.15
    assert judged.torque[fast].std() > 1.5


def test_only_the_same_trajectory_counts() -> None:
    assert same_trajectory(run(0), run(1))
    assert not same_trajectory(run(0), run(1, amplitude=0.8))
    still = replace(run(2), qd=np.zeros((COUNT, 6)), states=np.full((COUNT, 6), STILL))
    assert not same_trajectory(still, run(1))


@pytest.mark.parametrize("amplitude", [0.2, 0.5, 0.8])
def test_the_extent_excludes_no_run_of_the_same_trajectory(amplitude: float) -> None:
    """And most of those that are not: the file of a run is read only where it may serve."""
    one, other = run(0), run(1, amplitude=amplitude)
    passed = extent(other)
    assert passed is not None
    assert may_repeat(one, passed) >= same_trajectory(one, other)
    assert not may_repeat(one, passed / 10)


def test_a_run_at_rest_offers_nothing() -> None:
    still = run(1, amplitude=0.0)
    assert extent(still) is None
    passed = extent(run(0))
    assert passed is not None
    assert not may_repeat(still, passed)


def test_repeats_are_known_far_better_than_friction() -> None:
    runs = [run(seed) for seed in (1, 2, 3, 4, 5)]
    model = model_of(*runs)
    found = repeat_aware(run(0), runs, model, CUTOFF)
    assert found is not None
    repeated = learn_repeats(runs, CUTOFF, BREAKAWAY)
    assert (repeated.change[0] < 0.5 * model.change[0]).all()
    both = np.concatenate([model.spread, repeated.spread])
    repeating, beside = found
    np.testing.assert_array_equal(beside.spread, both)
    judged = run(0)
    beyond = repeating.states >= STATES
    assert (repeating.states[beyond] - STATES == judged.states[beyond]).all()
    assert not beyond[judged.states >= RESTING].any()
    assert beyond[judged.moves()].mean() > 0.8


def test_a_run_is_not_judged_by_itself() -> None:
    """Of what runs do not share nothing is hidden: each less its likes is off by both's noise."""
    runs = [run(seed, noise=0.5) for seed in (1, 2, 3)]
    learned = learn_repeats(runs, CUTOFF, BREAKAWAY)
    assert (learned.change[0] > 0.9 * few_paths(3) * 0.5 * np.sqrt(2)).all()


def test_where_nothing_repeats_nothing_is_claimed() -> None:
    judged, other = run(0), run(1, amplitude=0.8)
    model = model_of(other)
    assert repeat_aware(judged, [other], model, CUTOFF) is None


def test_one_run_does_not_tell_how_well_it_repeats() -> None:
    judged, free = run(0), run(1)
    model = model_of(free)
    found = repeat_aware(judged, [free], model, CUTOFF)
    assert found is not None
    assert found[1] is model
    np.testing.assert_array_equal(found[0].states, judged.states)


@pytest.mark.parametrize("missing", ["q", "torque"])
def test_missing_rows_match_nothing(missing: str) -> None:
    judged = run(0)
    values = getattr(judged, missing).copy()
    values[600:620] = np.nan
    left = judged.torque - template(replace(judged, **{missing: values}), [run(1)])
    assert np.isnan(left[600:620]).all() == (missing == "q")


def test_two_runs_state_their_band_as_few_as_they_are() -> None:
    """How well two repeat tells little of how well the next one will (Student's t)."""
    runs = [run(1), run(2)]
    left = [
        Stretch((own.torque - template(own, [other]))[rows], own.states[rows], PERIOD)
        for own, other in (runs, runs[::-1])
        for rows in unbroken(own.segment)
    ]
    plain = fit_residual_model(left, CUTOFF, BREAKAWAY)
    learned = learn_repeats(runs, CUTOFF, BREAKAWAY)
    np.testing.assert_allclose(learned.spread, few_paths(2) * plain.spread)
    np.testing.assert_allclose(learned.change, few_paths(2) * plain.change)


def test_runs_of_several_rates_repeat_one_another() -> None:
    """A template is matched by place, not by sample."""
    judged, free = run(0), run(1, period=0.008)
    left = judged.torque - template(judged, [free])
    fast = np.isfinite(left).all(axis=1) & (np.abs(judged.qd).min(axis=1) > 0.1)
    assert left[fast].std() < 0.15
    model = learn_repeats([judged, free], CUTOFF, BREAKAWAY)
    assert np.isfinite(model.spread).all()
