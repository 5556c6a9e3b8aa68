"""A command of another kind is left out, not a stop sign, where what is measured is the arm's."""

import numpy as np
import pandas as pd
import pytest

from ur5lib.checks.commanded import without_command
from ur5lib.robots.description import Robot, load_robot, robot_path
from ur5lib.robots.statics import gravity_torque
from ur5lib.tables import named
from ur5lib.timeseries.arrays import Array

PERIOD = 0.008
CONSTANTS = np.array([9.93, 9.93, 9.93, 7.77, 7.77, 7.77])


@pytest.fixture(scope="module")
def arm() -> Robot:
    return load_robot(robot_path("ur5e"))


def motion(arm: Robot) -> tuple[pd.DataFrame, Array, Array]:
    """A table of a swinging arm; the torque of its gravity, and of all but that (N, 6) [Nm]."""
    time = PERIOD * np.arange(3000)
    rates = np.array([0.7, 0.5, 0.9, 0.6, 0.8, 1.1])
    middle = np.array([0.2, -1.3, 1.2, -1.0, 1.3, 0.2])
    q = middle + 0.6 * np.sin(np.outer(time, rates))
    qd = 0.6 * rates * np.cos(np.outer(time, rates))
    frames = pd.DataFrame({"time": time, "segment": 0, "interpolated": False})
    gravity = gravity_torque(arm, arm.chosen_model, q)
    rubbing = 6.0 * np.tanh(qd / 0.02) + np.random.default_rng(1).normal(0, 0.1, q.shape)
    table = frames.assign(**named(q, "actual_q"), **named(qd, "actual_qd"))
    return table, gravity, rubbing


@pytest.mark.parametrize(
    ("gravity_share", "kind"),
    [(0.0, "less gravity"), (0.5, "scaled by 0.5"), (2.0, "scaled by 2"), (1.0, ""), (1.1, "")],
)
def test_a_command_is_no_stop_sign(arm: Robot, gravity_share: float, kind: str) -> None:
    table, gravity, rubbing = motion(arm)
    currents = (gravity + rubbing) / CONSTANTS
    target = gravity_share * gravity + 0.1 * rubbing
    whole = table.assign(**named(currents, "actual_current"), **named(target, "target_moment"))
    kept, findings = without_command(whole, PERIOD, arm)
    assert ("target_moment_0" in kept) is not bool(kind)
    assert [kind in one.detail for one in findings] == [True] * bool(kind)


def test_what_no_measured_effort_confirms_stays(arm: Robot) -> None:
    table, gravity, rubbing = motion(arm)
    target = named(rubbing, "target_moment")
    for effort in ({}, named((3 * gravity + rubbing) / CONSTANTS, "actual_current")):
        whole = table.assign(**effort, **target)
        assert "target_moment_0" in without_command(whole, PERIOD, arm)[0]
