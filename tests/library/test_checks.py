"""From which difference on channels contradict one another."""

import numpy as np
import pandas as pd
import pytest

from tests.library.test_recordings import PERIOD, contradictions, moving_robot
from ur5lib.recordings.checks import check_force_sensor, check_robot, touched

CURRENTS = [f"actual_current_{joint}" for joint in range(6)]


def reported(table: pd.DataFrame, words: str) -> list[str]:
    return [one for one in contradictions(table) if words in one]


@pytest.mark.parametrize(
    ("factor", "wrong"), [(0.92, False), (0.88, True), (1.08, False), (1.12, True)]
)
def test_a_ratio_to_the_derivative_is_one_within_a_tenth(factor: float, wrong: bool) -> None:
    table = moving_robot()
    table["actual_q_1"] *= factor
    assert bool(reported(table, "not the derivative")) == wrong


@pytest.mark.parametrize(("size", "judged"), [(0.065, False), (0.076, True)])
def test_a_joint_is_judged_that_moves_by_a_twentieth(size: float, judged: bool) -> None:
    """Of a radian per second, root mean square: a swing's peak is 1.41 times that."""
    table = moving_robot()
    time = table["time"].to_numpy()
    table["actual_qd_0"], table["actual_q_0"] = size * np.cos(time), 0.0
    table["target_q_0"] = 0.0
    assert bool(reported(table, "actual_qd is not the derivative of actual_q ")) == judged
    table["actual_qd_0"], table["actual_q_0"] = 0.0, size * np.sin(time)
    assert bool(reported(table, "actual_qd is not the derivative of actual_q ")) == judged


@pytest.mark.parametrize(("apart", "wrong"), [(2.4, False), (2.6, True)])
def test_currents_part_by_more_than_two_and_a_half_amperes(apart: float, wrong: bool) -> None:
    """In the median: half of the time they may be anywhere."""
    table = moving_robot()
    table["actual_current_2"] = table["target_current_2"] + apart
    assert bool(reported(table, "actual_current and target_current differ on joints 3;")) == wrong
    table.loc[: len(table) // 2 + 5, "actual_current_2"] = table["target_current_2"]
    assert not reported(table, "actual_current and target_current differ")


@pytest.mark.parametrize(
    ("factor", "wrong"), [(0.45, True), (0.55, False), (190.0, False), (210.0, True)]
)
def test_moments_are_half_to_two_hundred_times_their_currents(factor: float, wrong: bool) -> None:
    """In newton metres per ampere, whatever the gears."""
    table = moving_robot()
    for joint in range(6):
        table[f"target_moment_{joint}"] *= factor
    assert bool(reported(table, "root mean square of target_moment")) == wrong


@pytest.mark.parametrize(("level", "wrong"), [(0.45, False), (0.55, True)])
def test_small_currents_are_not_compared(level: float, wrong: bool) -> None:
    """Below half an ampere there is only friction and noise."""
    table = moving_robot()
    size = np.sqrt(np.mean(table[CURRENTS].to_numpy() ** 2))
    for joint in range(6):
        table[f"actual_current_{joint}"] *= level / size
        table[f"target_current_{joint}"] = table[f"target_moment_{joint}"] = 0.0
    assert bool(reported(table, "root mean square of actual_current")) == wrong


@pytest.mark.parametrize(("share", "swapped"), [(0.32, False), (0.28, True)])
def test_a_swap_cuts_the_deviation_to_three_tenths(share: float, swapped: bool) -> None:
    """Each stands beside the other's target, by a part of what it is off its own."""
    table = moving_robot()
    for joint in range(6):
        for name in ("target_current", "actual_current", "target_moment"):
            table[f"{name}_{joint}"] = 10.0 * joint
    table["target_current_0"], table["target_current_1"] = 0.0, 1.0
    beyond = share / (1 - share)
    table["actual_current_0"], table["actual_current_1"] = 1.0 + beyond, -beyond
    assert bool(reported(table, "swapped")) == swapped


def test_what_is_missing_is_not_judged() -> None:
    """A recording of positions alone; rows that were filled in count for no derivative."""
    table = moving_robot()
    alone = table[["time", "segment", "interpolated", *(f"actual_q_{j}" for j in range(6))]]
    assert check_robot(alone, PERIOD, [6.3] * 6, [3.2] * 6) == []
    filled = table.copy()
    filled.loc[100:2500, "interpolated"] = True
    filled.loc[101:2499, "actual_q_3"] *= 1.5
    assert not reported(filled, "not the derivative")


@pytest.mark.parametrize(("size", "reported"), [(2.9, False), (3.1, True)])
def test_gravity_turns_by_three_newtons_in_an_imu(size: float, reported: bool) -> None:
    """A tool's weight on an arm that hardly turns is no acceleration."""
    angle = np.linspace(0, 2 * np.arcsin(size / 2 / 9.81), 400) - np.arcsin(size / 2 / 9.81)
    force = 9.81 * np.column_stack([np.sin(angle), np.cos(angle), 0 * angle])
    table = pd.DataFrame(force, columns=["ft_fx", "ft_fy", "ft_fz"]).assign(time=angle)
    found = [one.finding for one in check_force_sensor(table)]
    assert ("size of gravity" in found) == reported


@pytest.mark.parametrize(
    ("newton", "seconds", "mass", "found"),
    [(29.0, 1.0, 0.0, 1), (14.0, 1.0, 0.0, 0), (29.0, 0.4, 0.0, 0), (29.0, 1.0, 1.0, 0)],
)
def test_a_contact_in_a_free_recording_is_found(
    newton: float, seconds: float, mass: float, found: int
) -> None:
    """29 N for a second; less, shorter, or the weight of a tool that turns is none."""
    time = np.arange(0, 10, 0.01)
    force = np.where(time < seconds, newton, 0.0) + 3.0  # and a bias
    table = pd.DataFrame({"time": time, "ft_fx": force, "ft_fy": 0.0, "ft_fz": -4.0})
    assert len(touched(table, mass)) == found
