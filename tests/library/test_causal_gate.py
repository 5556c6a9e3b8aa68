"""The odds of contact from past samples: nothing later changes them, and pushes are found soon."""

from dataclasses import replace

import numpy as np
import pytest

from tests.library.made_up_torques import MODEL, PERIOD, PRIOR, Free, between, free_run
from ur5lib.force.causal_gate import causal_log_odds
from ur5lib.force.detection import live_alarms
from ur5lib.force.external_torque import JointState, past_states
from ur5lib.force.force_input import ForceInput
from ur5lib.force.wrench_estimate import used_rows
from ur5lib.identification.samples import CurrentSamples
from ur5lib.robots.description import Robot
from ur5lib.steps.predict_currents import causally_smoothed
from ur5lib.timeseries.arrays import Array

CUTOFF = 2.0  # Hz
RANDOM = np.random.default_rng(0)


def odds(run: Free, current: Array | None = None, segment: Array | None = None) -> Array:
    """From the currents, in Nm, of a motion that needs none, to the odds."""
    segment, step = np.zeros(len(run.time), int) if segment is None else segment, run.time[1]
    current = -run.torque if current is None else current
    record = CurrentSamples("run", step, segment, run.q, run.qd, 0 * current, current)
    torque = causally_smoothed(-current, record, CUTOFF)
    states = past_states(run.qd, segment, step)
    one = ForceInput(run.q, run.qd, torque, states, segment, step)
    return causal_log_odds(one, run.jacobian[used_rows(segment, step)], MODEL, PRIOR)


def pushed(run: Free, start: float, end: float, size: float = 40.0) -> Free:
    force = size * between(run.time, start, end)[:, None] * np.eye(3)[2]
    return run.pushed(run.wrench(force))


@pytest.mark.parametrize(
    ("cut", "moving", "period"), [(3.0, True, 0.008), (4.2, True, PERIOD), (4.9, False, PERIOD)]
)
def test_what_comes_later_changes_nothing(
    ur5: Robot, cut: float, moving: bool, period: float
) -> None:
    """Before a push, while its alarm is raised, and within; the motion changes as well."""
    run = pushed(free_run(ur5, 3, 6.0, moving, period=period), 4.0, 5.0)
    later = run.time > cut
    other = replace(
        run,
        qd=np.where(later[:, None], RANDOM.normal(size=run.qd.shape), run.qd),
        torque=np.where(later[:, None], 100 * RANDOM.normal(size=run.qd.shape), run.torque),
        jacobian=np.where(later[:, None, None], np.nan, run.jacobian),
    )
    before, after = odds(run), odds(other)
    np.testing.assert_array_equal(before[~later], after[~later])
    assert not np.array_equal(before[later], after[later])


def test_every_stretch_is_judged_alone(ur5: Robot) -> None:
    """By its own samples from its start on, of whatever number."""
    run = pushed(free_run(ur5, 5, 14.0), 8.0, 9.0)
    segment = (np.arange(len(run.time)) >= 255).astype(int)
    found = np.clip(odds(run, segment=segment), -20, 20)
    for part in (slice(255), slice(255, None)):
        own = Free(*(getattr(run, name)[part] for name in vars(run)))
        alone = odds(replace(own, time=own.time - own.time[0]))
        np.testing.assert_allclose(found[part], np.clip(alone, -20, 20), rtol=1e-6)


@pytest.mark.parametrize("moving", [True, False])
def test_a_push_is_found_soon_and_none_is_made_up(ur5: Robot, moving: bool) -> None:
    run = free_run(ur5, 11, 20.0, moving)
    assert live_alarms(odds(run), 0.0) == []
    ((first, _),) = live_alarms(odds(pushed(run, 12.0, 13.5, 60.0)), 0.0)
    assert 0 < run.time[first] - 12.0 < 0.6


def test_unknown_torques_leave_the_odds_to_the_prior(ur5: Robot) -> None:
    run = free_run(ur5, 11, 20.0)
    current = -run.torque.copy()
    current[100:] = np.nan
    found = odds(run, current)
    assert np.isfinite(found).all()
    assert np.abs(found[-1] - found[-100]) < 0.1


def test_states_from_the_past() -> None:
    """A second of motion, two at rest, and motion again; the other joints move throughout."""
    step = 0.01
    qd = np.ones((400, 6))
    qd[100:300, 0] = 0.0
    states = past_states(qd, np.zeros(400, int), step)
    assert (states[:, 1:] == JointState.MOVING).all()
    stops = [states[at, 0] for at in (99, 101, 135, 145, 200, 290, 301, 348, 360)]
    settles = [JointState.SETTLING, JointState.SETTLING, JointState.RESTING]
    assert stops == [
        JointState.MOVING,
        JointState.REVERSING,
        JointState.REVERSING,
        *settles,
        JointState.REVERSING,
        JointState.REVERSING,
        JointState.MOVING,
    ]
    qd[:] = 0.0
    assert (past_states(qd, np.zeros(400, int), step) == JointState.STILL).all()
