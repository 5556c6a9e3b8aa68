"""Which windows there are, and what they have of a recording."""

from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from ur5lib.identification.samples import CurrentSamples
from ur5lib.timeseries.arrays import Labels
from ur5lib.topics.rollout.simulation import STEP
from ur5lib.topics.rollout.windows import (
    HORIZONS,
    LENGTH,
    STEPS,
    joined,
    starts_of,
    starts_within,
    windows_at,
)

PERIOD = 0.008  # s


def moving(seconds: float, period: float = PERIOD, **changed: Any) -> CurrentSamples:
    """A joint that turns and turns back, with an effort that grows with time, beside one
    that rests.
    """
    time = period * np.arange(round(seconds / period) + 1)
    q = np.column_stack([np.sin(time), 0 * time])
    qd = np.column_stack([np.cos(time), 0 * time])
    effort = np.column_stack([time, 1 + 0 * time])
    segment = np.zeros(len(time), dtype=np.int64)
    record = CurrentSamples("one", period, segment, q, qd, 0 * q, effort)
    return replace(record, **changed)


def ends(record: CurrentSamples, starts: Labels) -> list[tuple[float, float]]:
    return [(row * record.period, row * record.period + LENGTH) for row in starts]


def test_windows_lie_side_by_side_in_unbroken_stretches() -> None:
    """None across a gap, an unknown effort or a contact, which has none; none shares a sample's
    motion with another.
    """
    record = moving(20.0)
    assert len(starts_of(record)) == 10
    broken = replace(record, segment=(np.arange(2501) >= 450).astype(np.int64))
    effort = record.current.copy()
    effort[1300] = np.nan
    for own, unknown in ((broken, 3.6), (replace(record, current=effort), 10.4)):
        found = ends(own, starts_of(own))
        assert all(not start < unknown <= end for start, end in found)
        assert all(end <= start + 1e-9 for (_, end), (start, _) in pairwise(found))
        assert len(found) >= 8


def test_an_arm_at_rest_has_no_window() -> None:
    """Where no joint moves, standing still is right. Nor has a recording that is too short."""
    record = moving(6.0)
    moves = (PERIOD * np.arange(len(record.q)) > 4.1)[:, None]
    assert starts_of(replace(record, qd=record.qd * moves)).tolist() == [500]
    assert starts_of(moving(1.9)).tolist() == []
    assert starts_within(record, np.array([0, 500, 501])).tolist() == [0, 500]


@pytest.mark.parametrize("period", [0.002, PERIOD, 0.1])
def test_a_window_has_what_was_recorded(period: float) -> None:
    """Postures between samples, too; the impulse of the efforts is kept at each rate."""
    record = moving(6.0, period)
    rows = starts_of(record)[1:]
    own = joined([windows_at(record, rows[:1], 0), windows_at(record, rows[1:], 1)])
    start = rows * period
    assert own.recording.tolist() == [0, 1]
    np.testing.assert_array_equal(own.q[:, 0], np.sin(start))
    np.testing.assert_allclose(own.reached[..., 0], np.sin(start[:, None] + HORIZONS), atol=1e-6)
    middles = start[:, None] + STEP * (np.arange(STEPS) + 0.5)
    np.testing.assert_allclose(own.effort[..., 0], middles)
    np.testing.assert_allclose(own.effort[..., 1], 1.0)


def test_friction_opposes_the_motion_before_a_window() -> None:
    record = moving(6.0)
    own = windows_at(
        record, np.array([100, 300]), 0
    )  # after 0.8 s it turned forth, after 2.4 s back
    np.testing.assert_allclose(own.direction[:, 0], [1, -1])
