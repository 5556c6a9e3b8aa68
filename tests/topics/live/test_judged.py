"""Contacts and false alarms of the live estimator: their rows, verdicts and section."""

from dataclasses import fields, replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.made_records import stretch
from tests.made_study import study
from tests.made_tables import record
from tests.topics.pages import section, shown
from ur5lib.force.estimators import LEADING
from ur5lib.force.touched import sensed_contact
from ur5lib.judging.contacts import upper_limit
from ur5lib.records.contacts import Contacts
from ur5lib.records.force_errors import Compared
from ur5lib.records.forces import SensorWrenches
from ur5lib.records.prediction import Prediction
from ur5lib.records.quality import Quality
from ur5lib.timeseries.arrays import Array, Mask
from ur5lib.timeseries.segments import inside_spans
from ur5lib.topics.live.count_live_contacts import count_live_contacts
from ur5lib.topics.live.judge_live import JudgedLive, judge_live
from ur5lib.topics.live.rows import LiveDetection, LiveForces, LivePush

STEP = 0.01  # s
TIME = STEP * np.arange(6000)
COLUMNS = [one.name for one in fields(LiveDetection)]
NONE = Contacts()
PUSH = np.where((TIME >= 10) & (TIME < 11), 20.0, 0.0)  # N


def sensor(force: Array | None = PUSH) -> SensorWrenches:
    wrench = {} if force is None else {"compensated": np.outer(force, np.eye(6)[0])}
    return SensorWrenches(**stretch(TIME), wrench=wrench)


def live(*spans: tuple[float, float], known: Mask | None = None) -> LiveForces:
    """The estimator states contacts between times [s]."""
    samples = [(round(first / STEP), round(last / STEP)) for first, last in spans]
    known = np.ones(len(TIME), bool) if known is None else known
    return LiveForces(**stretch(TIME), contact=inside_spans(samples, len(TIME)), known=known)


def detected(*alarms: tuple[float, float], **more: Any) -> Contacts:
    """The leading estimate raises alarms between times [s]."""
    each = [{"estimate": LEADING, "start_s": a, "end_s": b} | more for a, b in alarms]
    found: Contacts = record(Contacts, {"contacts": each})
    return found


def test_contacts_are_counted_by_their_force() -> None:
    rows = count_live_contacts(live((10.3, 11.2), (30, 31)), sensor(), NONE)
    assert [(row.force_class_n, row.contacts, row.found) for row in rows] == [
        (force, 1, 1) for force in (3.0, 5.0, 10.0, 15.0)
    ]
    assert rows[0].median_delay_s == pytest.approx(0.3)
    assert rows[0].alarms_per_min == pytest.approx(2)
    assert rows[0].false_alarms_per_min == pytest.approx(1)


def test_without_a_sensor_alarms_are_counted_and_without_a_fit_nothing() -> None:
    known = TIME >= 15
    (row,) = count_live_contacts(live((30, 31), known=known), sensor(None), NONE)
    assert (row.force_class_n, row.contacts, row.false_alarms_per_min) == (None, None, None)
    assert (row.alarms_per_min, row.unknown) == pytest.approx((1, 0.25))
    assert count_live_contacts(LiveForces(**stretch(TIME)), sensor(), NONE) == []


def test_what_could_be_hidden_is_counted_where_no_contact_is_stated() -> None:
    """The axis in which most could be, in the median; none of an arm that is always touched."""
    limits = np.outer(1 + (TIME >= 15), [3.0, 8.0, 5.0])
    stated = live((0, 5), known=TIME < 12)
    own = replace(stated, hidden=limits, hidden_at_all=2 * limits)
    rows = count_live_contacts(own, sensor(), NONE)
    assert {(row.hidden_n, row.hidden_at_all_n) for row in rows} == {(8.0, 16.0)}
    touched = replace(own, contact=TIME < 12)
    assert {row.hidden_n for row in count_live_contacts(touched, sensor(), NONE)} == {None}


@pytest.mark.parametrize("more", [{"off_flange": True}, {"kind": "load"}])
def test_what_a_sensor_does_not_feel_makes_no_false_alarm(more: dict[str, Any]) -> None:
    """A push at the elbow, or a load, that the estimate of the whole recording tells apart."""
    stated = live((20.5, 21.7), (30, 31))
    elbow = detected((20.0, 21.49), **more)
    assert count_live_contacts(stated, sensor(), NONE)[0].false_alarms_per_min == pytest.approx(2)
    assert count_live_contacts(stated, sensor(), elbow)[0].false_alarms_per_min == pytest.approx(1)


def judged(rows: dict[str, list[LiveDetection]], **dates: str) -> JudgedLive:
    """Of recordings of a minute, named by their roles."""
    roles = {name: name.partition("_")[0] for name in rows}
    tables = {name: pd.DataFrame(map(vars, own), columns=COLUMNS) for name, own in rows.items()}
    return judge_live(
        tables,
        dict.fromkeys(rows, Quality(duration_s=60.0)),
        dict.fromkeys(rows, Prediction(False)),
        {name: Compared(sensed=sensed_contact(PUSH, TIME) if "touched" in name else None)
         for name in rows},
        roles,
        dict.fromkeys(rows, "") | dates,
    )  # fmt: skip


def free(alarms: float = 0.0, unknown: float = 0.0) -> list[LiveDetection]:
    return [LiveDetection(alarms_per_min=alarms, unknown=unknown)]


def pushed() -> list[LiveDetection]:
    counts: dict[str, Any] = {"contacts": 4, "found": 3, "merged": 0, "false_alarms_per_min": 1.0}
    forces = (3.0, 5.0)
    return [LiveDetection(force_class_n=f, **counts, alarms_per_min=4, unknown=0) for f in forces]


def smallest() -> list[LivePush]:
    """At rest none along x, and along y nothing that trials determine, as in fast motion."""
    about: dict[str, Any] = {"largest_tried": 100.0, "seconds": 1.0, "trials": 30, "basis": "fit"}
    return [
        LivePush(motion="at rest", axis="x", value=100.0, bound=">", blind=7, **about),
        LivePush(motion="at rest", axis="y", **about),
        LivePush(motion="fast", axis="y", value=20.0, std_error=2.0, low=16.1, high=23.9, **about),
    ]


def test_false_alarms_are_those_where_nothing_touches_the_arm() -> None:
    """Minutes are those in which the estimator knows."""
    found = judged({"validate": free(2, 0.25), "validate_touched": free(9), "contact": pushed()})
    (row,) = found.false_alarms
    assert (row.role, row.days, row.recordings, row.alarms) == ("validate", "all", 1, 2)
    assert (row.minutes, row.unknown) == pytest.approx((0.75, 0.25))
    assert row.per_min_high == pytest.approx(upper_limit(2) / 0.75)
    numbers = {row.quantity: row for row in found.verdicts}
    assert (numbers["contacts found"].count, numbers["contacts found"].of) == (3, 4)
    assert numbers["false alarms"].count == 2
    assert numbers["false alarms on recordings with contacts"].count == 1
    assert numbers["false alarms, all recordings"].count == 3
    told = numbers["time of recordings that tell false alarms"]
    assert told.value == pytest.approx(0.75 + 1)


def test_days_without_a_fit_are_counted_by_themselves() -> None:
    rows = {"fit": free(), "validate": free(1)}
    for day, expected in (
        ("2026-03-01", {"all"}),
        ("2026-03-02", {"all", "without fit", "farthest"}),
    ):
        found = judged(rows, fit="2026-03-01", validate=day).false_alarms
        assert {row.days for row in found if row.role == "validate"} == expected


def test_of_an_arm_without_an_estimate_nothing_is_judged() -> None:
    assert judged({"fit": [], "contact": []}) == JudgedLive([], [])


def test_its_section_has_contacts_and_false_alarms() -> None:
    found = judged({"validate": free(), "contact": pushed()})
    made = study()
    rows = [vars(row) | {"recording": "pushed"} for row in pushed()]
    tables = {
        "live_detection": pd.DataFrame(rows),
        "live_false_alarms": pd.DataFrame(map(vars, found.false_alarms)),
        "live_pushes": pd.DataFrame([vars(one) | {"robot": "ur5"} for one in smallest()]),
        "verdicts": pd.DataFrame(map(vars, found.verdicts)),
    }
    own = section("live", replace(made, tables={**made.tables, **tables}))
    assert "3 of 4 contacts found. 0 false alarms, on unseen recordings. " in own.text
    assert own.tables["live-contacts"][0]["≥ 5 N"] == "3 of 4"
    assert own.tables["live-alarms"][0]["false alarms"] == "0"
    rest, fast = own.tables["live-pushes"]
    assert [rest[name] for name in ("x [N]", "y [N]", "blind")] == ["> 100", "–", "7 of 60"]
    assert fast["y [N]"] == "20 (16 to 24)"
    assert shown("live", study()) is None
