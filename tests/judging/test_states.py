"""Each rule of a state at its borders, on tables with a known answer."""

from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.made_study import (
    DOUBTED,
    FAR,
    REFUSED,
    RESTING,
    UNKNOWN,
    constant,
    finding,
    judged_anew,
    predicted,
    rates,
    state,
    study,
    torques,
    touched,
    verdicts_of,
)
from ur5lib.force.estimators import UNGATED
from ur5lib.judging import limits
from ur5lib.judging.advice import advice
from ur5lib.judging.errors import Conditions, beaten, severest, state_of
from ur5lib.records.codes import Found
from ur5lib.records.verdicts import REASONS, Asks, Reason, State
from ur5lib.report.results import Results
from ur5lib.steps.judge_study import judged
from ur5lib.study.model import Settings

STATED = {  # numbers in the sentences of reasons, as the limits give them
    "far_above_floor": ("three times", limits.MAX_GOOD_FLOORS == 3),
    "undercovers": ("less than 90 %", limits.MIN_GOOD_COVERAGE == 0.9),
    "too_wide": ("twice", limits.MIN_GOOD_BAND_FACTOR == 0.5),
    "blind": ("half of the time", limits.MAX_BLIND_SHARE == 0.5),
}


@pytest.mark.parametrize(
    ("error", "more", "expected"),
    [
        (0.49, {}, ("good", "")),
        (0.5, {}, ("usable", "large_error")),
        (0.99, {}, ("usable", "large_error")),
        (1.0, {}, ("do not use", "worse_than_zero")),
        (0.1, {"coverage95": 0.9}, ("good", "")),
        (0.1, {"coverage95": 0.89}, ("usable", "undercovers")),
        (0.1, {"rival_error": 0.11}, ("good", "")),
        (0.1, {"rival_error": 0.1}, ("usable", "rival_equal")),
        (0.1, {"rival_error": 0.09}, ("usable", "rival_better")),
        (0.1, {"in_floors": 3.0}, ("good", "")),
        (0.1, {"in_floors": 3.1}, ("usable", "far_above_floor")),
        (0.1, {"band_factor95": 0.4}, ("usable", "too_wide")),
    ],
)
def test_a_state_follows_from_the_error_and_zero(
    error: float, more: dict[str, Any], expected: tuple[State, Reason]
) -> None:
    row = pd.Series({"error": error, "zero": 1.0, **more})
    assert state_of(row, Conditions()) == expected
    nothing = pd.Series({"error": 0.0, "zero": 0.0, **more})
    assert state_of(nothing, Conditions()) == ("not determined", "too_small")
    if expected[0] == "good":
        assert state_of(row, Conditions(unseen=False)) == ("usable", "no_unseen")


@pytest.mark.parametrize(
    ("rival", "expected"),
    [(1.0e-4, ["rival_better"]), (1.2e-4, ["rival_equal"]), (1.7e-4, [])],
)
def test_errors_that_differ_by_less_than_a_table_shows_are_equal(
    rival: float, expected: list[str]
) -> None:
    assert [*beaten(1.6e-4, rival)] == expected
    assert [*beaten(4e-5, rival)] == []


def test_the_sentence_of_a_reason_has_the_limit_that_gives_it() -> None:
    for reason, (words, holds) in STATED.items():
        assert words in REASONS[reason]
        assert holds


def test_of_several_arms_the_severest_state_decides_and_good_are_all() -> None:
    assert severest(["good", "good"]) == "good"
    assert severest(["good", "not determined"]) == "usable"
    assert severest(["usable", "do not use", None]) == "do not use"


# Constants


@pytest.mark.parametrize(
    ("second", "expected"),
    [
        ({}, ("good", "")),
        (FAR, ("usable", "far")),
        ({"reason": "one_path"}, ("usable", "one_path")),
        (UNKNOWN, ("usable", "prior_only")),
        (REFUSED, ("usable", "contradicted")),
        ({"use": "no", "reason": "unlikely"}, ("do not use", "unlikely")),
    ],
)
def test_constants_are_judged_by_how_many_may_be_used(
    second: dict[str, Any], expected: tuple[str, str]
) -> None:
    rows = [constant(1, 10.0), constant(2, 11.0, **second), constant(3, 10.0)]
    assert state(study(friction=rows), "constants") == expected
    if second in (UNKNOWN, REFUSED):
        none = [constant(joint, 10.0, **second) for joint in (1, 2, 3)]
        assert state(study(friction=none), "constants")[0] == "not determined"


def test_the_widest_and_the_farthest_constant_are_of_those_that_the_recordings_determine() -> None:
    """142 Nm/A is what the currents of joint 2 would give; joint 3 says nothing."""
    rows = [constant(1, 8.0), constant(2, 10.0, **REFUSED), constant(3, 30.0, **UNKNOWN)]
    counted, widest, farthest, sure = verdicts_of(study(friction=rows), "constants")
    assert (sure.count, sure.of) == (0, 3)
    assert (counted.count, counted.of) == (1, 3)
    assert (widest.joint, widest.value) == (1, 12.5)
    assert (farthest.joint, farthest.value, farthest.low) == (2, 142.0, None)
    assert farthest.rival_value == 10.0
    alone = verdicts_of(study(friction=[constant(1, 30.0, **UNKNOWN)]), "constants")
    assert [row.value for row in alone] == [None, None]


def test_constants_that_stop_a_study_are_not_to_be_used() -> None:
    remarks = [{"robot": "ur5", "step": "stop sign", "remark": "wrong", "code": "unknown side"}]
    results = study(friction=[constant(1, 10.0)], remarks=remarks)
    assert state(results, "constants") == ("do not use", "stopped")
    assert state(results, "force") == ("do not use", "stopped")
    assert verdicts_of(study(), "constants") == []


def test_one_stop_sign_contradicts_a_study_and_an_unreadable_recording_does_not() -> None:
    remark = {"robot": "ur5", "step": "stop sign", "remark": "wrong"}
    assert study(remarks=[remark]).stopped()
    assert study(quality=[finding("stop", Found.CONTRADICTION)]).stopped()
    assert not study(quality=[finding("stop", Found.UNREADABLE)]).stopped()
    assert not study(remarks=[remark | {"step": "friction"}]).stopped()


def test_gravity_is_judged_by_the_joints_that_bear_it() -> None:
    rows = [constant(1, 10.0), constant(2, 10.5), constant(3, 13.0), constant(4, 10.0, **REFUSED)]
    results = replace(study(friction=rows), bearing={"ur5": [2, 3, 4]})
    found = {row.joint: row.value for row in verdicts_of(results, "gravity")}
    assert found == pytest.approx({4: 1320.0, 3: 30.0, 2: 5.0})
    assert [row.rank for row in verdicts_of(results, "gravity")] == [1, 2, 3]


def test_loads_that_agree_are_counted_where_the_currents_determine_one() -> None:
    ends = {"fitted": (-0.9, -0.1), "seen": (0.1, 0.9), "pushed": (-90.0, 90.0)}
    rows = [
        {"recording": name, "low": low, "high": high, "mass": 0.0, "taken": "no"}
        for name, (low, high) in ends.items()
    ]
    rows[1] |= {"taken": "yes", "mass": 0.5}
    rows[0] |= {"mass": -0.5}
    agreeing, widest, load, other = verdicts_of(
        replace(study(payload=rows), loads={"ur5": 2.0}), "load"
    )
    assert (agreeing.rank, widest.rank, load.rank, other.rank) == (1, 2, 3, 4)
    assert (other.recording, other.value) == ("fitted", -0.5)
    assert other.quantity == "load farthest from the declared one, by"
    assert (agreeing.count, agreeing.of, agreeing.reason) == (0, 2, "loaded")
    assert widest.value == pytest.approx(0.4)
    assert (load.recording, load.value) == ("seen", 0.5)
    rows[1] |= {"taken": "no", "low": -0.1}
    agreeing, _, _ = verdicts_of(replace(study(payload=rows), loads={"ur5": 2.0}), "load")
    assert (agreeing.count, agreeing.state, agreeing.reason) == (1, "good", "")  # one is chance


@pytest.mark.parametrize(
    ("wrong", "half", "found"),
    [
        (0, 0.1, ("good", "")),
        (3, 0.1, ("good", "")),  # of sixty intervals of 95 %, chance gives as many
        (9, 0.1, ("usable", "disagrees")),
        (0, 1.5, ("not determined", "load_unsure")),
    ],
)
def test_a_load_is_right_by_more_than_chance_and_if_it_is_known(
    wrong: int, half: float, found: tuple[str, str]
) -> None:
    middles = [1.5 * half] * wrong + [0.0] * (60 - wrong)
    rows = [
        {"recording": "fitted", "low": middle - half, "high": middle + half, "taken": "no"}
        for middle in middles
    ]
    first, *_ = verdicts_of(replace(study(payload=rows), loads={"ur5": 2.0}), "load")
    assert (first.state, first.reason) == found


# Recordings


def test_the_most_serious_finding_decides_and_the_largest_share_is_named() -> None:
    states = {"note": "good", "warning": "usable", "error": "usable", "stop": "do not use"}
    serves: dict[str, Any] = {"acceleration_mae": [{"recording": "fitted"}]}
    for severity, expected in states.items():
        rows = [finding("note", Found.JITTER), finding(severity, Found.CONTRADICTION)]
        assert state(study(quality=rows, **serves), "recordings")[0] == expected
    rows = [finding("warning", count=86), finding("warning", count=250, recording="fitted")]
    every = [*rows, finding("warning", Found.JITTER), finding("note")]
    first, stops, warnings, notes, serving = verdicts_of(
        study(quality=every, **serves), "recordings"
    )
    assert (first.recording, first.count, first.of) == ("fitted", 250, 1000)
    assert (stops.count, warnings.count, notes.count, serving.of) == (0, 3, 1, 3)


def test_recordings_of_which_none_serves_are_not_used_and_their_currents_are_asked_for() -> None:
    rows = [
        finding("warning", Found.NO_CURRENTS, recording=name)
        for name in ("pushed", "fitted", "unseen")
    ]
    silent = study(quality=rows)
    first, *_ = verdicts_of(silent, "recordings")
    assert (first.state, first.reason) == ("do not use", "no_effort")
    assert (first.quantity, first.count) == ("recordings without currents", 3)
    assert [one.code for one in advice(silent)] == [Asks.NO_EFFORT]
    assert Asks.NO_EFFORT not in [one.code for one in advice(study(quality=rows[:2]))]


def test_a_finding_in_several_places_of_a_recording_is_one() -> None:
    places = [finding("note", Found.COLUMNS_NOT_USED, place=place) for place in ("a", "b", "c")]
    results = study(quality=[*places, places[0] | {"recording": "fitted"}])
    assert verdicts_of(results, "recordings")[-2].count == 2


# Link models


def test_a_link_model_is_judged_on_unseen_recordings() -> None:
    rows = torques({"A": 0.2, "B": 0.1}) + torques({"A": 0.0, "B": 0.9}, ("fitted",))
    rows += [row | {"motion": "closed_loop", "mae_2hz": 0.3} for row in rows]
    first, most, near = verdicts_of(study(torque_mae=rows), "links")
    assert (first.state, first.value, first.joint, first.zero) == ("good", 0.1, 1, 1.0)
    assert (most.rank, most.recording) == (3, "seen")
    assert "Model B comes closest" in near.quantity
    assert (near.count, near.of) == (6, 6)
    alone = study(torque_mae=torques({"A": 0.1}, ("fitted",)))
    assert state(alone, "links") == ("usable", "no_unseen")


@pytest.mark.parametrize(
    ("error", "expected"), [(0.14, "good"), (0.16, "usable"), (1.0, "do not use")]
)
def test_half_of_zero_is_no_good_link_model(error: float, expected: str) -> None:
    assert state(study(torque_mae=torques({"A": error})), "links")[0] == expected


def test_the_worst_joint_is_that_of_the_largest_share() -> None:
    rows = torques({"A": 0.4}) + torques({"A": 0.6}, ("pushed",))
    rows[7] |= {"mae_2hz": 3.0, "zero_mae_2hz": 20.0}  # the largest, though a small share
    rows[0] |= {"mae_2hz": 0.7}
    first, most, _ = verdicts_of(study(torque_mae=rows), "links")
    assert (first.joint, first.value, first.low, first.high) == (1, pytest.approx(0.65), 0.6, 0.7)
    assert (most.joint, most.value, most.recording, most.zero) == (2, 3.0, "pushed", 20.0)


def test_why_links_are_not_judged() -> None:
    assert state(study(RESTING, torque_mae=torques({"A": 0.2})), "links")[1] == "no_motion"
    assert state(study(), "links")[1] == "no_reference"
    found = study(parameters=[{"robot": "ur5", "determined": "yes"}])
    unknown = replace(found, placeholders=frozenset({"ur5"}))
    (row,) = verdicts_of(unknown, "links")
    assert (row.reason, row.count, row.of) == ("unknown_links", 1, 1)
    load = finding("warning", Found.GIVEN_LOAD, detail="it contains 0.40 kg")
    loaded = study(torque_mae=torques({"A": 0.05}), quality=[load])
    assert state(loaded, "links") == ("usable", "loaded")


# Currents


@pytest.mark.parametrize(
    ("error", "held", "expected"),
    [
        (0.2, 0.95, ("good", "")),
        (0.2, 0.8, ("usable", "undercovers")),
        (0.7, 0.95, ("usable", "large_error")),
    ],
)
def test_currents_are_judged_by_a_constant_one(
    error: float, held: float, expected: tuple[str, str]
) -> None:
    results = study(current_rmse=predicted(error, held))
    assert state(results, "currents") == expected
    first = verdicts_of(results, "currents")[0]
    assert (first.value, first.zero) == (error, 1.0)
    assert first.quantity.startswith("RMSE below 2 Hz")


def test_an_error_of_currents_names_the_cut_off_of_the_study() -> None:
    results, settings = study(current_rmse=predicted(0.2)), Settings().model_dump()
    settings["lowpass"]["currents"]["cutoff_hz"] = 4.5
    other = replace(results, study={**results.study, "settings": settings})
    assert verdicts_of(other, "currents")[0].quantity.startswith("RMSE below 4.5 Hz")


@pytest.mark.parametrize(
    ("rival", "expected"),
    [(0.17, "rival_better"), (0.195, "rival_equal"), (0.21, "rival_equal"), (0.22, "")],
)
def test_currents_that_plain_least_squares_predicts_as_well_are_not_good(
    rival: float, expected: str
) -> None:
    rows = predicted(0.2) + [row | {"model": "least_squares"} for row in predicted(0.5)]
    rows[8] |= {"rmse_lowpassed": rival}
    first = verdicts_of(study(current_rmse=rows), "currents")[0]
    assert first.reason == expected
    assert first.joint == (3 if expected else 1)


def test_why_currents_are_not_judged() -> None:
    load = {"recording": "seen", "mass": 2.0, "std_error": 0.1, "configured": 0.0, "taken": "yes"}
    friction = [constant(1, 10.0)]
    resting = study({"seen": None}, current_rmse=predicted(0.2), friction=friction)
    assert state(resting, "currents")[1] == "no_motion"
    searched = [rates("seen", 2.0)]
    loaded = study(
        current_rmse=predicted(0.2), payload=[load], friction=friction, detection=searched
    )
    assert state(loaded, "currents")[1] == "loaded"
    assert verdicts_of(loaded, "alarms")[0].reason == "loaded"
    fit_alone = {**loaded.study, "recordings": loaded.study["recordings"][:1]}
    assert (
        state(judged_anew(study(friction=friction), study=fit_alone), "currents")[1] == "no_unseen"
    )
    assert state(study(), "currents")[1] == "uncalibrated"


def test_errors_of_currents_are_also_torques() -> None:
    results = study(current_rmse=predicted(0.2), friction=[constant(1, 10.0)])
    assert [one.torque for one in judged(results).judged_errors][:2] == [2.0, None]


# Force


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        (touched(4.1), ("good", "")),
        (touched(4.9), ("usable", "wide_interval")),  # of 3.9 to 5.9, more than half of the force
        (touched(5.0, mae_high=4.9), ("usable", "large_error")),
        (touched(10.0), ("do not use", "worse_than_zero")),
        ([*touched(1.0)[:1], *touched(6.0, mean_force=5.0)[1:]], ("usable", "large_error")),
        ([*touched(9.0)[:1], *touched(6.0, mean_force=5.0)[1:]], ("do not use", "worse_than_zero")),
        (touched(4.0, coverage95=0.89), ("usable", "undercovers")),
        (touched(4.0, coverage95=0.5), ("usable", "undercovers")),
        (touched(4.0, coverage95=0.49), ("do not use", "undercovers")),
        (touched(4.0, mae_low=np.nan, mae_high=np.nan), ("usable", "wide_interval")),
        (touched(2.0, **DOUBTED), ("not determined", "sensor_bias")),
        ([row | {"estimate": "static"} for row in touched(1.0)], ("usable", "uncalibrated")),
        (touched(4.0, "fitted"), ("not determined", "no_contact")),
    ],
)
def test_a_force_is_good_only_in_every_respect(rows: list[dict], expected: tuple[str, str]) -> None:
    searched = [{"recording": "pushed", "estimate": "Fmap"}]
    assert state(study(force_mae=rows, detection=searched), "force") == expected
    stopped = study(force_mae=rows, quality=[finding("stop", Found.CONTRADICTION)])
    assert state(stopped, "force") == ("do not use", "stopped")


def test_without_a_sensor_fitted_friction_is_not_denied() -> None:
    """Though no force is estimated, as where a joint never moves."""
    assert state(study(friction=[constant(1, 10.0)]), "force") == ("not determined", "no_sensor")
    assert state(study(), "force") == ("not determined", "uncalibrated")


def test_no_mean_over_axes_hides_the_worst_one() -> None:
    rows = touched(2.0) + touched(3.0, "seen", mean_force=7.0)
    rows[2] |= {"mae": 6.0, "mean_force": 15.5}
    pooled, worst, share, *_ = verdicts_of(study(force_mae=rows), "force")
    assert (pooled.rank, pooled.value) == (1, pytest.approx(np.mean([2, 2, 6, 3, 3, 3])))
    assert (worst.value, worst.axis, worst.recording) == (6.0, "z", "pushed")
    assert (share.rank, share.value, share.recording) == (4, 3.0, "seen")


def test_recordings_with_a_sure_sensor_judge_the_force() -> None:
    rows = [*touched(6.0, **DOUBTED), *touched(2.0, recording="seen")]
    first, _, doubted, *_ = verdicts_of(study(force_mae=rows), "force")
    assert (first.state, first.value) == ("good", 2.0)
    assert (doubted.rank, doubted.value, doubted.reason) == (3, 6.0, "sensor_bias")
    less = [*touched(1.0, **DOUBTED), *touched(2.0, recording="seen")]
    assert 3 not in {one.rank for one in verdicts_of(study(force_mae=less), "force")}


@pytest.mark.parametrize(("rival", "expected"), [(1.5, "better"), (1.95, "equal"), (2.2, "")])
def test_a_force_is_good_only_if_clearly_better_than_plain_least_squares(
    rival: float, expected: str
) -> None:
    """Behind our own gate it would be no rival of the gate."""
    gated = [row | {"estimate": "least_squares"} for row in touched(1.0)]
    rows = touched(2.0) + [row | {"estimate": UNGATED} for row in touched(rival)] + gated
    reason = f"rival_{expected}" if expected else ""
    assert state(study(force_mae=rows), "force")[1] == reason


# Motion


def test_motion_is_judged_with_an_imu_alone() -> None:
    assert verdicts_of(study(), "motion") == []
    row = {"recording": "seen", "estimate": "encoders", "zero_mae": 0.2}
    rows = [row | {"component": name, "mae": mae} for name, mae in (("x", 0.02), ("rz", 0.05))]
    first, most = verdicts_of(study(acceleration_mae=rows), "motion")
    assert (first.state, first.axis, first.unit) == ("good", "rz", "rad/s²")
    assert (most.axis, most.unit) == ("rz", "rad/s²")
    plain = [row | {"component": "x", "estimate": "filterpy", "mae": 0.01}]
    worse = verdicts_of(study(acceleration_mae=rows + plain), "motion")
    assert (worse[0].axis, worse[0].reason) == ("x", "rival_better")
    assert (worse[1].axis, worse[1].rank) == ("rz", 2)


# Several arms


def test_no_arm_hides_another() -> None:
    """A mean over arms of 0.8 would be usable."""
    rows = predicted(0.1) + predicted(1.5, recording="fitted")
    results = study(current_rmse=rows)
    arms = {"fitted": "ur10e", "seen": "ur5", "pushed": "ur5"}
    entries = [
        entry | {"robot": arms[entry["name"]], "role": "validate"}
        for entry in results.study["recordings"]
    ]
    both: Results = replace(results, study={**results.study, "recordings": entries})
    states = {row.arm: row.state for row in verdicts_of(both, "currents") if row.rank == 1}
    assert states == {"ur10e": "do not use", "ur5": "good", "": "do not use"}
