"""Runs of one trajectory, whose friction repeats in a way that no formula knows."""

from dataclasses import replace

import numpy as np
import pytest

from ur5lib.force.external_torque import RESTING, STATES, joint_states
from ur5lib.force.residual_model import fit_residual_model
from ur5lib.force.template import Run, learn_repeats, repeat_aware, same_trajectory, template

PERIOD = 0.02
COUNT = 1500


def run(seed: int, amplitude: float = 0.5, noise: float = 0.05) -> Run:
    """A trajectory of 6 s periods after 3 s of rest; friction by place and direction."""
    random = np.random.default_rng(seed)
    time = np.arange(COUNT) * PERIOD + random.uniform(0, 0.01) - 3
    phase = 2 * np.pi / 6 * np.maximum(time, 0)[:, None]
    q = amplitude * (1 - np.cos(phase)) * np.linspace(0.5, 1, 6)
    qd = amplitude * np.sin(phase) * np.linspace(0.5, 1, 6) * 2 * np.pi / 6
    place = np.sin(7 * q) + 2 * np.sign(qd)
    torque = place + random.normal(0, noise, (COUNT, 6))
    segment = np.zeros(COUNT, int)
    return Run(q, qd, torque, joint_states(qd, segment, PERIOD), segment)


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
    still = replace(run(2), qd=np.zeros((COUNT, 6)), states=np.full((COUNT, 6), RESTING))
    assert not same_trajectory(still, run(1))


def test_a_push_is_left_over() -> None:
    judged = run(0)
    pushed = judged.torque.copy()
    pushed[700:750] += 3.0
    left = pushed - template(replace(judged, torque=pushed), [run(1)])
    np.testing.assert_allclose(np.nanmedian(left[700:750], axis=0), 3.0, atol=0.1)


def test_repeats_are_known_far_better_than_friction() -> None:
    runs = [run(1), run(2)]
    model = fit_residual_model([(r.torque, r.states) for r in runs], PERIOD, 2.0)
    found = repeat_aware(run(0), runs, model, PERIOD, 2.0)
    assert found is not None
    repeated = learn_repeats(runs, PERIOD, 2.0)
    assert (repeated.change[0] < 0.3 * model.change[0]).all()
    both = np.concatenate([model.spread, repeated.spread])
    np.testing.assert_array_equal(found.model.spread, both)
    judged = run(0)
    beyond = found.states >= STATES
    assert (found.states[beyond] - STATES == judged.states[beyond]).all()
    assert not beyond[judged.states == RESTING].any()
    assert beyond[judged.moves()].mean() > 0.8


def test_where_nothing_repeats_nothing_is_claimed() -> None:
    judged, other = run(0), run(1, amplitude=0.8)
    model = fit_residual_model([(other.torque, other.states)], PERIOD, 2.0)
    assert repeat_aware(judged, [other], model, PERIOD, 2.0) is None


def test_one_run_does_not_tell_how_well_it_repeats() -> None:
    judged, free = run(0), run(1)
    model = fit_residual_model([(free.torque, free.states)], PERIOD, 2.0)
    found = repeat_aware(judged, [free], model, PERIOD, 2.0)
    assert found is not None
    assert found.model is model
    np.testing.assert_array_equal(found.states, judged.states)


@pytest.mark.parametrize("missing", ["q", "torque"])
def test_missing_rows_match_nothing(missing: str) -> None:
    judged = run(0)
    values = getattr(judged, missing).copy()
    values[600:620] = np.nan
    left = judged.torque - template(replace(judged, **{missing: values}), [run(1)])
    assert np.isnan(left[600:620]).all() == (missing == "q")
