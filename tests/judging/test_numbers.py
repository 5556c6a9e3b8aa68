"""Each number of a verdict, once more from the rows of a drawn study, one row at a time."""

import math
from collections import defaultdict
from collections.abc import Callable, Iterable
from datetime import date, timedelta
from statistics import mean
from typing import Any

import numpy as np
import pandas as pd
import pytest
from scipy.stats import poisson

from tests.made_study import COLUMNS, finding, predicted, touched
from ur5lib.force.estimators import UNGATED
from ur5lib.judging.advice import ASKING, advice
from ur5lib.judging.constants import judge_constants
from ur5lib.judging.contacts import (
    judge_contacts,
    noticed,
    of_days,
    rates,
    with_sharp_peaks,
)
from ur5lib.judging.currents import judge_currents
from ur5lib.judging.force import judge_force
from ur5lib.judging.links import judge_links
from ur5lib.judging.recordings import SEVERITIES, felt_while_fitted, judge_recordings, uses
from ur5lib.judging.study import StudyTables, read_tables
from ur5lib.records.codes import Found
from ur5lib.records.quality import STOP
from ur5lib.records.verdicts import FalseAlarms, Verdict
from ur5lib.robots.description import load_robot, robot_path
from ur5lib.steps.judge_study import Judged, judged
from ur5lib.study.model import Settings

Row = dict[str, Any]
ROLES = {"f1": "fit", "f2": "fit", "f3": "fit", "v1": "validate", "v2": "validate"}
ROLES |= {"v3": "validate", "c1": "contact", "c2": "contact", "c3": "contact"}
DAYS = {"f1": 0, "f2": 10, "v1": 0, "v2": 13, "v3": 17, "c1": 4, "c2": 16}  # f3, c3: undated
MOVING = dict.fromkeys(ROLES, "1 2 3 4 5 6") | {"c1": None, "v2": "2 3 4 5"}
SETTINGS, V1 = Settings().model_dump(), {"name": "v1", "robot": "ur5", "role": "validate"}
AXES, FATES = ["Fx", "Fy", "Fz"], ["found", "merged", "missed"]


def drawn(random: np.random.Generator) -> dict[str, list[Row]]:
    """Tables of a study, with numbers that mean nothing."""

    def number(low: float, high: float) -> float:
        return float(random.uniform(low, high))

    def some(*choice: str) -> str:
        return str(random.choice(choice))

    tables: dict[str, list[Row]] = defaultdict(list)
    for name in ROLES:
        tables["recordings"].append(
            {"recording": name, "duration_s": number(30, 200), "frames": int(number(500, 9000))}
        )
        tables["recordings"][-1]["moving_joints"] = MOVING[name]
        for joint in range(1, 7):
            at: Row = {"recording": name, "joint": joint}
            for model in ("fitted", "least_squares"):
                row = {"model": model, "zero_rmse_lowpassed": number(1.0, 3.0), "fitted": "no"}
                row |= {"rmse_lowpassed": number(0.1, 0.4), "coverage95": number(0.5, 1.0)}
                tables["current_rmse"].append(at | row | {"band_factor95": number(0.5, 1.6)})
            zeros = {"zero_mae": number(2, 3), "zero_mae_2hz": number(1, 2)}
            for model, least in (("A", 0.05), ("B", 0.15)):
                row = {"motion": "measured", "model": model, "mae": number(0.2, 0.4), **zeros}
                tables["torque_mae"].append(at | row | {"mae_2hz": number(least, least + 0.12)})
        alarm: Row = {"recording": name, "estimate": "Fmap"}
        for start in range(int(number(2, 9))):
            row = {"kind": some("contact", "off_flange", "false"), "peak_s": 10.0 * start}
            row |= {f"{axis}_std": number(1, 9) for axis in AXES} | {"posture_deg": f"{start} 0"}
            tables["contacts"].append(alarm | row)
        alarms = sum(row["recording"] == name for row in tables["contacts"])
        per_min = 60 * alarms / tables["recordings"][-1]["duration_s"]
        tables["detection"].append(alarm | {"alarms_per_min": per_min})
        if ROLES[name] == "contact":
            tables["detection"][-1] |= {"force_class_n": 5.0}
            tables["detection"][-1]["false_alarms_per_min"] = 0.4 * per_min
            sensor: Row = {f"drift_{axis}": number(-1, 1) for axis in "xyz"}
            sensor |= {f"drift_std_{axis}": number(0.2, 0.9) for axis in "xyz"}
            tables["sensed"].append({"recording": name, "contacts": 12} | sensor)
            for start in range(12):
                row = {"component": "norm", "peak": number(3, 40), "fate": some(*FATES)}
                row |= {"start_s": 7.0 * start + 0.25, "peak_error": number(-6, 2)}
                tables["contact_errors"].append(alarm | row)
            for axis in AXES:
                at = {"recording": name, "kind": "compensated", "during": "contact"}
                at |= {"component": axis, "mean_force": number(5.5, 9.0), "use": "yes"}
                for estimate, least in (("Fmap", 1.0), (UNGATED, 2.0)):
                    mae = number(least, least + 1.0)
                    row = {"estimate": estimate, "mae": mae, "mae_low": mae - 0.3}
                    row |= {"mae_high": mae + 0.4, "coverage95": number(0.7, 1.0)}
                    row |= {"band_factor95": number(0.4, 1.8), "zero_in_band95": number(0.1, 0.8)}
                    row |= {"interval_score95": number(10, 30), "zero_interval_score95": 90.0}
                    row |= {"even_interval_score95": number(20, 60)}
                    row |= {"slope": number(0.5, 1.0), "mae_missed": 0.2 * mae}
                    tables["force_mae"].append(at | row | {"mae_shut": 0.1, "mae_gain": 0.3 * mae})
    for joint in range(1, 7):
        row = {"robot": "ur5", "joint": joint, "parameter": "torque_constant"}
        value = number(8, 13)
        row |= {"value": value, "low": value - number(0.5, 1), "high": value + number(0.5, 1)}
        row |= {"known": number(9, 12), "known_std": number(0.5, 1), "determined": "yes"}
        tables["friction"].append(row | {"contradicted": None, "use": "yes"})
        for speed in ("0", "0.1", "0.5", "1"):
            value = number(4, 9)
            total = {"parameter": f"total_{speed}", "value": value, "use": some("yes", "yes", "no")}
            total |= {"low": value - number(0.5, 5), "high": value + number(0.5, 5)}
            tables["friction"].append({"robot": "ur5", "joint": joint, "load": 1.0} | total)
        for quantity in ("current", "torque"):
            row = {"robot": "ur5", "quantity": quantity, "joint": joint}
            tables["repetition"].append(
                row | {"floor": number(0.1, 0.2), "error": number(0.1, 0.3)}
            )
    for name in ROLES:
        for severity in SEVERITIES[1:]:
            for code in (Found.LOST_FRAMES, Found.JITTER, Found.JITTER):
                row = {"recording": name, "device": some("robot", "force"), "code": code}
                row |= {"severity": severity, "count": int(number(1, 400)), "detail": "why"}
                row |= {"finding": code.words}
                tables["quality"].append(row)
    return {name: [rows[k] for k in random.permutation(len(rows))] for name, rows in tables.items()}


TABLES = drawn(np.random.default_rng(2))


def tables_of(entries: list[Row], **tables: list[Row]) -> StudyTables:
    """A study's tables; those that are not given are empty."""
    about = {"study": "made", "title": "", "recordings": entries, "settings": SETTINGS}
    frames = {name: pd.DataFrame(tables.get(name), columns=COLUMNS[name]) for name in COLUMNS}
    return StudyTables(about, frames, bearing={"ur5": [2, 3, 5]})


@pytest.fixture(scope="module")
def told() -> Judged:
    start = date(2026, 3, 1)
    entries: list[Row] = [{"name": name, "robot": "ur5", "role": ROLES[name]} for name in ROLES]
    for entry in entries:
        if entry["name"] in DAYS:
            entry["date"] = str(start + timedelta(days=DAYS[entry["name"]]))
    return judged(tables_of(entries, **TABLES))


def rows(table: str, **values: Any) -> list[Row]:
    return [one for one in TABLES[table] if all(one[key] == own for key, own in values.items())]


def of_question(told: Judged, question: str) -> list[Verdict]:
    return [one for one in told.verdicts if one.question == question]


def of_quantity(told: Judged, question: str, words: str) -> Verdict:
    (found,) = (one for one in of_question(told, question) if words in one.quantity)
    return found


def grouped(some: Iterable[Row], key: str) -> dict[Any, list[Row]]:
    found = defaultdict(list)
    for row in some:
        found[row[key]].append(row)
    return found


def largest(some: Iterable[Row], size: Callable[[Row], float]) -> tuple[float, Row]:
    most = max(some, key=size)
    return size(most), most


def in_motion(row: Row) -> bool:
    return str(row["joint"]) in str(MOVING[row["recording"]])


def unseen_currents(model: str = "fitted") -> list[Row]:
    return [
        one for one in rows("current_rmse", model=model) if ROLES[one["recording"]] == "validate"
    ]


def test_the_verdicts_on_a_question_are_ranked_from_one(told: Judged) -> None:
    """By rank, a page selects them. What is not here needs other tables."""
    ranks: dict[str, list[int]] = defaultdict(list)
    for one in told.verdicts:
        ranks[one.question].append(one.rank)
    assert len(ranks) == 10
    for question, own in ranks.items():
        lacking = {"force": {3}, "links": {2, 5, 6, 7}}.get(question, set())
        assert own[0] == 1
        assert {*own} | lacking == {*range(1, len(own) + len(lacking) + 1)}


# Currents, links


def test_the_errors_of_currents_are_means_over_recordings_on_which_a_joint_moves(
    told: Judged,
) -> None:
    found = {one.joint: one for one in told.judged_errors if one.question == "currents"}
    constants = {
        one["joint"]: one["value"] for one in rows("friction", parameter="torque_constant")
    }
    repeats = {one["joint"]: one for one in rows("repetition", quantity="current")}
    every = grouped(unseen_currents(), "joint")
    plain = grouped(filter(in_motion, unseen_currents("least_squares")), "joint")
    assert {*found} == {*range(1, 7)}
    for joint, one in found.items():
        own = [*filter(in_motion, every[joint])]
        values = [row["rmse_lowpassed"] for row in own]
        assert one.recordings == len(own) == (3 if joint in (2, 3, 4, 5) else 2)
        assert (one.error, one.low, one.high) == pytest.approx(
            (mean(values), min(values), max(values))
        )
        assert one.zero == pytest.approx(mean(row["zero_rmse_lowpassed"] for row in own))
        assert one.rival_error == pytest.approx(mean(row["rmse_lowpassed"] for row in plain[joint]))
        assert one.coverage95 == min(row["coverage95"] for row in own)
        assert one.least_factor95 == min(row["band_factor95"] for row in own)
        assert one.band_factor95 == max(row["band_factor95"] for row in own)
        most, row = largest(every[joint], lambda one: one["rmse_lowpassed"])
        assert (one.largest, one.recording) == (most, row["recording"])
        assert one.largest_zero == row["zero_rmse_lowpassed"]
        assert one.torque == pytest.approx(mean(values) * constants[joint])
        assert one.largest_torque == pytest.approx(most * constants[joint])
        assert one.in_floors == pytest.approx(repeats[joint]["error"] / repeats[joint]["floor"])


def test_the_verdicts_on_currents_are_the_worst_of_these(told: Judged) -> None:
    own = [one for one in told.judged_errors if one.question == "currents"]
    relative = of_quantity(told, "currents", "relatively the largest")
    worst = max(own, key=lambda one: one.error / one.zero)
    assert (relative.joint, relative.value, relative.zero) == (worst.joint, worst.error, worst.zero)
    assert (relative.low, relative.high, relative.recording) == (worst.low, worst.high, "")
    pooled = of_quantity(told, "currents", "RMSE below 2 Hz, all moving joints")
    squares = [(one.error**2, one.zero**2, (one.rival_error or 0.0) ** 2) for one in own]
    means = [mean(column) ** 0.5 for column in zip(*squares, strict=True)]
    assert [pooled.value, pooled.zero, pooled.rival_value] == pytest.approx(means)
    held = of_quantity(told, "currents", "least share of a joint's readings")
    value, row = largest(filter(in_motion, unseen_currents()), lambda one: -one["coverage95"])
    assert (held.value, held.joint) == (pytest.approx(-100 * value), row["joint"])
    width = of_quantity(told, "currents", "width of the 95 % band")
    value, row = largest(filter(in_motion, unseen_currents()), lambda one: 1 / one["band_factor95"])
    assert (width.value, width.joint, width.high) == (
        pytest.approx(value),
        row["joint"],
        width.value,
    )
    least = min(1 / one["band_factor95"] for one in unseen_currents() if in_motion(one))
    assert width.low == pytest.approx(least)
    assert own[0].largest_torque != max(one.largest_torque or 0.0 for one in own)
    torque = of_quantity(told, "currents", "as a torque")
    most = max(own, key=lambda one: one.largest_torque or 0.0)
    assert (torque.value, torque.joint) == (most.largest_torque, most.joint)
    repeated = of_quantity(told, "currents", "repeated motions")
    most = max(own, key=lambda one: one.in_floors or 0.0)
    (row,) = rows("repetition", quantity="current", joint=most.joint)
    assert (repeated.joint, repeated.floor) == (most.joint, row["floor"])
    assert repeated.value == pytest.approx(row["error"])
    far = of_quantity(told, "currents", "farthest from a day of the fit")
    assert (far.value, far.recording) == (
        7,
        "v3",
    )  # the 17th day; the nearest of the fit is the 10th


def test_a_band_that_never_holds_is_the_worst() -> None:
    made = predicted(0.2)
    made[3] |= {"coverage95": 0.0}
    about = {"recording": "seen", "duration_s": 60.0, "frames": 100, "moving_joints": "1 2 3 4 5 6"}
    entry = V1 | {"name": "seen"}
    found = [*judge_currents(tables_of([entry], recordings=[about], current_rmse=made), "ur5")]
    assert (found[0].low, found[0].interval, found[0].recording) == (None, "", "seen")
    (held,) = (one for one in found if "least share of a joint's readings" in one.quantity)
    assert (held.value, held.joint) == (0.0, 4)


def test_links_are_those_that_are_closest_on_most_joints(told: Judged) -> None:
    own = [row for row in TABLES["torque_mae"] if ROLES[row["recording"]] != "fit"]
    own = [row for row in own if MOVING[row["recording"]]]
    found = {one.joint: one for one in told.judged_errors if one.question == "links"}
    means = {
        model: {
            joint: mean(
                row["mae_2hz"] for row in own if (row["joint"], row["model"]) == (joint, model)
            )
            for joint in range(1, 7)
        }
        for model in "AB"
    }
    near = sum(means["A"][joint] <= means["B"][joint] / 0.95 for joint in range(1, 7))
    counted = of_quantity(told, "links", "comes closest")
    assert "Model A" in counted.quantity
    assert (counted.count, counted.of) == (near, 6)
    for joint, one in found.items():
        part = [row for row in own if (row["joint"], row["model"]) == (joint, "A")]
        assert one.error == pytest.approx(means["A"][joint])
        assert one.rival_error == pytest.approx(means["B"][joint])
        assert one.zero == pytest.approx(mean(row["zero_mae_2hz"] for row in part))
        assert one.largest == max(row["mae_2hz"] for row in part)
    for row in told.model_errors:
        part = rows("torque_mae", joint=row.joint, model=row.model)
        for name in ("mae", "mae_2hz", "zero_mae", "zero_mae_2hz"):
            assert getattr(row, name) == pytest.approx(mean(one[name] for one in part))


@pytest.mark.parametrize(
    ("size", "role", "reason"),
    [(0.1, "fit", "too_small"), (0.101, "fit", "no_unseen"), (0.101, "validate", "")],
)
def test_links_are_judged_by_torques_above_a_tenth(size: float, role: str, reason: str) -> None:
    """Newton metres, on average below 2 Hz."""
    row = {"recording": "f1", "motion": "measured", "model": "A", "joint": 2, "mae": 0.01}
    row |= {"mae_2hz": 0.001, "zero_mae": 1.0, "zero_mae_2hz": size}
    recordings = rows("recordings", recording="f1")
    made = tables_of([V1 | {"name": "f1", "role": role}], recordings=recordings, torque_mae=[row])
    first, *_ = judge_links(made, "ur5")
    assert first.reason == reason


# Constants, friction


@pytest.mark.parametrize(("usable", "state"), [(0, "not determined"), (1, "usable")])
def test_constants_are_known_where_one_may_be_used(usable: int, state: str) -> None:
    constants = rows("friction", parameter="torque_constant")[:4]
    refused = {"use": "no", "reason": "prior_only", "determined": "no"}
    made = [row | (refused if k >= usable else {}) for k, row in enumerate(constants)]
    first, *_ = judge_constants(tables_of([V1], friction=made), "ur5")
    assert (first.state, first.count, first.of) == (state, usable, 4)


def test_constants_and_totals_of_friction_are_as_wide_as_their_farther_end(told: Judged) -> None:
    def half(row: Row) -> float:
        return 100 * max(row["high"] - row["value"], row["value"] - row["low"]) / row["value"]

    constants = rows("friction", parameter="torque_constant")
    widest = of_quantity(told, "constants", "widest")
    value, row = largest(constants, half)
    assert (widest.value, widest.joint) == (pytest.approx(value), row["joint"])
    assert (widest.low, widest.high) == pytest.approx((min(map(half, constants)), value))
    farthest = of_quantity(told, "constants", "farthest")
    _, row = largest(constants, lambda one: abs(one["value"] - one["known"]) / one["known_std"])
    assert (farthest.joint, farthest.value) == (row["joint"], row["value"])
    assert (farthest.low, farthest.high) == (row["low"], row["high"])
    assert farthest.rival_value == row["known"]
    totals = [one for one in TABLES["friction"] if one["parameter"].startswith("total")]
    usable = [one for one in totals if one["use"] == "yes" and half(one) < 100]
    total = of_quantity(told, "friction", "widest")
    value, row = largest(usable, half)
    assert (total.value, total.joint) == (pytest.approx(value), row["joint"])
    assert total.motion == row["parameter"].replace("total_", "at ") + " rad/s"
    counted = of_quantity(told, "friction", "total frictions that may be used")
    assert (counted.count, counted.of) == (len(usable), 24)


def test_a_joint_that_gravity_loads_has_its_constant_off_in_percent(told: Judged) -> None:
    found = of_question(told, "gravity")
    off = {
        row["joint"]: [100 * (row[key] / row["known"] - 1) for key in ("value", "low", "high")]
        for row in rows("friction", parameter="torque_constant")
    }
    assert [one.joint for one in found] == sorted([2, 3, 5], key=lambda joint: -abs(off[joint][0]))
    for one in found:
        assert (one.value, one.low, one.high) == pytest.approx(off[one.joint or 0])


# Contacts, alarms


def felt_contacts(**values: Any) -> list[Row]:
    return [one for one in rows("contact_errors", **values) if one["peak"] >= 5]


def test_contacts_are_counted_by_their_fate_and_motion(told: Judged) -> None:
    first, *others = of_question(told, "contacts")
    every = felt_contacts()
    assert (first.count, first.of) == (len(felt_contacts(fate="found")), len(every))
    assert first.reason == ""
    for motion, resting in (("at rest", True), ("in motion", False)):
        own = [one for one in every if (MOVING[one["recording"]] is None) == resting]
        (row,) = (
            one for one in others if one.quantity == "contacts found" and one.motion == motion
        )
        assert (row.count, row.of) == (sum(one["fate"] == "found" for one in own), len(own))
    for fate, words in (("missed", "contacts missed"), ("merged", "another's alarm")):
        row, own = of_quantity(told, "contacts", words), felt_contacts(fate=fate)
        value, most = largest(own, lambda one: one["peak"])
        assert (row.value, row.recording) == (value, most["recording"])
        assert (row.count, row.of) == (len(own), len(every))
    found = felt_contacts(fate="found")
    peak = of_quantity(told, "contacts", "signed error of found peaks")
    assert peak.value == pytest.approx(100 * mean(one["peak_error"] / one["peak"] for one in found))
    peak = of_quantity(told, "contacts", "a found contact, largest")
    _, row = largest(found, lambda one: abs(one["peak_error"]))
    assert (peak.value, peak.recording) == (row["peak_error"], row["recording"])
    size = of_quantity(told, "contacts", "mean absolute error of found peaks")
    assert size.value == pytest.approx(
        100 * mean(abs(one["peak_error"]) / one["peak"] for one in found)
    )
    short = of_quantity(told, "contacts", "largest shortfall of a peak")
    value, row = largest(found, lambda one: -one["peak_error"])
    assert (short.value, short.recording) == (value, row["recording"])


@pytest.mark.parametrize(("doubted", "reason"), [("c1 c2 c3", "sensor_bias"), ("c1 c3", "")])
def test_contacts_are_doubted_where_every_sensor_is(doubted: str, reason: str) -> None:
    entries = [{"name": name, "robot": "ur5", "role": "contact"} for name in ("c1", "c2", "c3")]
    offset = {"device": "force", "severity": "warning", "code": Found.OFFSET, "count": 1}
    found = tables_of(
        entries,
        recordings=TABLES["recordings"],
        contact_errors=TABLES["contact_errors"],
        quality=[offset | {"recording": name} for name in doubted.split()],
    )
    first, *others = judge_contacts(found)
    assert first.reason == reason
    assert {one.reason for one in others} == {""}
    sizes = [one.count for one in others if "mean absolute error of found peaks" in one.quantity]
    counts = [
        sum(one["recording"] in names for one in felt_contacts(fate="found"))
        for names in (["c2"], ["c1", "c3"])
    ]
    assert sizes == (counts if reason == "" else [sum(counts)])  # those of sure sensors first


def test_from_the_least_peak_above_all_that_are_missed_none_is_missed(told: Judged) -> None:
    for verdict in of_question(told, "contacts"):
        if verdict.quantity == "no contact missed from":
            own = [
                one
                for one in felt_contacts()
                if verdict.motion
                in ("", "at rest" if MOVING[one["recording"]] is None else "in motion")
            ]
            most = max(one["peak"] for one in own if one["fate"] == "missed")
            above = [one for one in own if one["peak"] > most]
            value, row = largest(above, lambda one: -one["peak"])
            assert (verdict.value, verdict.recording) == (-value, row["recording"])
            assert verdict.count == len(above)


def test_peaks_are_those_before_forces_are_averaged() -> None:
    """Where the sensor is saturated, or the estimate states none, nothing is put in their place."""
    rows = pd.DataFrame(
        {
            "peak": [20.0, 20.0, 20.0],
            "peak_error": [-3.0, None, -4.0],
            "largest": [19.0, 25.0, None],
        }
    )
    assert with_sharp_peaks(rows)["peak_error"].tolist() == pytest.approx(
        [-1.0, np.nan, -4.0], nan_ok=True
    )


def test_what_is_noticed_on_a_recording_is_what_its_rows_hold(told: Judged) -> None:
    minutes = {row["recording"]: row["duration_s"] / 60 for row in TABLES["recordings"]}
    for one in told.noticed:
        own = {fate: felt_contacts(recording=one.recording, fate=fate) for fate in FATES}
        assert [one.found, one.merged, one.missed] == [len(own[fate]) for fate in FATES]
        assert one.contacts == sum(map(len, own.values()))
        for starts, fate in ((one.missed_s, "missed"), (one.merged_s, "merged")):
            assert [*map(float, starts.split())] == pytest.approx(
                [row["start_s"] for row in own[fate]], abs=0.06
            )
        peaks = [row["peak"] for row in own["missed"]]
        assert one.largest_missed == max(peaks, default=None)
        assert one.smallest_found == min((row["peak"] for row in own["found"]), default=None)
        if own["found"]:
            shares = [row["peak_error"] / row["peak"] for row in own["found"]]
            assert one.peak_bias == pytest.approx(mean(shares))
        raised = rows("contacts", recording=one.recording)
        assert one.alarms == len(raised)
        assert one.alarms_per_min == pytest.approx(len(raised) / minutes[one.recording])
        known = ROLES[one.recording] == "contact"
        false = 0.4 * len(raised) if known else sum(row["kind"] == "false" for row in raised)
        assert one.false_alarms == round(false)
        widths = [
            (row[f"{axis}_std"], axis, row)
            for row in raised
            if row["kind"] != "off_flange"
            for axis in AXES
        ]
        if widths:
            std, axis, row = max(widths, key=lambda width: width[0])
            assert one.band == pytest.approx(1.96 * std, rel=1e-4)
            assert (one.band_axis, one.band_s) == (axis[1], row["peak_s"])
            assert one.posture_deg == row["posture_deg"]


def test_a_recording_for_contacts_has_a_row_even_if_nothing_was_noticed() -> None:
    entries = [{"name": name, "robot": "ur5", "role": ROLES[name]} for name in ("f1", "v1", "c1")]
    searched = [
        {"recording": one["name"], "estimate": "Fmap", "alarms_per_min": 0.0} for one in entries
    ]
    found = tables_of(entries, recordings=TABLES["recordings"], detection=searched)
    (row,) = noticed(found)
    assert (row.recording, row.role, row.contacts, row.alarms) == ("c1", "contact", 0, 0)
    assert row.false_alarms is None  # something may touch the arm, and no sensor says when


def test_false_alarms_are_counted_with_the_time_of_their_days(told: Judged) -> None:
    away = {"v1": 0, "v2": 3, "v3": 7}
    parts = {"all": [*away], "without fit": ["v2", "v3"], "farthest": ["v3"]}
    found = {(one.role, one.days): one for one in told.false_alarms}
    assert {days for role, days in found if role == "validate"} == {*parts}
    for days, names in parts.items():
        one = found["validate", days]
        minutes = sum(
            row["duration_s"] for row in TABLES["recordings"] if row["recording"] in names
        )
        alarms = sum(row["recording"] in names for row in TABLES["contacts"])
        assert (one.recordings, one.alarms) == (len(names), alarms)
        assert one.minutes == pytest.approx(minutes / 60)
        assert one.per_min == pytest.approx(60 * alarms / minutes)
        # so few are found with 5 % if it were the rate
        assert poisson.cdf(alarms, one.per_min_high * one.minutes) == pytest.approx(0.05)


def test_false_alarms_of_unseen_recordings_are_told_of_all_and_of_days_without_a_fit(
    told: Judged,
) -> None:
    own = [one for one in told.false_alarms if one.role == "validate" and one.days != "farthest"]
    unseen = [one for one in of_question(told, "alarms") if one.basis == "unseen"]
    assert [one.count for one in unseen if one.value is None] == [one.alarms for one in own]
    limits = [one.value for one in of_question(told, "alarms") if one.unit == "a minute"]
    assert limits == [one.per_min_high for one in own]
    (beside,) = (one for one in of_question(told, "alarms") if "with contacts" in one.quantity)
    assert beside.count == sum(one.false_alarms or 0 for one in told.noticed if one.contacts)


def test_a_day_is_away_from_the_fit_from_the_first_on() -> None:
    frame = pd.DataFrame({"days": [0.0, 1.0, 1.0, np.nan], "minutes": 1.0, "alarms": 1.0})
    assert {when: len(part) for when, part in of_days(frame)} == {
        "all": 4,
        "without fit": 2,
        "farthest": 2,
    }
    assert [when for when, _ in of_days(frame[:1])] == ["all"]


# Force


def test_the_error_of_the_force_is_its_mean_and_then_that_of_its_worst_place(
    told: Judged,
) -> None:
    ours, plain = (rows("force_mae", estimate=name) for name in ("Fmap", UNGATED))
    known = {one.rank: one for one in of_question(told, "force")}
    assert known[1].value == pytest.approx(mean(row["mae"] for row in ours))
    assert known[1].zero == pytest.approx(mean(row["mean_force"] for row in ours))
    assert known[1].rival_value == pytest.approx(mean(row["mae"] for row in plain))
    value, row = largest(ours, lambda one: one["mae"])
    worst = known[2]
    assert (worst.value, worst.zero, worst.recording) == (
        value,
        row["mean_force"],
        row["recording"],
    )
    assert (worst.axis, worst.low, worst.high) == (
        *(row["component"][1], row["mae_low"], row["mae_high"]),
    )
    assert worst.rival_value == max(one["mae"] for one in plain)
    gain = of_quantity(told, "force", "gain")
    assert (gain.value, gain.recording, gain.axis) == (row["slope"], row["recording"], worst.axis)
    means = {
        name: [mean(row[key] for row in part) for key in ("mae", "mean_force")]
        for name, part in grouped(ours, "recording").items()
    }
    farthest = max(means, key=lambda name: means[name][0] / means[name][1])
    fourth = known[4]
    assert (fourth.recording, [fourth.value, fourth.zero]) == (
        farthest,
        pytest.approx(means[farthest]),
    )
    beside = [row["mae"] for row in plain if row["recording"] == farthest]
    assert fourth.rival_value == pytest.approx(mean(beside))


@pytest.mark.parametrize(
    ("errors", "expected"),
    [((1.0, 1.0, 30.0), "usable"), ((9.0, 12.0, 30.0), "do not use")],
)
def test_a_force_is_useless_where_no_force_errs_as_little(
    errors: tuple[float, ...], expected: str
) -> None:
    """By all axes together, of 10, 10 and 20 N: one that is worse than zero is a doubt."""
    own = [
        row | {"mae": error, "mean_force": force}
        for row, error, force in zip(touched(1.0), errors, (10.0, 10.0, 20.0), strict=True)
    ]
    about = {"recording": "pushed", "duration_s": 60.0, "frames": 100, "moving_joints": "1"}
    entry = V1 | {"name": "pushed", "role": "contact"}
    first, *_ = judge_force(tables_of([entry], recordings=[about], force_mae=own))
    assert first.state == expected


@pytest.mark.parametrize(("error", "reason"), [(0.29, ""), (0.31, "far_above_floor")])
def test_a_force_is_compared_with_what_its_repeats_leave(error: float, reason: str) -> None:
    """Thrice as much is too far, of the errors on the repeated motions themselves."""
    floors = [
        {"robot": "ur5", "quantity": "force", "component": axis, "floor": 0.1, "error": error}
        for axis in AXES
    ]
    pushed = V1 | {"name": "pushed", "role": "contact"}
    about = {"recording": "pushed", "duration_s": 60.0, "frames": 100, "moving_joints": "1"}
    made = tables_of([pushed], recordings=[about], force_mae=touched(1.0), repetition=floors)
    first, *_ = judge_force(made)
    assert (first.reason, first.floor) == (reason, pytest.approx(0.1))


def test_bands_in_contact_are_told_by_the_worst_at_rest_and_in_motion(told: Judged) -> None:
    ours = rows("force_mae", estimate="Fmap")
    for motion, resting in (("at rest", True), ("in motion", False)):
        own = [row for row in ours if (MOVING[row["recording"]] is None) == resting]
        _, *bands = of_question(told, "bands")
        held, blind, width = (one for one in bands if one.motion == motion)
        value, row = largest(own, lambda one: -one["coverage95"])
        assert (held.value, held.axis) == (pytest.approx(-100 * value), row["component"][1])
        assert held.reason == ("undercovers" if row["coverage95"] < 0.9 else "")
        value, row = largest(own, lambda one: one["zero_in_band95"])
        assert (blind.value, blind.recording) == (pytest.approx(100 * value), row["recording"])
        assert blind.reason == ("blind" if value > 0.5 else "")
        _, row = largest(own, lambda one: abs(math.log(one["band_factor95"])))
        assert (width.value, width.axis) == (
            *(pytest.approx(1 / row["band_factor95"]), row["component"][1]),
        )


def test_bands_are_decided_by_the_score_farthest_above_plain_least_squares(told: Judged) -> None:
    score, plain = (
        {
            name: np.mean([row[column] for row in rows("force_mae", recording=name, estimate=own)])
            for name in MOVING
            if rows("force_mae", recording=name, estimate=own)
        }
        for own, column in (("Fmap", "interval_score95"), (UNGATED, "even_interval_score95"))
    )
    ratio = {name: score[name] / plain[name] for name in score}
    worst = max(ratio, key=lambda name: ratio[name])
    first, *_ = of_question(told, "bands")
    assert (first.rank, first.recording) == (1, worst)
    assert (first.value, first.rival_value) == pytest.approx((score[worst], plain[worst]))


@pytest.mark.parametrize(
    ("changed", "expected"),
    [
        ({}, ("good", "")),
        ({"coverage95": 0.89}, ("usable", "undercovers")),
        ({"interval_score95": 60.0}, ("usable", "rival_better")),
        ({"interval_score95": 48.0}, ("usable", "rival_equal")),
        ({"interval_score95": 100.0}, ("do not use", "worse_than_zero")),
        ({"use": "no"}, ("not determined", "sensor_bias")),
    ],
)
def test_the_state_of_bands(changed: dict[str, Any], expected: tuple[str, str]) -> None:
    about = {"recording": "pushed", "duration_s": 60.0, "frames": 100, "moving_joints": "1"}
    given = {"interval_score95": 20.0, "zero_interval_score95": 90.0} | changed
    ours = touched(1.0, band_factor95=1.0, zero_in_band95=0.1, **given)
    theirs = [row | {"estimate": UNGATED, "even_interval_score95": 50.0} for row in touched(2.0)]
    entry = V1 | {"name": "pushed", "role": "contact"}
    found = judge_force(tables_of([entry], recordings=[about], force_mae=ours + theirs))
    (first,) = (one for one in found if one.question == "bands" and one.rank == 1)
    assert (first.state, first.reason) == expected


@pytest.mark.parametrize(("use", "reason"), [("yes", ""), ("no", "sensor_bias")])
def test_a_band_in_contact_is_doubted_with_its_sensor(use: str, reason: str) -> None:
    own = touched(1.0, use=use, zero_in_band95=0.1, band_factor95=1.0)
    about = {"recording": "pushed", "duration_s": 60.0, "frames": 100, "moving_joints": "1"}
    entry = V1 | {"name": "pushed", "role": "contact"}
    found = judge_force(tables_of([entry], recordings=[about], force_mae=own))
    assert [one.reason for one in found if one.question == "bands"] == [*[reason] * 3, ""]


def test_the_parts_of_a_recording_s_error_are_means_over_axes(told: Judged) -> None:
    for one in told.error_parts:
        own = rows("force_mae", estimate="Fmap", recording=one.recording)
        names = {
            "error": "mae",
            "missed": "mae_missed",
            "late_alarms": "mae_shut",
            "gain": "mae_gain",
        }
        for name, column in names.items():
            assert getattr(one, name) == pytest.approx(mean(row[column] for row in own))
        assert one.share == pytest.approx(one.error / mean(row["mean_force"] for row in own))
        assert one.friction == pytest.approx(mean(0.5 * row["mae"] - 0.1 for row in own))


def test_a_drift_is_told_where_it_is_determined_within_a_newton_a_minute(told: Judged) -> None:
    for one in told.error_parts:
        (row,) = rows("sensed", recording=one.recording)
        known = [axis for axis in "xyz" if 1.96 * row[f"drift_std_{axis}"] <= 1]
        assert one.drift_std == max((row[f"drift_std_{axis}"] for axis in known), default=None)
        for axis in "xyz":
            drift = row[f"drift_{axis}"] if axis in known else None
            assert getattr(one, f"drift_{axis}") == drift


# Recordings


def test_findings_are_counted_once_for_a_recording_and_a_device(told: Judged) -> None:
    first, *counted, serving = of_question(told, "recordings")
    kinds = {
        (row["severity"], row["recording"], row["device"], row["finding"])
        for row in TABLES["quality"]
    }
    numbers = {"stop signs": 0} | {f"{name}s": 0 for name in SEVERITIES[1:]}
    for severity, *_ in kinds:
        numbers[f"{severity}s"] += 1
    assert [(one.quantity, one.count) for one in counted] == [*numbers.items()]
    assert [one.rank for one in (*counted, serving)] == [2, 3, 4, 5, 6]
    used = {one.recording for one in told.uses if one.use == "yes"}
    assert (serving.count, serving.of) == (len(used), len(ROLES))
    frames = {row["recording"]: row["frames"] for row in TABLES["recordings"]}
    lost: dict[tuple[str, str], int] = defaultdict(int)
    for row in rows("quality", severity="error", code=Found.LOST_FRAMES):
        lost[row["recording"], row["device"]] += row["count"]
    name, device = max(lost, key=lambda own: lost[own] / frames[own[0]])
    assert (first.recording, first.count, first.of) == (name, lost[name, device], frames[name])


def test_a_severity_without_findings_has_no_row() -> None:
    """But stop signs: none is worth a row."""
    (entry,) = rows("recordings", recording="v1")
    about = tables_of(
        [V1], recordings=[entry], quality=rows("quality", severity="warning", recording="v1")[:1]
    )
    _, *counted = judge_recordings(about)
    assert [(row.quantity, row.count, row.rank) for row in counted] == [
        *(("stop signs", 0, 2), ("warnings", 1, 4)),
        ("recordings that serve a purpose", 0, 6),
    ]


def test_a_recording_that_could_not_be_read_is_counted_and_graver_than_an_error() -> None:
    (entry,) = rows("recordings", recording="v1")
    absent = {"name": "gone", "robot": "ur5", "role": "fit"}
    errors = rows("quality", severity="error", recording="v1")[:1]
    stop = errors[0] | {"severity": "stop"}
    for entries, found, expected in (
        ([V1], errors, ("usable", "error")),
        ([V1, absent], errors, ("usable", "unread")),
        ([V1, absent], [stop], ("do not use", "stopped")),
        ([V1, absent], [], ("usable", "unread")),
    ):
        tables = {"quality": found, "acceleration_mae": [{"recording": "v1"}]}
        first, *_ = judge_recordings(tables_of(entries, recordings=[entry], **tables))
        assert (first.state, first.reason) == expected
        if absent in entries:
            assert (first.recording, first.count, first.of) == ("gone", 1, 2)


def test_each_recording_has_its_purposes_or_one_row_that_says_none(told: Judged) -> None:
    by_name = {
        name: [(row.purpose, row.use) for row in told.uses if row.recording == name]
        for name in ROLES
    }
    for name, own in by_name.items():
        assert len(dict(own)) == len(own)
        assert "all" not in dict(own)
        assert dict(own)["contacts" if name.startswith("c") else "links"] == "yes"
    (row,) = uses(tables_of([V1], recordings=rows("recordings", recording="v1")))
    assert (row.purpose, row.use, row.reason) == ("all", "no", "no_reference")
    silent = [
        quality | {"code": Found.NO_CURRENTS, "recording": "v1"} for quality in rows("quality")[:1]
    ]
    (row,) = uses(tables_of([V1], recordings=rows("recordings", recording="v1"), quality=silent))
    assert (row.purpose, row.use, row.reason) == ("all", "no", "no_effort")


def test_a_fit_recording_with_more_alarms_than_the_others_explain_was_touched() -> None:
    """By the rate of the arm's other fit recordings, and one alarm in 50 minutes besides."""
    counts, seconds = {"f1": 3, "f2": 1, "f3": 0}, {"f1": 60.0, "f2": 300.0, "f3": 240.0}
    entries = [{"name": name, "robot": "ur5", "role": "fit"} for name in counts]
    alarm = {"estimate": "Fmap", "kind": "contact"}
    lengths = [{"recording": name, "duration_s": seconds[name]} for name in seconds]
    alarms = [alarm | {"recording": name} for name in counts for _ in range(counts[name])]
    found = tables_of(entries, recordings=lengths, contacts=alarms)
    expected = []
    for name in counts:
        others = sum(counts.values()) - counts[name] + 0.02
        rate = others / (sum(seconds.values()) - seconds[name] + 60)
        chance = poisson.sf(counts[name] - 1, rate * seconds[name])
        if len(counts) * chance < 0.05:
            expected.append(name)
    assert felt_while_fitted(found) == expected == ["f1"]


@pytest.mark.parametrize(
    ("names", "unit"),
    [(["ur5"], "A"), (["kuka-kr300"], "Nm"), (["kuka-kr300", "ur5"], "A")],
)
def test_errors_are_of_torques_where_all_arms_measure_them(names: list[str], unit: str) -> None:
    arms = [load_robot(robot_path(name)) for name in names]
    about = read_tables("recordings: []", [], arms)
    assert about.effort.unit == unit
    assert {*about.bearing} == {*names}
    assert about.loads == {arm.name: load.mass for arm in arms if (load := arm.known_load())}


# Advice


def test_what_a_remark_asks_for_is_recorded_now_or_later() -> None:
    """More paths make intervals surer, which can wait."""
    codes = ("few paths", "one path", "no motion")
    remarks = [
        {"robot": "ur5", "step": "friction", "joint": joint, "remark": "why", "code": code}
        for code in codes
        for joint in (3, 5)
    ]
    given = [*advice(tables_of([V1], remarks=remarks))]
    kinds = {one.code: one for one in given if one.code in ASKING.values()}
    assert {code: one.kind for code, one in kinds.items()} == {
        "few_paths": "later",
        "one_path": "recording",
        "no_motion": "recording",
    }
    assert {one.joints for one in kinds.values()} == {"3 5"}
    order = [one.code for one in given if one.code in kinds]
    assert order == ["no_motion", "one_path", "few_paths"]


@pytest.mark.parametrize(
    ("roles", "asked"),
    [
        (["fit", "validate"], {}),
        (["validate"], {"fit": ""}),
        (["fit", "still"], {"validate": "at rest"}),
        (["contact"], {"fit": "", "validate": ""}),
    ],
)
def test_a_role_that_no_recording_has_is_asked_for(roles: list[str], asked: Row) -> None:
    entries = [
        V1 | {"name": role, "role": "fit" if role == "still" else role, "still": role == "still"}
        for role in roles
    ]
    given = [*advice(tables_of(entries))]
    assert {one.code: one.detail for one in given if one.code in ("fit", "validate")} == asked


@pytest.mark.parametrize(("contacts", "asked"), [(None, True), (0, True), (1, False)])
def test_pushes_are_asked_for_where_no_sensor_read_a_contact(
    contacts: int | None, asked: bool
) -> None:
    sensed = [] if contacts is None else [{"recording": "v1", "contacts": contacts}]
    assert ("pushes" in {one.code for one in advice(tables_of([V1], sensed=sensed))}) == asked
    compared = tables_of([V1], sensed=sensed, force_mae=touched(1.0))
    assert "pushes" not in {one.code for one in advice(compared)}


def test_recordings_that_lost_a_tenth_of_their_frames_are_named_the_worst_first(
    told: Judged,
) -> None:
    frames = {row["recording"]: row["frames"] for row in TABLES["recordings"]}
    lost: dict[str, int] = defaultdict(int)
    for row in rows("quality", code=Found.LOST_FRAMES):
        lost[row["recording"]] += row["count"]
    shares = {name: lost[name] / frames[name] for name in lost}
    many = [name for name in shares if shares[name] >= 0.1]
    (one,) = (own for own in told.advice if own.code == "lossy")
    assert (one.recording, one.recordings) == (max(shares, key=shares.__getitem__), len(many))
    assert one.value == pytest.approx(max(shares.values()))
    whole = tables_of([V1], recordings=rows("recordings", recording="v1"))
    assert "lossy" not in {own.code for own in advice(whole)}


def test_of_several_stops_and_loads_the_first_is_asked_for_alone() -> None:
    """And of loads, all are counted."""
    stops = [finding("stop", recording=name) for name in ("v1", "c1")]
    load = {"robot": "ur5", "taken": "yes", "configured": 1.0, "std_error": 0.1}
    loads = [load | {"recording": f"c{k}", "mass": 0.5 * k} for k in (1, 2)]
    given = [*advice(tables_of([V1], quality=stops, payload=loads))]
    (stop,) = (one for one in given if one.code == "stop_recording")
    assert (stop.recording, stop.recordings) == ("v1", 2)
    (carried,) = (one for one in given if one.code == "payload")
    assert (carried.recording, carried.recordings, carried.value) == ("c1", 2, 1.5)


def test_a_stop_sign_of_an_arm_that_repeats_a_recording_s_is_no_step_of_its_own() -> None:
    stops = [finding("stop", recording="v1", detail="no unit")]
    for remark, code in (("v1 has a stop sign: no unit", []), ("no gear", ["stop_arm"])):
        remarks = [{"robot": "ur5", "step": STOP, "remark": remark}]
        given = advice(tables_of([V1], quality=stops, remarks=remarks))
        assert [one.code for one in given if one.code == "stop_arm"] == code


@pytest.mark.parametrize(
    ("count", "high", "short"), [(0, 1.1, True), (0, 0.9, False), (1, 2, False)]
)
def test_time_without_an_alarm_may_be_too_short_to_promise_few(
    count: int, high: float, short: bool
) -> None:
    of: Row = {"role": "fit", "estimate": "Fmap", "days": "all", "recordings": 1, "minutes": 3.0}
    row = FalseAlarms(**of, alarms=count, per_min=count / 3, per_min_high=high)
    first, time, limit = rates(row)
    assert (first["reason"] == "short") == short
    assert (first["count"], time["value"], limit["value"]) == (count, 3.0, high)
