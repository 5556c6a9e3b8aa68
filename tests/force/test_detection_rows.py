"""Each number of detection.csv and contacts.csv, once more from the samples of a drawn run."""

import numpy as np
import pytest
from scipy.stats import mannwhitneyu

from tests.made_records import stretch
from ur5lib.force.alarms import Alarm, alarms_of, detections, raised
from ur5lib.force.estimators import Stated
from ur5lib.records.contacts import Detection
from ur5lib.records.forces import SensorWrenches
from ur5lib.timeseries.arrays import Array, Mask

PERIOD, COUNT, LEAST = 0.02, 30_000, 4.0  # s, samples: ten minutes; N
FALSE = 7  # alarms far from any contact


def bumps(starts: Array, heights: Array, length: int) -> Array:
    """Pushes (N,) [N] of a second along x, flat at their height."""
    force = np.zeros(COUNT)
    for start, height in zip(starts, heights, strict=True):
        force[start : start + length] = height
    return force


RANDOM = np.random.default_rng(2)
STARTS = 300 + 700 * np.arange(40)
HEIGHTS = RANDOM.choice([4.0, 7.0, 12.0, 30.0], 40)  # N
SEEN = (RANDOM.random(40) < 0.7) & (HEIGHTS > 5)
LATE = RANDOM.integers(1, 20, 40)  # samples
SENSED = bumps(STARTS, HEIGHTS, 50)
SHOWN = bumps((STARTS + LATE)[SEEN], 0.8 * HEIGHTS[SEEN], 50)
SHOWN += bumps(STARTS[:FALSE] + 300, np.full(FALSE, 6.0), 40)
SIZE = SHOWN * (1 + 0.1 * np.sin(np.arange(COUNT))) + 1e-3 * RANDOM.random(COUNT)  # N
DEVIATION = 0.1 + 0.01 * np.arange(COUNT)
DIRECTION = np.array([0.6, 0.0, -0.8])
MOMENT = RANDOM.uniform(0, 20, (COUNT, 3))  # Nm; no alarm depends on it


def along(force: Array) -> Array:
    """Wrenches (N, 6) of forces along one direction, and of any moment."""
    return np.hstack([np.outer(force, DIRECTION), MOMENT])


@pytest.fixture(scope="module")
def told() -> tuple[list[Alarm], dict[float | None, Detection]]:
    """Alarms of an estimate by the size of its force, and the rows by class of contacts."""
    sensor = SensorWrenches(
        **stretch(PERIOD * np.arange(COUNT)), wrench={"compensated": along(SENSED)}
    )
    own = alarms_of(Stated(along(SIZE), np.outer(DEVIATION, np.ones(6)), None), LEAST)
    q = np.outer(np.arange(COUNT), np.ones(6))
    every = raised(own, sensor, q, np.arange(COUNT) / 100, lambda _, one: one)
    rows = detections("least_squares", own, every, sensor, LEAST)
    return every, {row.force_class_n: row for row in rows}


def in_alarm() -> Mask:
    return SHOWN > 0


def test_alarms_are_counted_with_their_time(told: tuple) -> None:
    every, rows = told
    free = np.ones(COUNT, bool)  # half a second and more away from what the sensor feels
    for start in STARTS:
        free[start - 25 : start + 75] = False
    assert len(every) == SEEN.sum() + FALSE
    for row in rows.values():
        assert (row.alarms, row.threshold) == (len(every), LEAST)
        assert row.alarms_per_min == pytest.approx(len(every) / 10)
        assert row.time_in_alarm == pytest.approx(in_alarm().mean())
        assert row.free_time_in_alarm == pytest.approx(in_alarm()[free].mean())
        assert row.precision == pytest.approx(SEEN.sum() / len(every))
        assert row.false_alarms_per_min == pytest.approx(FALSE / 10)
        assert row.extra_alarms == 0


def test_contacts_are_counted_by_the_force_that_they_reach(told: tuple) -> None:
    _, rows = told
    assert [*rows] == [3.0, 5.0, 10.0, 15.0]
    for least, row in rows.items():
        reach = least <= HEIGHTS
        assert (row.contacts, row.found) == (reach.sum(), (reach & SEEN).sum())
        assert row.recall == pytest.approx((reach & SEEN).sum() / reach.sum())
        assert row.median_delay_s == pytest.approx(PERIOD * np.median(LATE[reach & SEEN]))
        assert row.merged == 0


def test_the_area_is_the_chance_that_a_touched_sample_shows_more_force(told: tuple) -> None:
    _, rows = told
    touched = SENSED >= 3
    u = mannwhitneyu(SIZE[touched], SIZE[~touched]).statistic
    area = u / (touched.sum() * (~touched).sum())
    assert [row.roc_area for row in rows.values()] == pytest.approx([area] * 4)


def test_an_alarm_is_described_at_its_largest_force(told: tuple) -> None:
    every, _ = told
    edges = np.flatnonzero(np.diff(np.concatenate([[0], in_alarm(), [0]])))
    for one, first, end in zip(every, edges[::2], edges[1::2], strict=True):
        size = SIZE[first:end]
        peak = first + int(size.argmax())
        times = PERIOD * np.array([first, end - 1, peak])
        np.testing.assert_allclose([one.start, one.end, one.peak], times)
        np.testing.assert_allclose(one.force, size.max() * DIRECTION)
        np.testing.assert_allclose(one.force_std, DEVIATION[peak])
        np.testing.assert_allclose(one.q, peak)
        assert one.flange_speed == pytest.approx(np.arange(first, end).mean() / 100)
        assert one.at_sensor == bool((SENSED[first:end] > 0).any())
