"""The smallest pushes that the live estimator finds."""

import numpy as np
import pytest

from tests.made_up_torques import MODEL, jacobians
from tests.rubbing_arm import robot
from tests.topics.live.made_arm import PERIOD, arm_file, samples
from ur5lib.force.external_torque import JointState
from ur5lib.force.force_input import ForceInput
from ur5lib.force.problem import Problem
from ur5lib.force.trial_contacts import TRIAL_SIZES, Trials
from ur5lib.topics.live.measure_live_pushes import live_trials

SPEED = 0.5  # m/s


def tried(noise: float, fastest: float = 2.0) -> Trials:
    """Trials on a motion of half a minute; noise: [Nm]; fastest: speed seen [rad/s]."""
    run, file = samples(30.0, moving=True), arm_file(noise) | {"speed": [fastest] * 6}
    states = np.full(run.q.shape, JointState.MOVING, np.int8)
    segment = np.zeros(len(run.q), np.int64)
    assert run.qd is not None
    one = ForceInput(run.q, run.qd, 0 * run.q, states, segment, PERIOD)
    speed = np.full(len(run.q), SPEED)
    return live_trials(file, run, Problem(one, MODEL), jacobians(robot(), run.q), speed, least=40)


def test_of_pushes_the_live_estimator_finds_the_large_ones() -> None:
    """In units of its noise, which is the same along all axes."""
    trials = tried(0.3)
    assert len(trials.force) >= 40
    typical = arm_file()["contacts"]["typical"]
    ends = trials.force.min() / typical, trials.force.max() / typical
    assert ends == pytest.approx(TRIAL_SIZES, rel=0.15)
    in_units = trials.force / trials.unit
    assert trials.found[in_units > 15].all()
    assert not trials.found[in_units < 1].any()
    noisier = tried(3.0)
    assert noisier.found.mean() < trials.found.mean()
    assert np.median(noisier.unit) == pytest.approx(10 * np.median(trials.unit), rel=0.1)


def test_where_it_knows_nothing_it_feels_no_push() -> None:
    assert not tried(0.3, fastest=0.02).felt(1e9).any()
