"""Alarms and how they are judged."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ur5lib.force.alarms import pushes_above
from ur5lib.force.matching import compare, match, receiver_curve
from ur5lib.force.sensed_contact import TOUCH_FORCE, is_free
from ur5lib.force.thresholds import (
    THRESHOLD_STEP,
    alarm_threshold,
    alarms,
    force_alarms,
    force_threshold,
)
from ur5lib.force.trial_contacts import smallest_force, trial_pushes
from ur5lib.timeseries.segments import overlap, spans

RANDOM = np.random.default_rng(0)


def test_spans_reach_on_and_end_at_off() -> None:
    signal = np.array([0, 2, 5, 2, 0, 2, 0, 6.0])
    assert spans(signal, on=4, off=1) == [(1, 4), (7, 8)]
    assert spans(signal, on=9, off=1) == []


def test_each_recording_counts_for_as_long_as_it_lasts() -> None:
    """Two minutes at 100 Hz and one at 500 Hz allow three alarms, not more and not fewer."""
    often, seldom = np.full(30000, -5.0), np.full(12000, -5.0)
    often[[5000, 15000, 25000]] = [2.0, 4.0, 6.0]
    seldom[[2000, 6000, 10000]] = [3.0, 5.0, 7.0]
    threshold = alarm_threshold([often, seldom], [0.002, 0.01], per_minute=1)
    assert 4.0 < threshold <= 5.0
    assert alarm_threshold([seldom, often], [0.01, 0.002], per_minute=1.3) == threshold


def test_contacts_found_missed_and_made_up() -> None:
    """Of the alarms, one is in no contact, and one is the second in its contact."""
    alarm, contact = [(12, 17), (18, 20), (50, 60), (79, 90)], [(10, 20), (30, 40), (80, 82)]
    detection = compare(alarm, contact, period=0.1)
    assert (detection.contacts, detection.found) == (3, 2)
    assert (detection.alarms, detection.extra, detection.false) == (4, 1, 1)
    assert detection.recall() == pytest.approx(2 / 3)
    assert detection.precision() == pytest.approx(2 / 4)
    np.testing.assert_allclose(detection.delays, [0.2, -0.1])


def test_a_contact_within_the_alarm_of_another_one_is_not_missed() -> None:
    """One alarm over two pushes 0.15 s apart finds one of them; only the third has none."""
    detection = compare([(100, 337)], [(100, 168), (183, 338), (600, 700)], 0.008)
    assert (detection.contacts, detection.found, detection.merged) == (3, 1, 1)


def test_without_contacts_there_is_no_recall() -> None:
    assert np.isnan(compare([], [], 0.1).recall())
    assert np.isnan(compare([], [], 0.1).precision())
    assert compare([(1, 2)], [], 0.1).false == 1


BOUNDS = st.lists(st.integers(0, 60), max_size=20, unique=True).map(sorted)
SPANS = BOUNDS.map(lambda edges: [*zip(edges[::2], edges[1::2], strict=False)])


@given(SPANS, SPANS)
def test_every_alarm_is_found_extra_or_false(alarm: list, contact: list) -> None:
    detection = compare(alarm, contact, 0.1)
    assert detection.found + detection.extra + detection.false == len(alarm)
    pairs = match(alarm, contact)
    assert len({i for i, _ in pairs}) == len({j for _, j in pairs}) == len(pairs)
    assert all(overlap(alarm[i], contact[j]) for i, j in pairs)


@given(SPANS, SPANS)
def test_no_other_matching_finds_more(alarm: list, contact: list) -> None:
    """Stretches in order: who ends first is matched first, which is the most there can be."""
    left, found = [*contact], 0
    for a in alarm:
        meeting = [c for c in left if overlap(a, c)]
        if meeting:
            left.remove(min(meeting, key=lambda c: c[1]))
            found += 1
    assert len(match(alarm, contact)) == found


def test_the_longest_overlap_is_matched() -> None:
    assert match([(0, 50)], [(0, 5), (10, 40), (45, 60)]) == [(0, 1)]


def test_the_receiver_curve_of_a_perfect_and_a_blind_detector() -> None:
    contact = RANDOM.random(4000) < 0.3
    false, found = receiver_curve(contact.astype(float), contact)
    assert np.trapezoid(found, false) == pytest.approx(1)
    false, found = receiver_curve(RANDOM.random(4000), contact)
    assert np.trapezoid(found, false) == pytest.approx(0.5, abs=0.05)


def test_the_smallest_force_of_extreme_detectors() -> None:
    force = RANDOM.uniform(2, 40, 100)
    assert smallest_force(force, np.zeros(100, bool))[0] == np.inf
    assert 8 < smallest_force(force, force > 10)[0] < 16


def test_an_alarm_ends_two_below_its_threshold() -> None:
    odds = np.array([1, -1.9, 1, -2, 1, -2.1, 0, -9])
    assert alarms(odds, 0.0) == [(0, 3), (4, 5), (6, 7)]
    assert alarms(odds + 3, 3.0) == alarms(odds, 0.0)
    assert alarms(odds, 1.1) == []


def test_as_many_alarms_as_are_allowed_need_no_threshold() -> None:
    """Two a minute in half a minute: one alarm is allowed, two are one too many."""
    odds = np.full(3000, -5.0)
    odds[1000] = 4.0
    assert alarm_threshold([odds], [0.01], per_minute=2) == 0.0
    odds[2000] = 3.0
    threshold = alarm_threshold([odds], [0.01], per_minute=2)
    assert threshold == np.nextafter(3.0, np.inf)
    assert alarms(odds, threshold) == [(1000, 1001)]


def test_a_push_lasts_a_second_after_a_pause_of_two() -> None:
    profile, places = trial_pushes(900, 0.01)
    assert places == [(200, 300), (500, 600)]
    np.testing.assert_allclose(profile[200:300], np.sin(np.pi * np.arange(100) / 100) ** 2)
    assert profile.sum() == pytest.approx(100)


def test_a_rate_of_what_there_is_none_of_is_zero() -> None:
    """All four samples in contact, or none."""
    rising = np.linspace(0, 1, 5)
    for contact in (np.zeros(4, bool), np.ones(4, bool)):
        false, found = receiver_curve(np.arange(4.0), contact)
        np.testing.assert_array_equal(found, rising * contact.all())
        np.testing.assert_array_equal(false, rising * (not contact.any()))


def test_the_error_of_the_smallest_force_is_how_it_scatters() -> None:
    """Over a hundred sets of pushes of the detector above; none is far off what it promises."""
    random = np.random.default_rng(1)
    told = []
    for _ in range(100):
        force = random.uniform(2, 40, 200)
        told.append(smallest_force(force, random.random(200) < 1 / (1 + (force / 8) ** -6)))
    forces, stds = np.array(told).T
    assert np.std(forces) == pytest.approx(np.mean(stds), rel=0.25)
    assert np.mean(forces) == pytest.approx(8 * 19 ** (1 / 6), rel=0.05)


def test_few_pushes_leave_the_usual_steepness() -> None:
    """From 25 to 75 % found within a factor of 1.6: 9 = 1.6^k, so 95 % is 19^(1/k) above half."""
    steepness = np.log(9) / np.log(1.6)
    force = np.array([9.9, 10.1])
    smallest, _ = smallest_force(force, np.array([False, True]))
    assert smallest == pytest.approx(10 * 19 ** (1 / steepness), rel=0.05)


# Alarms by the size of a force


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
    assert sum(len(force_alarms(run, threshold - THRESHOLD_STEP)) for run in runs) == 3
    assert 20 < threshold <= 20 + THRESHOLD_STEP


def test_an_alarm_without_end_is_no_reason_for_a_low_threshold() -> None:
    """Below 10 N the whole minute is one alarm, above it there are three."""
    run = bumps([30.0, 30.0, 30.0], floor=10.0)
    assert len(force_alarms(run, 5.0)) == 1
    assert force_threshold([run], [PERIOD], per_minute=1) > 30


def test_without_any_force_the_threshold_is_that_of_the_sensor() -> None:
    assert force_threshold([bumps([])], [PERIOD], per_minute=1) == pytest.approx(
        TOUCH_FORCE, abs=THRESHOLD_STEP
    )


def test_a_push_is_found_whichever_way_it_points_and_an_unknown_one_is_not() -> None:
    sensed = bumps([12.0, -15.0, 20.0, 4.0])
    force = -sensed
    assert pushes_above(force, sensed, 10.0, PERIOD) == (3, 3)
    force[500:600] = np.nan
    assert pushes_above(force, sensed, 10.0, PERIOD) == (3, 2)
    assert pushes_above(0.5 * sensed, sensed, 10.0, PERIOD) == (3, 1)


# What a sensor reads


def test_a_sample_is_free_below_a_newton_and_half_a_second_from_any_touch() -> None:
    force = np.full(400, 0.9)
    force[100], force[150:152], force[300] = 3.1, 1.1, np.nan
    free = is_free(force, 0.01)
    expected = np.ones(400, bool)
    expected[50:152] = expected[300] = False
    np.testing.assert_array_equal(free, expected)
    assert is_free(np.full(9, 2.9), 0.01).sum() == 0
