"""Loads held for a part of a recording are found with times and mass; pushes and none are not."""

import numpy as np
import pytest

from tests.checks.test_commanded import CONSTANTS, PERIOD, arm, motion
from ur5lib.checks.block_means import BlockMeans, block_means
from ur5lib.checks.load_changes import changed_loads, held_loads
from ur5lib.records.codes import CauseCode, Found
from ur5lib.robots.description import Robot
from ur5lib.robots.statics import geometric_jacobian, load_torque
from ur5lib.tables import channel, named
from ur5lib.timeseries.arrays import Array

__all__ = ["arm"]  # a fixture


def ramp(time: Array, start: float, end: float) -> Array:
    return (np.clip((time - start) / 0.2, 0, 1) * np.clip((end - time) / 0.2, 0, 1))[:, None]


def means_with(
    arm: Robot, mass: float = 0.0, push: float = 0.0, end: float = 11.0, start: float = 6.0
) -> BlockMeans:
    """Means of a motion of 24 s, in which a load is held from 6 s on, or a push lasts 2 s."""
    table, gravity, rubbing = motion(arm)
    time, q = table["time"].to_numpy(), channel(table, "actual_q")
    load = load_torque(arm, q) @ np.array([mass, 0.0, 0.0, 0.08 * mass]) * ramp(time, start, end)
    force = push * np.array([0.5, -0.6, -0.6]) * ramp(time, 12.0, 14.0)
    pushed = np.einsum("nij,ni->nj", geometric_jacobian(arm, q)[:, :3], force)
    current = (gravity + rubbing + load - pushed) / CONSTANTS
    return block_means(table.assign(**named(current, "actual_current")), PERIOD)


@pytest.mark.parametrize("mass", [1.0, 2.5])
@pytest.mark.parametrize("end", [11.0, 99.0])
def test_mass_and_times_are_found(arm: Robot, mass: float, end: float) -> None:
    (found,) = held_loads(means_with(arm, mass, end=end), arm)
    assert found.mass == pytest.approx(mass, rel=0.15)
    assert found.start == pytest.approx(6.0, abs=1.0)
    assert found.end is None if end > 24 else found.end == pytest.approx(end, abs=1.0)


@pytest.mark.parametrize(("start", "end"), [(0.1, 99.0), (-9.0, 23.8), (0.2, 23.9)])
def test_a_load_that_lacks_for_a_moment_alone_does_not_change(
    arm: Robot, start: float, end: float
) -> None:
    assert held_loads(means_with(arm, 3.0, start=start, end=end), arm) == []


@pytest.mark.parametrize("push", [0.0, 20.0, 60.0])
def test_neither_nothing_nor_a_push_of_two_seconds_is_a_load(arm: Robot, push: float) -> None:
    assert held_loads(means_with(arm, push=push), arm) == []


def test_a_fit_is_refused_and_others_are_warned(arm: Robot) -> None:
    means = means_with(arm, 2.0)
    (stop,), (warning,) = (changed_loads(means, arm, fitted) for fitted in (True, False))
    assert (stop.severity, stop.cause, stop.kind) == ("stop", CauseCode.LOAD_CHANGES, "payload")
    assert (warning.severity, warning.code) == ("warning", Found.LOAD_CHANGES)
    for one in (stop, warning):
        assert "kg from 6." in one.detail or "kg from 5." in one.detail


@pytest.mark.parametrize("seed", range(4))
def test_friction_of_pauses_is_no_load(arm: Robot, seed: int) -> None:
    """A joint that rests has any part of its friction, which lasts as a load does."""
    table, gravity, rubbing = motion(arm)
    time, q = table["time"].to_numpy(), channel(table, "actual_q").copy()
    qd, random = channel(table, "actual_qd").copy(), np.random.default_rng(seed)
    for start in (4.0, 12.0):
        rests = (time > start) & (time < start + 5.0)
        q[rests], qd[rests] = q[rests][0], 0.0
        rubbing[rests] = random.uniform(-6, 6, 6) + random.normal(0, 0.1, (rests.sum(), 6))
        gravity[rests] = gravity[rests][0]
    channels = {"actual_q": q, "actual_qd": qd, "actual_current": (gravity + rubbing) / CONSTANTS}
    for name, values in channels.items():
        table = table.assign(**named(values, name))
    assert held_loads(block_means(table, PERIOD), arm) == []
