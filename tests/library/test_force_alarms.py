"""Alarms by the size of a force, and their threshold."""

import numpy as np
import pytest

from ur5lib.force.detection import STEP, TOUCH, force_alarms, force_threshold, pushes_above

PERIOD = 0.01  # s


def bumps(heights: list[float], floor: float = 0.0) -> np.ndarray:
    """A minute of force with bumps of a second each."""
    force = np.full(round(60 / PERIOD), floor)
    for i, height in enumerate(heights):
        force[(2 * i + 1) * 100 : (2 * i + 2) * 100] = height
    return force


def test_an_alarm_lasts_until_two_thirds_of_its_threshold() -> None:
    force = np.array([0, 7, 10, 7, 6, 9, np.nan, 12.0])
    assert force_alarms(force, 9.0) == [(1, 4), (5, 6), (7, 8)]
    assert force_alarms(force, 13.0) == []


def test_the_threshold_allows_as_many_alarms_as_asked() -> None:
    runs = [bumps([5.0, 20.0, 30.0]), bumps([40.0, 8.0])]
    threshold = force_threshold(runs, [PERIOD] * 2, per_minute=1)
    assert sum(len(force_alarms(run, threshold)) for run in runs) == 2
    assert sum(len(force_alarms(run, threshold - STEP)) for run in runs) == 3
    assert 20 < threshold <= 20 + STEP


def test_an_alarm_without_end_is_no_reason_for_a_low_threshold() -> None:
    """Below 10 N the whole minute is one alarm, above it there are three."""
    run = bumps([30.0, 30.0, 30.0], floor=10.0)
    assert len(force_alarms(run, 5.0)) == 1
    assert force_threshold([run], [PERIOD], per_minute=1) > 30


def test_without_any_force_the_threshold_is_that_of_the_sensor() -> None:
    assert force_threshold([bumps([])], [PERIOD], per_minute=1) == pytest.approx(TOUCH, abs=STEP)


def test_a_push_is_found_whichever_way_it_points_and_an_unknown_one_is_not() -> None:
    sensed = bumps([12.0, -15.0, 20.0, 4.0])
    force = -sensed
    assert pushes_above(force, sensed, 10.0, PERIOD) == (3, 3)
    force[500:600] = np.nan
    assert pushes_above(force, sensed, 10.0, PERIOD) == (3, 2)
    assert pushes_above(0.5 * sensed, sensed, 10.0, PERIOD) == (3, 1)
