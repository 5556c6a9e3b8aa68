"""What became of contacts at a sensor, and what alarms are."""

from dataclasses import replace
from itertools import product
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.made_records import stretch
from ur5lib.force.alarms import (
    Alarm,
    Alarms,
    detections,
    false_per_min,
    fixed_thresholds,
    not_felt,
    raised,
)
from ur5lib.force.contact_figures import contact_errors
from ur5lib.force.estimators import Stated
from ur5lib.force.fates import (
    Outcome,
    cause_of,
    contact_rows,
    fates,
    kind_of,
    outcomes,
    with_fates,
)
from ur5lib.force.matching import compare
from ur5lib.force.sensed_contact import CONTACT_FORCE, TOUCH_FORCE
from ur5lib.force.touched import touched
from ur5lib.records.contacts import WHOLE, ContactError, Detection, Fate
from ur5lib.records.force_errors import Sensed
from ur5lib.records.forces import SensorWrenches
from ur5lib.timeseries.arrays import Array
from ur5lib.timeseries.metrics import NORMAL95
from ur5lib.timeseries.segments import Span, inside_spans

BOUNDS = st.lists(st.integers(0, 120), max_size=24, unique=True).map(sorted)
SPANS = BOUNDS.map(lambda edges: [*zip(edges[::2], edges[1::2], strict=False)])
PERIODS = st.sampled_from([0.001, 0.002, 0.008, 0.01])  # s
COUNT = 130  # samples


def alarm(start: float = 1.0, end: float = 2.0, **more: object) -> Alarm:
    force = np.array([3.0, 0.0, 4.0]), np.array([1.0, 5.0, 2.0])
    return Alarm(start, end, start, *force, np.zeros(6), **more)


def contact(start: float, end: float, **more: float | None) -> ContactError:
    about: dict[str, Any] = {"estimate": "Fmap", "contact": 1, "component": WHOLE} | more
    sizes = {"peak": 20.0, "peak_error": -2.0, "impulse": 10.0, "impulse_error": -1.0}
    return ContactError(start_s=start, end_s=end, **about, **sizes)


def sensor_of(force: Array, period: float) -> SensorWrenches:
    """A sensor that reads forces (N,) [N] along x."""
    wrench = np.outer(force, np.eye(6)[0])
    return SensorWrenches(**stretch(period * np.arange(len(force))), wrench={"compensated": wrench})


def found(stretches: list[Span], sensor: SensorWrenches) -> tuple[list[Alarm], list[Detection]]:
    """The alarms of an estimate at these stretches, of which nothing is a load, and how they match
    the contacts at the sensor.
    """
    still = np.zeros((len(sensor.time), 6))
    own = Alarms(0 * sensor.time, stretches, still, still, still[:, :3])
    alarms = raised(own, sensor, still, 0 * sensor.time, lambda _, one: one)
    return alarms, [*detections("Fmap", own, alarms, sensor, 0.0)]


@given(SPANS, SPANS)
def test_every_contact_is_found_merged_or_missed(
    stretches: list[Span], touches: list[Span]
) -> None:
    told = fates(stretches, touches)
    counted = compare(stretches, touches, 0.1)
    numbers = counted.found, counted.merged, counted.contacts - counted.found - counted.merged
    assert [told.count(fate) for fate in Fate] == [*numbers]


@given(SPANS, SPANS, PERIODS, st.data())
def test_tables_agree_on_the_fates_of_contacts(
    stretches: list[Span], touches: list[Span], period: float, data: st.DataObject
) -> None:
    """contact_errors.csv and detection.csv, also where an alarm and a contact share one sample."""
    height = np.zeros(COUNT)
    for first, last in touches:
        height[first:last] = data.draw(st.sampled_from([2.5, 4.0, 6.0, 30.0]))
    sensor = sensor_of(height, period)
    reading = sensor.wrench["compensated"][:, :3]
    errors = contact_errors("Fmap", Stated(0 * reading), reading, height, sensor.time)
    alarms, rates = found(stretches, sensor)
    rows = [one for one in with_fates(errors, alarms) if one.fate is not None]
    (row,) = (one for one in rates if one.force_class_n == CONTACT_FORCE)
    told = [one.fate for one in rows]
    assert len(told) == row.contacts
    assert (told.count("found"), told.count("merged")) == (row.found, row.merged)
    assert {one.component for one in rows} <= {WHOLE}


@given(SPANS, SPANS, PERIODS)
def test_tables_agree_on_false_alarms(
    stretches: list[Span], touches: list[Span], period: float
) -> None:
    """Alarms that are shorter than half a second."""
    sensor = sensor_of(20.0 * inside_spans(touches, COUNT), period)
    alarms, (rates, *_) = found([(a, min(b, a + 40)) for a, b in stretches], sensor)
    kinds = [row.kind for row in contact_rows("Fmap", alarms, is_free=False)]
    assert {*kinds} <= {"contact", "false"}
    rate = rates.false_alarms_per_min
    assert rate is not None
    assert kinds.count("false") == pytest.approx(rate * COUNT * period / 60)


def test_a_contact_within_the_alarm_of_another_one_is_merged() -> None:
    """One is found, one merged, one missed; the band is that of the alarm's force."""
    touches = [contact(1.0, 2.0), contact(3.0, 5.0), contact(8.0, 9.0)]
    told = outcomes(touches, [alarm(1.0, 5.0)])
    assert [one.fate for one in told] == ["merged", "found", "missed"]
    assert told[0] == Outcome("merged")
    # half of the band of |F| = 5 N, of F = (3, 0, 4) N: d|F| = F · dF / |F|
    assert told[1].band == pytest.approx(NORMAL95 * np.hypot(3.0 * 1.0, 4.0 * 2.0) / 5.0)


def test_without_a_band_none_is_stated() -> None:
    """Of an estimate that states no deviation, and of one that is zero."""
    for force, std in ((1.0, np.nan), (0.0, 1.0)):
        own = replace(alarm(), force=np.full(3, force), force_std=np.full(3, std))
        assert outcomes([contact(1.0, 2.0)], [own]) == [Outcome("found")]


@pytest.mark.parametrize(
    ("speed", "late", "gain", "cause"),
    [
        (0.0, 0.5, 0.4, "stiction"),
        (0.1, 0.5, 0.4, "friction"),
        (0.0, 0.5, 1.0, "constants"),
        (0.1, 1.5, 0.4, "late_alarm"),
        (0.1, None, None, "friction"),
    ],
)
def test_the_largest_part_of_an_error_is_its_cause(
    speed: float, late: float | None, gain: float | None, cause: str
) -> None:
    touch = contact(1.0, 2.0, mae=2.0, mae_shut=late, mae_gain=gain)
    assert cause_of(touch, alarm(flange_speed=speed)) == cause


@pytest.mark.parametrize("mae", [None, np.nan, 0.0])
def test_no_error_has_no_cause(mae: float | None) -> None:
    assert cause_of(contact(1.0, 2.0, mae=mae), alarm()) is None


KINDS = {  # of an alarm that is no load: by the sensor, off the flange, free by role
    (True, False, False): "contact",
    (True, False, True): "contact",  # a sensor beats a role
    (True, True, False): "contact",
    (True, True, True): "contact",
    (False, False, False): "false",
    (False, False, True): "false",
    (False, True, False): "off_flange",  # a sensor at the flange does not feel the elbow
    (False, True, True): "off_flange",
    (None, False, False): "contact",
    (None, False, True): "false",
    (None, True, False): "off_flange",
    (None, True, True): "false",
}


@pytest.mark.parametrize("case", KINDS)
def test_the_kind_of_an_alarm(case: tuple[bool | None, bool, bool]) -> None:
    at_sensor, off_flange, free = case
    own = alarm(at_sensor=at_sensor, off_flange=off_flange)
    assert kind_of(own, free) == KINDS[case]
    assert kind_of(alarm(at_sensor=at_sensor, kind="load"), free) == "load"


# False alarms beside a sensor, of 60 s at 100 Hz: touched from 10 to 11 s

MINUTE = np.zeros(6000)
MINUTE[1000:1100] = 20.0


def seconds(*ends: float) -> list[Span]:
    return [(round(100 * a), round(100 * b)) for a, b in zip(ends[::2], ends[1::2], strict=True)]


@pytest.mark.parametrize(
    ("times", "false"),
    [
        ([9.5, 11.5], 0),
        ([10.2, 11.9], 0),  # an alarm may end late
        ([10.2, 12.5], 1),
        ([10.2, 29.2], 1),  # 19 s of which one is a contact
        ([2.0, 21.0], 1),
        ([30.0, 30.1], 1),
        ([10.2, 29.2, 30.0, 31.0], 2),
        ([], 0),
    ],
)
def test_an_alarm_that_outlasts_its_contact_is_false_too(times: list[float], false: int) -> None:
    """As a rate a minute."""
    sensor, spans = sensor_of(MINUTE, 0.01), seconds(*times)
    for told in found(spans, sensor)[1]:
        assert told.false_alarms_per_min == pytest.approx(false)
        assert told.alarms_per_min == pytest.approx(len(spans))


@pytest.mark.parametrize("more", [{"off_flange": True}, {"kind": "load"}])
def test_what_a_sensor_does_not_feel_makes_no_false_alarm(more: dict[str, object]) -> None:
    """Five pushes at the elbow; a sixth alarm is false."""
    sensor = sensor_of(MINUTE, 0.01)
    pushes = seconds(*np.array([[t, t + 1.5] for t in range(20, 45, 5)]).ravel())
    spans = [*pushes, *seconds(50, 51)]
    alarms = [alarm(**more) for _ in pushes] + [alarm()]
    unfelt = not_felt(spans, alarms)
    assert unfelt == pushes
    assert false_per_min(spans, sensor) == pytest.approx(6)
    assert false_per_min(spans, sensor, unfelt) == pytest.approx(1)


def test_without_a_sensor_no_rate_is_known() -> None:
    """Or with one that has no reading."""
    for nothing in (
        SensorWrenches(**stretch(0.01 * np.arange(100))),
        sensor_of(np.full(100, np.nan), 0.01),
    ):
        assert false_per_min([(1, 5)], nothing) is None
        (own,), (rates,) = found([(1, 5)], nothing)
        assert own.at_sensor is rates.false_alarms_per_min is rates.force_class_n is None


def test_the_fixed_threshold_has_time_above_and_pushes_found() -> None:
    """Of four pushes along x, three are in the estimate; a sensor is needed to count them."""
    pushes = np.tile(np.repeat([0.0, 12.0, 0.0], 4), 4)  # N
    shown = np.outer(np.where(np.arange(48) < 36, pushes, 0.0), np.eye(6)[0])
    own = Alarms(shown[:, 0], [], shown, 0 * shown, shown[:, :3])
    nothing = SensorWrenches(**stretch(0.01 * np.arange(48)))
    for sensor, counted in ((sensor_of(pushes, 0.01), (4, 3)), (nothing, (None, None))):
        rows = [*fixed_thresholds("F*", own, sensor)]
        assert [row.component for row in rows] == ["Fx", "Fy", "Fz"]
        assert [row.time_above for row in rows] == [0.25, 0.0, 0.0]
        assert (rows[0].pushes, rows[0].found) == counted


# A sensor that reads contacts, although the role means that nothing touches the arm


def sensed(contacts: int) -> Sensed:
    return Sensed(largest_force_n=33.4, at_s=1.0, share_in_contact=0.1, contacts=contacts)


@pytest.mark.parametrize(("role", "contacts"), [*product(["fit", "validate"], [1, 2])])
def test_contacts_against_the_role_are_an_error(role: str, contacts: int) -> None:
    error = touched(sensed(contacts), role)
    assert error is not None
    assert (error.device, error.code, error.severity) == ("force", "touched", "error")
    assert error.count == contacts


@pytest.mark.parametrize(
    ("role", "reading"),
    [("contact", sensed(2)), ("fit", sensed(0)), ("validate", None), ("", sensed(2))],
)
def test_where_a_sensor_agrees_nothing_is_found(role: str, reading: Sensed | None) -> None:
    assert touched(reading, role) is None


def test_a_touch_below_a_contact_spares_an_alarm_alone() -> None:
    """At 4 N, between what is touched and what is a contact."""
    assert TOUCH_FORCE < 4.0 < CONTACT_FORCE
    sensor = sensor_of(np.where(MINUTE > 0, 4.0, 0.0), 0.01)
    alarms, rates = found(seconds(10.2, 10.8), sensor)
    assert [one.at_sensor for one in alarms] == [True]
    assert {one.false_alarms_per_min for one in rates} == {0}
    assert {one.force_class_n: one.contacts for one in rates}[CONTACT_FORCE] == 0
