"""Verdicts and next steps: each rule at its borders, on tables with a known answer."""

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from tests.artefacts.documents import stated
from ur5lib.channels import CURRENT
from ur5lib.force.estimators import LEADING, UNGATED
from ur5lib.report.page.compose import shown_table
from ur5lib.report.page.document import Document, Section, Verdict, Verdicts
from ur5lib.report.page.sentences import say, speaking_of
from ur5lib.report.results import Results
from ur5lib.report.views.baseline import state
from ur5lib.report.views.contacts import (
    explained,
    false_alarms,
    felt_while_fitted,
    judge_force,
    missed_contacts,
    noticed,
    noticed_in_words,
    widest_band,
)
from ur5lib.report.views.currents import (
    EXPLAINED,
    farthest_in_time,
    friction_known,
    judge_constants,
    judge_currents,
)
from ur5lib.report.views.currents import decided as decided_currents
from ur5lib.report.views.first_screen import (
    drawn,
    findings,
    left_out,
    next_steps,
    result,
    rules,
    verdicts,
)
from ur5lib.report.views.models import arm_itself, identified, judge_links
from ur5lib.report.views.motion import judge_motion
from ur5lib.report.views.recordings import causes, judge_files, trust
from ur5lib.report.views.uses import uses
from ur5lib.study.model import Settings
from ur5lib.tidy import columns

EVERY_JOINT = "1 2 3 4 5 6"
COLUMNS = columns() | {  # and of steps
    "next_recordings": ["robot", "after", "force", "current", "mass"],
    "changes": ["study", "topic", "name", "before", "after", "differs", "changed"],
    "repetition": ["robot", "quantity", "joint", "component", "floor"],
}
ROLES = {"fitted": "fit", "seen": "validate", "pushed": "contact"}
RESTING = {"fitted": None, "seen": None, "pushed": None}


def study(moving: dict[str, Any] | None = None, **tables: list[dict[str, Any]]) -> Results:
    """A study of one recording of each role, of 1000 frames; tables not given are empty."""
    joints = dict.fromkeys(ROLES, EVERY_JOINT) | (moving or {})
    tables["recordings"] = [
        {"recording": name, "duration_s": 60.0, "frames": 1000, "moving_joints": told}
        for name, told in joints.items()
    ]
    entries = [{"name": name, "robot": "ur5", "role": role} for name, role in ROLES.items()]
    entries[0]["file"] = "wave.csv"
    return Results(
        {"recordings": entries, "settings": Settings().model_dump()},
        {name: pd.DataFrame(tables.get(name), columns=known) for name, known in COLUMNS.items()},
        Path(),
        drawn=frozenset(ROLES),
    )


def percents(sentence: str) -> list[int]:
    """The numbers of per cent in a sentence but those of a 95 % band."""
    sentence = re.sub("95 % (band|within)", "", sentence)
    return [int(x) for x in re.findall(r"(\d+) %", sentence)]


def said(verdict: Verdict) -> str:
    words = (verdict.sentence, *verdict.answers, verdict.evidence)
    return f"{verdict.state}: {' '.join(filter(None, words))}"


# States


@pytest.mark.parametrize(
    ("error", "more", "expected"),
    [
        (0.49, {}, "good"),
        (0.5, {}, "usable"),
        (0.99, {}, "usable"),
        (1.0, {}, "do not use"),
        (0.1, {"coverage": 0.9}, "good"),
        (0.1, {"coverage": 0.89}, "usable"),
        (0.1, {"tested": False}, "usable"),
        (0.1, {"plain": 0.11}, "good"),
        (0.1, {"plain": 0.1}, "usable"),
        (0.1, {"floor": 0.034}, "good"),
        (0.1, {"floor": 0.033}, "usable"),
        (2.0, {"tested": False}, "do not use"),
        (np.nan, {}, "not determined"),
    ],
)
def test_a_state_follows_from_the_error_beside_zero(
    error: float, more: dict[str, Any], expected: str
) -> None:
    assert state(error, 1.0, **more) == expected
    assert state(0.0, 0.0, **more) == "not determined"  # nothing acts


# Torque constants


def constant(joint: int, value: float, **more: Any) -> dict[str, Any]:
    row = {"robot": "ur5", "joint": joint, "parameter": "torque_constant", "value": value}
    row |= {"std_error": 0.5, "low": value - 1, "high": value + 1, "prior_share": 0.1}
    return row | {"known": 10.0, "known_std": 3.0, "determined": "yes", "contradicted": None} | more


REFUSED = {"determined": "no", "contradicted": 142.0, "prior_share": 1.0}
UNKNOWN = {"determined": "no", "prior_share": 0.8}


@pytest.mark.parametrize(
    ("second", "expected"), [({}, "good"), (UNKNOWN, "usable"), (REFUSED, "usable")]
)
def test_torque_constants_are_good_where_the_data_determine_them(
    second: dict[str, Any], expected: str
) -> None:
    rows = [constant(1, 5.0), constant(2, 11.0, **second), constant(3, 10.0)]
    verdict = judge_constants(study(friction=rows))
    assert verdict.state == expected
    few = judge_constants(study(friction=[*rows[:2], constant(3, 10.0, **UNKNOWN)]))
    assert few.state == ("usable" if expected == "good" else "not determined")
    farthest = ("joint 2", 142.0) if second is REFUSED else ("joint 1", 5.0)
    (number,) = verdict.numbers
    assert (number.place, number.value, number.baseline) == (*farthest, 10.0)


@pytest.mark.parametrize("given", [142.0, -36.6])
def test_a_refused_constant_is_the_farthest_and_named_by_the_headline(given: float) -> None:
    """Card, number and headline say alike which constants may be used."""
    rows = [constant(1, 10.0, **REFUSED | {"contradicted": given}), constant(2, 11.0)]
    results = study(friction=[*rows, constant(3, 10.0, **UNKNOWN)])
    verdict = judge_constants(results)
    assert verdict.state == "not determined"
    assert "joint 2 (1 of 3 joints), which may be used" in verdict.sentence
    (number,) = verdict.numbers
    assert (number.place, number.value, number.low) == ("joint 1", given, None)
    (headline,) = result(results)
    assert "constant of joint 2 is known within" in headline
    assert "the currents of joint 1 contradict the known torque constant." in headline


def test_a_constant_whose_fit_no_other_path_bears_out_may_not_be_used() -> None:
    """A hand-led UR5e's only constant was to be used, with which forces were refused."""
    rows = [constant(joint, 10.0) for joint in (1, 2, 3)]
    told = {"robot": "ur5", "step": "friction", "remark": "", "code": "unproven fit"}
    results = study(friction=rows, remarks=[told | {"joint": joint} for joint in (1, 2)])
    verdict = judge_constants(results)
    assert verdict.state == "not determined"
    assert "joint 3 (1 of 3 joints), which may be used" in verdict.sentence
    assert "on joints 1, 2, fits to other paths predict" in verdict.sentence
    (headline,) = result(results)
    assert "constant of joint 3 is known within" in headline


def test_the_headline_states_how_sure_its_constants_are() -> None:
    rows = [constant(1, 10.0), constant(2, 20.0), constant(3, 5.0, **UNKNOWN)]
    (headline,) = result(study(friction=rows))
    assert "of 2 joints are known within 5 % (joint 2) to 10 % (joint 1) at 95 %." in headline
    path = {"robot": "ur5", "step": "friction", "joint": 1, "remark": "", "code": "one path"}
    (headline,) = result(study(friction=rows, remarks=[path]))
    assert "no error bar is tested" in headline


def test_torque_constants_that_no_recording_determines_are_not_usable() -> None:
    rows = [constant(joint, 10.0, **UNKNOWN) for joint in (1, 2)]
    verdict = judge_constants(study(friction=rows))
    assert verdict.state == "not determined"
    assert (verdict.evidence, verdict.numbers) == ("", ())  # no constant but the known ones


@pytest.mark.parametrize(("value", "expected"), [(15.8, "good"), (15.95, "usable")])
def test_a_constant_farther_off_than_those_of_other_arms_is_not_good(
    value: float, expected: str
) -> None:
    """Of 95 % of arms, it is within 1.96 times the known one's standard deviation, here of 3."""
    verdict = judge_constants(study(friction=[constant(1, 10.0), constant(6, value)]))
    assert verdict.state == expected
    assert ("joint 6" in verdict.sentence) is (expected == "usable")


def test_a_constant_that_is_not_determined_is_not_shown_as_far_from_the_known_one() -> None:
    """The known one is used there, as the table says."""
    verdict = judge_constants(study(friction=[constant(1, 8.0), constant(2, 17.0, **UNKNOWN)]))
    assert [number.place for number in verdict.numbers] == ["joint 1"]
    assert "joint 2" not in verdict.evidence


def test_a_refused_constant_is_told_with_what_the_currents_would_give() -> None:
    rows = [constant(1, 10.0, **REFUSED), constant(2, 11.0)]
    assert "142 Nm/A" in judge_constants(study(friction=rows)).sentence


def test_a_torque_constant_that_contradicts_the_known_one_is_not_to_be_used() -> None:
    """As the next step on the same screen says, although the data determine it well."""
    rows = [constant(1, 10.0), constant(2, 19.8)]
    doubt = {"robot": "ur5", "step": "friction", "joint": 2, "remark": "contradicts"}
    results = study(friction=rows, remarks=[doubt | {"code": "unlikely constant"}])
    verdict = judge_constants(results)
    assert verdict.state == "do not use"
    assert "constant of joint 2 contradicts the known one, and forces" in verdict.sentence
    assert any("joint 2" in step for step in next_steps(results))


def test_torque_constants_that_stop_a_study_are_not_to_be_used() -> None:
    """Where recordings have stop signs, nothing is fitted that could contradict."""
    sentences = set()
    codes = {
        "contradicting constants": "contradicted",
        "contradicting recordings": "not fitted",
        "contradicting gains": "wrong side",
        "unknown side": "unknown side",
    }
    for code in codes:
        remarks = [{"robot": "ur5", "step": "stop sign", "remark": "wrong", "code": code}]
        verdict = judge_constants(study(remarks=remarks))
        assert verdict.state == "do not use"
        sentences.add(verdict.sentence)
    assert sentences == {say(f"constants.{said}") for said in codes.values()}
    assert judge_constants(study()) is None


@pytest.mark.parametrize(
    "code",
    ["unlikely constant", "current against constant", "torque against gain", EXPLAINED],
)
def test_a_contradiction_is_a_finding(code: str) -> None:
    """No fault is denied beside a card and a step that name one."""
    doubt = {"robot": "ur5", "step": "friction", "joint": 2, "remark": "contradicts", "code": code}
    stated = "Contradicts." if code == EXPLAINED else "ur5, joint 2: contradicts."
    assert findings(study(remarks=[doubt])) == [stated]


# Data quality


def finding(severity: str, name: str = "lost frames", count: int = 1, **more: Any) -> dict:
    row = {"recording": "seen", "device": "robot", "finding": name, "severity": severity}
    return row | {"count": count, "detail": "why"} | more


def test_the_worst_file_is_named() -> None:
    rows = [finding("warning", count=86), finding("warning", count=250, recording="fitted")]
    verdict = judge_files(study(quality=[*rows, finding("warning", "jitter"), finding("note")]))
    assert verdict.state == "usable"
    assert "wave.csv lost 250 of 1,000 frames" in verdict.sentence
    numbers = {number.name: number.value for number in verdict.numbers}
    assert numbers == {"stop signs": 0, "warnings": 3, "notes": 1}
    assert stated(verdict.evidence) == [3, 2, 1, 2, 3]  # of two causes


def test_the_card_counts_the_findings_that_the_tables_list() -> None:
    """A finding in several places of a recording is one: 77 notes stood above a table of 34."""
    places = [finding("note", "columns not used", place=place) for place in ("a", "b", "c")]
    results = study(quality=[*places, places[0] | {"recording": "fitted"}, finding("warning")])
    listed, numbers = causes(results).groupby("severity"), judge_files(results).numbers
    counted = {f"{name}s": rows["count"].sum() for name, rows in listed}
    assert {number.name: number.value for number in numbers} == {"stop signs": 0} | counted
    assert counted == {"notes": 2, "warnings": 1}


def test_what_could_not_be_checked_is_nobodys_gravest_finding() -> None:
    results = study(quality=[finding("note", "order not checked")])
    assert trust(results)["finding"].isna().all()


def test_one_warning_is_named_in_the_singular() -> None:
    card = judge_files(study(quality=[finding("warning")]))
    assert on_cards(card) == [{"stop signs": "0", "warning": "1"}]


def test_the_most_serious_finding_decides() -> None:
    states = {"note": "good", "warning": "usable", "error": "usable", "stop": "do not use"}
    for severity, expected in states.items():
        rows = [finding("note", "jitter"), finding(severity, "contradiction")]
        assert judge_files(study(quality=rows)).state == expected


# Link models


def torques(errors: dict[str, float], recordings: tuple[str, ...] = ("seen",)) -> list[dict]:
    return [
        {"recording": name, "motion": "measured", "model": model, "joint": joint, "mae": 2 * error,
         "mae_2hz": error, "zero_mae_2hz": 1.0}
        for name in recordings for model, error in errors.items() for joint in range(1, 7)
    ]  # fmt: skip


def test_a_link_model_is_judged_on_unseen_recordings() -> None:
    rows = torques({"A": 0.2, "B": 0.1}) + torques({"A": 0.0, "B": 0.9}, ("fitted",))
    rows += [row | {"motion": "closed_loop", "mae_2hz": 0.3} for row in rows]
    verdict = judge_links(study(torque_mae=rows))
    assert verdict.state == "good"
    assert percents(verdict.sentence) == [10]
    mean, most = verdict.numbers
    assert (mean.value, mean.place, mean.baseline) == (0.1, "joint 1", 1.0)
    assert (most.value, most.place) == (0.1, "joint 1 on seen")


@pytest.mark.parametrize("motion", ["target", "measured"])
def test_a_link_model_is_compared_with_a_model_at_a_motion(motion: str) -> None:
    """At the target motion, whose torques the controller computes, an error of zero is no news."""
    rows = [row | {"motion": motion} for row in torques({"A": 0.0001})]
    sentence = judge_links(study(torque_mae=rows)).sentence
    assert f"at the {motion} motion" in sentence
    assert "the controller's own model" in sentence


def test_a_link_model_is_said_to_be_as_far_off_as_it_is() -> None:
    """The mean over recordings on the worst joint, and the largest error on any of them."""
    rows = torques({"A": 0.4}) + torques({"A": 0.6}, ("pushed",)) + torques({"A": 0.8}, ("other",))
    rows[7] |= {"mae_2hz": 3.0, "zero_mae_2hz": 20.0}  # the largest, though a small share
    rows[12] |= {"mae_2hz": 0.95}
    verdict = judge_links(study({"other": EVERY_JOINT}, torque_mae=rows))
    assert (verdict.state, percents(verdict.sentence)) == ("usable", [65])
    mean, most = verdict.numbers
    assert (mean.value, mean.low, mean.high) == (pytest.approx(0.65), 0.4, 0.95)
    assert (most.value, most.place, most.baseline) == (3.0, "joint 2 on pushed", 20.0)


@pytest.mark.parametrize(
    ("error", "expected"), [(0.14, "good"), (0.16, "usable"), (1.0, "do not use")]
)
def test_half_of_zero_is_no_good_link_model(error: float, expected: str) -> None:
    assert judge_links(study(torque_mae=torques({"A": error}))).state == expected


def test_a_load_that_the_controller_counts_with_is_named_beside_the_link_model() -> None:
    load = finding("warning", "given load", detail="it contains 0.40 kg")
    verdict = judge_links(study(torque_mae=torques({"A": 0.05}), quality=[load]))
    assert verdict.state == "usable"
    assert "On seen, it contains 0.40 kg." in verdict.sentence


def test_the_verdict_on_links_names_the_next_model_where_that_errs_less() -> None:
    rows = torques({"A": 0.1, "B": 0.12})
    rows[8] |= {"mae_2hz": 0.05}
    sentence = judge_links(study(torque_mae=rows)).sentence
    assert "On joint 3, the model “B” errs less: 0.0500 for 0.100 Nm." in sentence.replace(
        "Model B", "the model “B”"
    )


def test_a_number_on_a_card_says_the_share_by_which_it_is_the_worst() -> None:
    (shown,) = on_cards(judge_links(study(torque_mae=torques({"A": 0.1}))))
    assert "mean absolute error below 2 Hz, joint 1 (10 % of zero baseline)" in shown


def test_loads_that_differ_from_the_declared_ones_stand_beside_those_that_agree() -> None:
    """Of recordings without contact that tell a load at all, all count, not the best one."""
    ends = {"fitted": (-0.2, 0.1), "repeated": (0.1, 0.9), "one joint": (-90.0, 90.0)}
    rows = [
        {"recording": name, "low": low, "high": high, "taken": "no"}
        for name, (low, high) in ends.items()
    ]
    load = {"recording": "seen", "low": 2.0, "high": 2.2, "taken": "yes"}
    results = study(friction=[constant(2, 10.0)], payload=[*rows, load])
    results.study["recordings"] += [
        {"name": name, "robot": "ur5", "role": "fit"} for name in ("repeated", "one joint")
    ]
    (told,) = arm_itself(replace(results, bearing={"ur5": [2]}, loads={"ur5": 2.0}))
    assert "Of 2 recordings without contact that tell a load by the currents, 1 agrees" in told
    assert "± 0.15 to 0.4 kg" in told
    assert "1 other carries an undeclared load" in told


def test_the_model_that_comes_next_stands_beside_the_best() -> None:
    rows = torques({"A": 0.3, "B": 0.1, "C": 0.2})
    body = shown_table("torque_mae.decided", study(torque_mae=rows))
    line = dict(zip(body.header, [cell.text for cell in body.rows[0]], strict=True))
    names = ("model", "error", "next model", "its error")
    assert [line[name] for name in names] == ["B", "0.100", "C", "0.200"]
    alone = shown_table("torque_mae.decided", study(torque_mae=torques({"A": 0.3})))
    assert "next model" not in alone.header


def test_the_rules_of_verdicts_are_said_by_the_constants_that_give_them(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    (told,) = rules(study())
    assert percents(told.replace("95 %", "")) == [50, 15, 90, 50, 50]
    monkeypatch.setattr("ur5lib.report.views.baseline.MIN_GOOD_SKILL", 0.7)
    assert percents(next(rules(study())))[0] == 30


def test_the_fit_recordings_alone_make_no_good_model() -> None:
    verdict = judge_links(study(torque_mae=torques({"A": 0.1}, ("fitted",))))
    assert verdict.state == "usable"
    assert "on the fit recordings alone" in verdict.sentence


def test_a_standstill_does_not_distinguish_models() -> None:
    results = study(RESTING, torque_mae=torques({"A": 0.2, "B": 0.1}))
    verdict = judge_links(results)
    assert (verdict.state, verdict.sentence) == ("not determined", say("models.at rest"))
    assert findings(results) == [say("findings.unsearched")]
    assert said(judge_links(study())) == f"not determined: {say('models.no torques')}"


def test_links_found_from_measured_torques_are_said_to_be() -> None:
    results = study(parameters=[{"robot": "ur5", "determined": "yes"}])
    assert judge_links(replace(results, placeholders=frozenset({"ur5"}))).state == "not determined"
    found = replace(results, placeholders=frozenset({"ur5"}))
    assert "measured torques, which determine 1 of their 1 base" in said(judge_links(found))
    assert "the measured torques" in " ".join(identified(found))
    assert "the controller's torques" in " ".join(identified(results))


def test_equal_models_have_no_nearest() -> None:
    assert findings(study(torque_mae=torques({"A": 0.1, "B": 0.1}))) == [say("models.same")]


# Currents


def predicted(
    error: float, held: float = 0.95, recording: str = "seen", factor: float = 1.0
) -> list[dict]:
    """Errors beside a constant current's of 1 A, on every joint."""
    row = {"model": "fitted", "recording": recording, "rmse_lowpassed": error, "coverage95": held}
    row |= {"band_factor95": factor}
    return [row | {"joint": joint, "r2": 1 - error**2} for joint in range(1, 7)]


@pytest.mark.parametrize(
    ("error", "held", "expected", "narrow"),
    [(0.2, 0.95, "good", False), (0.2, 0.8, "usable", True), (0.7, 0.95, "usable", False)],
)
def test_currents_are_judged_beside_a_constant(
    error: float, held: float, expected: str, narrow: bool
) -> None:
    verdict = judge_currents(study(current_rmse=predicted(error, held)))
    assert (verdict.state, "too narrow" in verdict.sentence) == (expected, narrow)
    assert percents(verdict.sentence) == [round(100 * error)]
    assert f"{error:.3f} A; a constant current: 1.00 A" in verdict.evidence


@pytest.mark.parametrize(
    ("held", "factor", "said"),
    [(0.8, 1.52, "too narrow, by a factor of up to 1.5"), (1.0, 0.4, "by a factor of 2.5 or more")],
)
def test_currents_say_by_which_factor_a_band_is_too_narrow_or_too_wide(
    held: float, factor: float, said: str
) -> None:
    rows = predicted(0.2, held, factor=factor)
    rows[0] |= {"band_factor95": 0.2}
    verdict = judge_currents(study(current_rmse=rows))
    assert said in verdict.sentence
    assert f"0.20\u00a0to\u00a0{factor:.2f} times the band" in verdict.evidence


def test_currents_say_how_well_friction_is_known() -> None:
    """Within 20 % on joint 1; not even the sign of joint 2's, nor that of joint 3, by the prior."""
    known = {"robot": "ur5", "parameter": "coulomb", "value": 5.0, "prior_share": 0.1}
    ends = {1: (4.0, 6.0, "yes"), 2: (-1.0, 11.0, "yes"), 3: (4.0, 6.0, "no")}
    rows = [
        known | {"joint": joint, "low": low, "high": high, "determined": told}
        for joint, (low, high, told) in ends.items()
    ]
    (told,) = friction_known(study(friction=rows))
    assert "of joint 1 is known within 20 %" in told
    assert "joints 2, 3 is not determined" in told


def test_errors_of_currents_are_also_told_as_torques() -> None:
    rows, constant = predicted(0.2), {"robot": "ur5", "parameter": "torque_constant", "value": 10.0}
    results = study(current_rmse=rows, friction=[constant | {"joint": 1}])
    assert "the RMSE is up to 2 Nm (joint 1)." in said(judge_currents(results))
    assert [*decided_currents(results)["torque"].dropna()] == [2.0]
    unknown = decided_currents(study(current_rmse=rows))["torque"]
    assert unknown.isna().all()


def test_currents_name_the_largest_error_and_the_least_band_by_themselves() -> None:
    """No mean over recordings hides the one on which a band holds least."""
    rows = predicted(0.2) + predicted(0.2, recording="fitted")
    rows += [row | {"model": "linear", "rmse_lowpassed": 3.0, "coverage95": 0.1} for row in rows]
    rows[8] |= {"coverage95": 0.86}
    rows[3] |= {"rmse_lowpassed": 2.0, "r2": 1 - 0.1**2}
    results = study(current_rmse=rows)
    roles = [entry | {"role": "validate"} for entry in results.study["recordings"]]
    verdict = judge_currents(replace(results, study=results.study | {"recordings": roles}))
    assert verdict.state == "usable"
    _, most, held = verdict.numbers
    assert (most.value, most.place) == (2.0, "joint 4 on seen")
    assert (held.value, held.place) == (86, "joint 3 on fitted")


def test_an_error_of_currents_names_the_cut_off_of_the_study() -> None:
    results, settings = study(current_rmse=predicted(0.2)), Settings().model_dump()
    assert judge_currents(results).numbers[0].name == "RMSE below 2 Hz"
    settings["lowpass"]["currents"]["cutoff_hz"] = 4.5
    other = replace(results, study=results.study | {"settings": settings})
    assert judge_currents(other).numbers[0].name == "RMSE below 4.5 Hz"


@pytest.mark.parametrize(("held", "wide"), [(0.985, False), (0.995, True)])
def test_bands_of_currents_that_hold_more_than_they_state_are_called_wide(
    held: float, wide: bool
) -> None:
    verdict = judge_currents(study(current_rmse=predicted(0.2, held)))
    assert verdict.state == "good"
    assert ("too wide" in verdict.sentence) is wide


@pytest.mark.parametrize(
    ("rival", "expected"), [(0.17, "usable"), (0.195, "usable"), (0.21, "usable"), (0.22, "good")]
)
def test_currents_that_plain_least_squares_predicts_better_are_not_good(
    rival: float, expected: str
) -> None:
    rows = predicted(0.2) + [row | {"model": "least_squares"} for row in predicted(0.5)]
    rows[8] |= {"rmse_lowpassed": rival}
    verdict = judge_currents(study(current_rmse=rows))
    assert verdict.state == expected
    told = "On joint 3, plain least squares errs less: 0.170 for 0.200 A."
    assert (told in verdict.sentence) is (rival == 0.17)
    assert ("On joint 3, plain least squares does about" in verdict.sentence) is (
        0.19 < rival < 0.22
    )


def test_joints_at_rest_and_loaded_recordings_judge_no_currents() -> None:
    load = {"recording": "seen", "mass": 2.0, "std_error": 0.1, "configured": 0.0, "taken": "yes"}
    friction = [{"joint": 1, "parameter": "coulomb"}]
    told = "No validate recording tests the predicted currents: none moves without a load."
    for results in (
        study({"seen": None}, current_rmse=predicted(0.2), friction=friction),
        study(current_rmse=predicted(0.2), payload=[load], friction=friction),
    ):
        assert said(judge_currents(results)).startswith(f"not determined: {told}")


# Force


def touched(mae: float, recording: str = "pushed", **more: float) -> list[dict]:
    row = {"recording": recording, "kind": "compensated", "estimate": "Fmap", "during": "contact"}
    row |= {"mae": mae, "mae_low": 0.8 * mae, "mae_high": 1.2 * mae, "mean_force": 10.0}
    return [row | {"coverage95": 0.95, **more, "component": f"F{axis}"} for axis in "xyz"]


def test_the_force_is_judged_where_it_is_worst() -> None:
    rows = touched(2.0) + touched(4.0, "seen") + touched(9.0, "fitted")
    verdict = judge_force(study(force_mae=rows))
    assert verdict.state == "good"
    error, share, held = verdict.numbers
    assert (error.value, error.baseline, error.low, error.high) == (4.0, 10.0, 3.2, 4.8)
    assert error.place == "seen, along x, in contact"
    assert (share.value, share.baseline, held.value) == (4.0, 10.0, 95)


def test_no_mean_over_axes_hides_the_worst_one() -> None:
    """The largest error, the least share in a band: each of its own axis and recording."""
    rows = touched(2.0) + touched(3.0, "seen", mean_force=7.0)
    rows[2] |= {"mae": 6.0, "mean_force": 15.5}
    rows[4] |= {"coverage95": 0.83}
    verdict = judge_force(study(force_mae=rows))
    assert verdict.state == "usable"
    error, share, held = verdict.numbers
    assert (error.value, error.place) == (6.0, "pushed, along z, in contact")
    assert (share.value, share.place) == (3.0, "seen, mean over x, y, z, in contact")
    assert (held.value, held.place) == (83, "seen, along y, in contact")


@pytest.mark.parametrize(
    ("rows", "expected"),
    [
        (touched(4.1), "good"),
        (touched(4.9), "usable"),  # or more than half of the force, by its interval of 3.9 to 5.9
        (touched(5.0), "usable"),
        (touched(10.0), "do not use"),
        ([*touched(1.0)[:1], *touched(6.0, mean_force=5.0)[1:]], "do not use"),  # along one axis
        (touched(4.0, coverage95=0.89), "usable"),
        (touched(4.0, mae_low=np.nan, mae_high=np.nan), "usable"),
        (touched(4.0, "fitted"), "not determined"),
    ],
)
def test_a_force_is_good_only_in_every_respect(rows: list[dict], expected: str) -> None:
    searched = [{"recording": "pushed", "estimate": "Fmap"}]
    assert judge_force(study(force_mae=rows, detection=searched)).state == expected
    stopped = study(force_mae=rows, quality=[finding("stop", "contradiction")])
    assert judge_force(stopped).state == "do not use"
    broken = study(force_mae=rows, quality=[finding("stop", "unreadable")])
    assert judge_force(broken) == judge_force(study(force_mae=rows))


def test_a_force_beside_a_doubted_sensor_is_not_good() -> None:
    """The next step asks for the sensor's bias, so that the card cannot rely on it."""
    doubt = finding("warning", "offset", device="force", recording="pushed")
    verdict = judge_force(study(force_mae=touched(2.0), quality=[doubt]))
    assert verdict.state == "usable"
    assert "bias is uncertain on pushed" in verdict.evidence
    elsewhere = study(force_mae=touched(2.0), quality=[doubt | {"recording": "seen"}])
    assert judge_force(elsewhere).state == "good"


def test_recordings_with_a_sure_sensor_judge_the_force() -> None:
    doubt = finding("warning", "offset", device="force", recording="pushed")
    rows = [*touched(10.0), *touched(2.0, recording="seen")]
    assert judge_force(study(force_mae=rows)).state == "do not use"
    verdict = judge_force(study(force_mae=rows, quality=[doubt]))
    assert verdict.state == "good"
    assert "bias is uncertain on pushed, which do not count here" in verdict.evidence
    for doubts in ([], [doubt]):
        results = study(force_mae=rows, quality=doubts)
        for sentence in (judge_force(results).sentence, *result(results)):
            assert ("bias" in sentence) is bool(doubts)


def on_cards(*cards: Verdict) -> list[dict[str, str]]:
    """The names and texts of the numbers that cards show, one mapping a card."""
    document = Document("", "", [Section("", [Verdicts([*cards])])])
    (block,) = document.as_data()["sections"][0]["blocks"]
    return [{n["name"]: n["text"] for n in one["numbers"]} for one in block["verdicts"]]


def test_a_number_is_alike_on_card_sentence_evidence_and_headline() -> None:
    results = study(force_mae=touched(3.3891), current_rmse=predicted(0.04031))
    force, current = judge_force(results), judge_currents(results)
    (of_force, *_), (of_current, *_) = (card.values() for card in on_cards(force, current))
    (headline,) = result(results)
    for sentence in (force.sentence, force.evidence, headline):
        assert of_force in sentence
    assert of_current in current.evidence


def test_card_and_headline_state_the_worst_mean_error_with_its_interval_and_rivals() -> None:
    """Also what is left out for the sensor's bias, and plain least squares where that errs less."""
    doubt = finding("warning", "offset", device="force", recording="pushed")
    rows = [*touched(6.0), *touched(4.0, recording="seen")]
    plain = [row | {"estimate": UNGATED, "mae": 3.0} for row in touched(4.0, recording="seen")]
    results = study(force_mae=[*rows, *plain], quality=[doubt])
    for told in (judge_force(results).sentence, *result(results)):
        told = told.replace("\u00a0", " ")
        for part in ("mean error", "4.00 N", "(95 %: 3.2 to 4.8)", "6.0 N", "3.0 N"):
            assert part in told
    (headline,) = result(study(force_mae=touched(4.0)))
    assert "least squares" not in headline
    assert "uncertain" not in headline


def test_an_alarm_at_an_undeclared_load_is_not_called_false() -> None:
    about = {"recording": "seen", "estimate": "Fmap", "alarms_per_min": 1.0}
    load = {"recording": "seen", "mass": 2.0, "taken": "yes"}
    assert noticed(study(detection=[about]))["false_alarms_per_min"].item() == 1.0
    loaded = noticed(study(detection=[about], payload=[load]))
    assert loaded["alarms_per_min"].item() == 1.0
    assert loaded["false_alarms_per_min"].isna().all()


def test_without_a_sensor_contacts_are_plausible_only() -> None:
    searched = [{"recording": name, "estimate": "Fmap", "alarms_per_min": 0.0} for name in ROLES]
    contact = {"recording": "pushed", "estimate": "Fmap", "kind": "contact"}
    told = said(judge_force(study(detection=searched, contacts=[contact] * 4)))
    assert told == (
        "not determined: No force sensor was recorded: contacts are plausible only, their size and "
        "its band are untested, and missed ones are not counted. False alarms: 0 in 1.0 min of "
        "validate recordings without contact, at most 3 a minute (95 %). Contacts reported: 4, on "
        "1 of 1 recordings. While no contact is found, the band is that of an untouched arm. False "
        "alarms in 1.0 minutes of validate recordings without an undeclared load: 0, that is at "
        "most 3 a minute (95 %); no day without a fit recording tests them."
    )


def test_a_wrench_that_is_not_used_is_named() -> None:
    searched = [{"recording": name, "estimate": "Fmap", "alarms_per_min": 0.0} for name in ROLES]
    unused = {"recording": "pushed", "taken_for": "nothing", "reason": "no effort tells its frame"}
    told = [
        said(judge_force(study(detection=searched, account=[unused | {"subject": subject}])))
        for subject in ("/wrench/force/x … /wrench/force/z", "tool_mode")
    ]
    assert ["wrench in the files of pushed" in one for one in told] == [True, False]


@pytest.mark.parametrize(
    ("recording", "told"),
    [
        (
            "seen",
            "False alarms in 1.0 minutes of validate recordings without an undeclared load: 2, "
            "that is at most 6.3 a minute (95 %); no day without a fit recording tests them; the "
            "live estimate, which can tell in 75 % of the time, raises 3.",
        ),
        ("fitted", "No validate recording without an undeclared load shows how many alarms"),
    ],
)
def test_false_alarms_stand_on_the_card_of_force(recording: str, told: str) -> None:
    rates = {"alarms_per_min": 2.0, "causal_alarms_per_min": 3.0, "causal_unknown": 0.25}
    searched = [{"recording": recording, "estimate": "Fmap", **rates}]
    assert told in judge_force(study(force_mae=touched(4.0), detection=searched)).evidence


def test_false_alarms_are_counted_by_the_minute_not_by_the_recording() -> None:
    """A short recording without alarms does not halve those of a long one; classes of contacts
    are no further recordings.
    """
    results = study()
    lengths = {"fitted": 30.0, "seen": 90.0}
    table = results.tables["recordings"]
    table["duration_s"] = table["recording"].map(lengths).fillna(60.0)
    rates = {"estimate": "Fmap", "alarms_per_min": 4.0, "causal_alarms_per_min": 2.0}
    rates |= {"contacts": 1, "found": 1, "merged": 0, "causal_found": 1, "causal_merged": 0}
    rates |= {"causal_unknown": 0.0, "false_alarms_per_min": 0.0}
    rates |= {"causal_false_alarms_per_min": 0.0}
    still = rates | {"alarms_per_min": 0.0, "causal_alarms_per_min": 0.0, "recording": "fitted"}
    rows = [rates | {"recording": "seen", "force_class_n": force} for force in (3.0, 5.0)]
    tables = {**results.tables, "detection": pd.DataFrame([*rows, still])}
    roles = [entry | {"role": "validate"} for entry in results.study["recordings"]]
    judged = Results({"recordings": roles}, tables, Path())
    evidence = judge_force(judged).evidence
    assert "in 2.0 minutes" in evidence
    assert "load: 6, that is at most" in evidence
    assert "which can tell in 100 % of the time, raises 3." in evidence


def test_causal_alarms_are_stated_on_dates_that_no_fit_has_seen() -> None:
    """Of 4 minutes, that of the fit's own date counts for all alone; the farthest stands apart."""
    days = {"fitted": "2020-01-17", "same": "2020-01-17", "near": "2020-01-22", "far": "2019-12-23"}
    lengths = {"fitted": 60.0, "same": 60.0, "near": 120.0, "far": 60.0}
    entries = [
        {"name": name, "robot": "ur5", "date": day, "role": "validate" if day else ""}
        for name, day in days.items()
    ]
    entries[0]["role"] = "fit"
    rates = {"fitted": 0.0, "same": 0.0, "near": 1.0, "far": 4.0}
    found = [
        {"recording": name, "estimate": "Fmap", "alarms_per_min": 0.0, "causal_alarms_per_min": own}
        for name, own in rates.items()
    ]
    tables = study(force_mae=touched(4.0)).tables | {
        "detection": pd.DataFrame(found).assign(force_class_n=np.nan, causal_unknown=0.0),
        "recordings": pd.DataFrame(
            [{"recording": name, "duration_s": own} for name, own in lengths.items()]
        ),
    }
    judged = Results({"recordings": entries}, tables, Path())
    assert [*false_alarms(judged).values()] == [
        (alarms, minutes, 0.0)
        for alarms, minutes in [(0, 4.0), (6, 4.0), (0, 3.0), (6, 3.0), (4, 1.0)]
    ]
    told = " ".join(noticed_in_words(judged))
    assert "on days without a fit recording, 0 in 3.0 minutes, at most 1 a minute" in told
    assert (
        "100 % of the time, raises 6, of these on days without a fit recording 6, at most 3.9"
        in told
    )
    assert "on the farthest 4 in 1.0 minutes" in told


def test_what_the_band_holds_for_while_no_contact_is_found_stands_on_the_card() -> None:
    missed = [row | {"during": "missed", "coverage95": 0.62} for row in touched(15.0)]
    missed[1] |= {"coverage95": 0.43}
    searched = [{"recording": "pushed", "estimate": "Fmap", "alarms_per_min": 0.0}]
    card = judge_force(study(force_mae=touched(4.0) + missed, detection=searched)).evidence
    assert "is that of an untouched arm" in card
    assert "lay in it for 43 % of the time along y on pushed" in card


# No recording to fit

SENSED = {"recording": "pushed", "largest_force_n": 106.0, "at_s": 3.0}
SENSED |= {"share_in_contact": 0.4, "contacts": 5}


def test_a_contact_beside_a_sensor_is_not_denied() -> None:
    """Neither that there is a contact, nor that there is a sensor, nor is either asked for."""
    results = study(RESTING, sensed=[SENSED])
    (finding,) = findings(results)
    assert re.findall(r"\d[\d.]*", finding) == ["106.0", "40"]
    assert not [text for text in left_out(results) if "force sensor" in text]
    assert not [text for text in next_steps(results) if "force sensor" in text]
    card = judge_force(results)
    assert (card.state, "106.0 N" in card.evidence) == ("not determined", True)
    assert drawn(results, "forces") == ["pushed"]


def test_contacts_in_a_recording_to_fit_are_told() -> None:
    """Fitted as friction, they widen bands and raise the threshold of alarms."""
    contact = {"estimate": "Fmap", "kind": "contact", "recording": "fitted"}
    results = study(contacts=[contact])
    assert findings(results) == [say("findings.felt", name="fitted")]
    assert [text for text in next_steps(results) if "role is fit" in text]
    assert not felt_while_fitted(study(contacts=[contact | {"recording": "pushed"}]))


def test_alarms_at_the_usual_rate_do_not_doubt_a_role() -> None:
    """Of sixty recordings with an alarm each, none is touched; one with six more is."""
    names = [f"free_{k}" for k in range(60)]
    results = study()
    entries = [{"name": name, "robot": "ur5", "role": "fit"} for name in names]
    lengths = pd.DataFrame({"recording": names, "duration_s": 60.0})
    alarm = {"estimate": "Fmap", "kind": "contact"}
    for further, doubted in ((0, []), (6, ["free_7"])):
        contacts = pd.DataFrame(
            [alarm | {"recording": name} for name in names + ["free_7"] * further]
        )
        tables = results.tables | {"recordings": lengths, "contacts": contacts}
        assert (
            felt_while_fitted(replace(results, study={"recordings": entries}, tables=tables))
            == doubted
        )


def test_without_a_search_no_contact_is_denied() -> None:
    assert findings(study(RESTING)) == [say("findings.unsearched")]
    quiet = SENSED | {"largest_force_n": 2.0, "contacts": 0, "share_in_contact": 0.0}
    assert [text for text in next_steps(study(sensed=[quiet])) if "force sensor" in text]


def test_a_search_of_the_estimates_alone_denies_contacts() -> None:
    searched = [{"recording": "seen", "estimate": LEADING, "alarms_per_min": 0.0}]
    assert findings(study(RESTING, detection=searched)) == [say("findings.none")]


@pytest.mark.parametrize(("rival", "expected"), [(1.5, "usable"), (1.9, "usable"), (2.2, "good")])
def test_a_force_is_good_only_if_clearly_better_than_plain_least_squares(
    rival: float, expected: str
) -> None:
    """Behind our own gate it would be no rival of the gate."""
    gated = [row | {"estimate": "least_squares"} for row in touched(1.0)]
    rows = touched(2.0) + [row | {"estimate": UNGATED} for row in touched(rival)] + gated
    verdict = judge_force(study(force_mae=rows))
    assert verdict.state == expected
    told = "On pushed, plain least squares errs less (means over x, y, z): 1.50 for 2.00 N."
    assert (told in verdict.sentence) is (rival == 1.5)
    only = "only " * (rival < 2)
    told = f"zero errs by 10.0 N, plain least squares by {only}{rival:.1f} N"
    assert told in verdict.sentence


@pytest.mark.parametrize(("floor", "expected"), [(0.7, "good"), (0.6, "usable")])
def test_good_is_at_most_three_times_what_repetition_leaves(floor: float, expected: str) -> None:
    arm = {"robot": "ur5", "floor": floor}
    currents = [arm | {"quantity": "current", "joint": j, "floor": floor / 10} for j in (1, 2)]
    repeated = [arm | {"quantity": "force", "component": "Fy"}, *currents]
    results = study(force_mae=touched(2.0), current_rmse=predicted(0.2), repetition=repeated)
    for card in (judge_force(results), judge_currents(results)):
        assert card.state == expected
        assert ("3.3 times the repeatability" in card.sentence) is (expected != "good")


@pytest.mark.parametrize(("zero", "expected"), [(0.4, "good"), (0.93, "do not use")])
def test_a_force_whose_band_does_not_tell_contact_from_none_is_of_no_use(
    zero: float, expected: str
) -> None:
    rows = [row | {"zero_in_band95": zero} for row in touched(2.0)]
    verdict = judge_force(study(force_mae=rows))
    assert verdict.state == expected
    assert ("all hold zero for 93 %" in verdict.sentence) is (expected == "do not use")


def test_the_factor_of_a_band_of_forces_is_named() -> None:
    rows = touched(2.0)
    rows[0] |= {"coverage95": 0.7, "band_factor95": 1.8}
    rows[2] |= {"band_factor95": 0.25}
    told = judge_force(study(force_mae=rows)).evidence
    assert "narrow by a factor of 1.8; along z on pushed, it is too wide by a factor of 4.0" in told


def test_the_estimate_without_a_fit_is_never_called_good() -> None:
    rows = [row | {"estimate": "static"} for row in touched(1.0)]
    card = judge_force(study(force_mae=rows, sensed=[SENSED]))
    assert (card.state, card.numbers[0].value) == ("usable", 1.0)
    assert "not calibrated" in card.evidence
    assert judge_force(study(force_mae=touched(1.0))).state == "good"
    rows = [row | {"estimate": "controller_currents"} for row in rows]
    card = judge_force(study(force_mae=rows, sensed=[SENSED]))
    assert "error of the force by the controller, from currents is" in card.sentence


def test_the_card_of_the_force_counts_missed_contacts_and_false_alarms() -> None:
    """Of contacts of 5 N, of quiet validate recordings; 3.0 is the Poisson limit of none seen."""
    known = {"estimate": "Fmap", "alarms_per_min": 0.0, "causal_alarms_per_min": 1.0}
    known |= {
        "causal_unknown": 0.0,
        "false_alarms_per_min": 0.0,
        "causal_false_alarms_per_min": 2.0,
    }
    counts = {"force_class_n": 5.0, "contacts": 4, "found": 2, "merged": 1, "causal_found": 1}
    rows = [
        known | counts | {"recording": "seen"},
        known | counts | {"recording": "pushed"},
        known | counts | {"recording": "pushed", "force_class_n": 20.0, "found": 4},
    ]
    sensed = [
        {"recording": "pushed", "estimate": "Fmap", "component": "norm", "peak": peak}
        | {"start_s": 10.0 * k, "end_s": 10.0 * k + 1}
        for k, peak in enumerate((20.0, 21.0, 35.0, 25.0))
    ]
    alarms = [
        {"recording": "pushed", "estimate": "Fmap", "start_s": start, "end_s": start + length}
        for start, length in ((20.0, 11.0), (0.0, 1.0))
    ]
    tables = {"contact_errors": sensed, "contacts": alarms, "force_mae": touched(2.0)}
    card = judge_force(study(detection=rows, **tables))
    numbers = {number.name: (number.value, number.unit) for number in card.numbers}
    assert numbers["missed contacts"] == (2, "of 8")
    assert numbers["false alarms without contact"] == (0, "in 1.0 min")
    told = said(card)
    assert "Of 8 contacts from 5 N on, 2 are missed (up to 21 N), live 6; " in told
    assert "; alarms beside them: 0, live 4" in told
    assert (
        "False alarms: 0 in 1.0 min of validate recordings without contact, at most 3 a minute"
        in card.answers[-1]
    )
    assert "live 1, at most 4.7, unable to judge 0" in card.answers[-1]
    assert "in 1.0 minutes" in told
    assert ": 0, that is at most 3 a minute (95 %); no day without a fit recording" in told
    assert "in 100 % of the time, raises 1." in told


def test_the_card_of_the_force_names_a_sensor_that_tells_no_peak() -> None:
    """Where a contact saturates it, not where it saturates elsewhere."""
    peak = {"recording": "seen", "estimate": "Fmap", "component": "norm", "peak": 20.0}
    peak |= {"start_s": 0.0, "end_s": 1.0, "peak_error": None}
    counts = {"recording": "seen", "estimate": "Fmap", "force_class_n": 5.0, "contacts": 1}
    limit = finding("warning", "saturation")
    for recording, expected in (("seen", True), ("pushed", False)):
        limits = [limit | {"recording": recording, "device": "force"}]
        results = study(contact_errors=[peak], detection=[counts | {"found": 1}], quality=limits)
        (told, *_) = missed_contacts(results)
        assert ("on seen, the sensor saturates" in told) == expected


def test_a_drift_of_the_sensor_stands_where_its_run_determines_it() -> None:
    """Within 1 N/min along x and y, not along z; elsewhere, nothing does."""
    parts = dict.fromkeys(("mae_missed", "mae_shut", "mae_gain"), 0.0)
    known = SENSED | {f"bias_{axis}": 1.0 for axis in "xyz"}
    known |= {f"bias_std_{axis}": 0.01 for axis in "xyz"}
    drifts = {"drift_x": 0.3, "drift_y": -0.2, "drift_z": 5.0}
    drifts |= {"drift_std_x": 0.1, "drift_std_y": 0.4, "drift_std_z": 0.6}
    rows = [known | drifts | {"recording": "pushed"}, known | {"recording": "seen"}]
    errors = touched(2.0, **parts) + touched(2.0, "seen", **parts)
    body = shown_table("force_mae.split", study(force_mae=errors, sensed=rows))
    told = {line[0].text: (line[-2].text, line[-1].text) for line in body.rows}
    assert told["pushed"] == ("0.30, −0.20, –", "0.40")
    assert "0" not in "".join(told["seen"])


def test_alarms_on_days_without_a_fit_are_counted_by_themselves() -> None:
    row = {"recording": "seen", "estimate": "Fmap", "alarms_per_min": 2.0}
    results = study(detection=[row])
    for day, expected in (("2026-03-01", None), ("2026-03-02", (2, 1.0, 0.0))):
        dates = {"fitted": "2026-03-01", "seen": day}
        entries = [one | {"date": dates.get(one["name"])} for one in results.study["recordings"]]
        dated = replace(results, study={**results.study, "recordings": entries})
        assert false_alarms(dated)["other"] == expected


def test_the_limit_of_false_alarms_is_that_of_the_days_that_tell_most_against_them() -> None:
    """One alarm in a minute of another day; one in two minutes of both days."""
    rows = [
        {"recording": name, "estimate": "Fmap", "alarms_per_min": alarms}
        for name, alarms in (("seen", 1.0), ("again", 0.0))
    ]
    results = study(detection=rows)
    dates = {"fitted": "2026-03-01", "again": "2026-03-01", "seen": "2026-03-02"}
    (seen,) = (entry for entry in results.study["recordings"] if entry["name"] == "seen")
    entries = [*results.study["recordings"], seen | {"name": "again"}]
    entries = [entry | {"date": dates.get(entry["name"])} for entry in entries]
    listed = results.tables["recordings"]
    again = listed[listed["recording"] == "seen"].assign(recording="again")
    tables = {**results.tables, "recordings": pd.concat([listed, again])}
    results = replace(results, study={**results.study, "recordings": entries}, tables=tables)
    limit = {number.name: number for number in judge_force(results).numbers}[
        "false alarms, upper limit"
    ]
    assert (round(limit.value, 1), limit.place) == (4.7, "95 %, on days without a fit recording")


# Motion


def test_motion_is_judged_beside_an_imu_alone() -> None:
    assert judge_motion(study()) is None
    row = {"recording": "seen", "estimate": "encoders", "zero_mae": 0.2}
    rows = [row | {"component": name, "mae": mae} for name, mae in (("x", 0.02), ("rz", 0.05))]
    verdict = judge_motion(study(acceleration_mae=rows))
    assert (verdict.state, percents(verdict.sentence)) == ("good", [25])
    assert (verdict.numbers[0].value, verdict.numbers[0].place) == (0.05, "rz")
    rows[0] |= {"mae": 0.06, "zero_mae": 0.6}  # larger, in another unit
    assert judge_motion(study(acceleration_mae=rows)).numbers[1].place == "rz on seen"
    of_unit = [*rows, row | {"component": "rx", "mae": 0.09, "zero_mae": 0.9}]
    assert judge_motion(study(acceleration_mae=of_unit)).numbers[1].place == "rx on seen"
    plain = [row | {"component": "x", "estimate": "filterpy", "mae": 0.03}]
    card = judge_motion(study(acceleration_mae=rows + plain))
    assert (card.state, "On x, filterpy's plain smoother errs less" in card.sentence) == (
        "usable",
        True,
    )
    nothing = [row | {"component": "x", "mae": 0.551, "zero_mae": 0.552}]
    assert percents(judge_motion(study(acceleration_mae=nothing)).sentence) == [100]


# Several arms


def of_two_arms(**tables: list[dict[str, Any]]) -> Results:
    """A study with two validate recordings: seen of a ur5, fitted of a ur10e."""
    results = study(**tables)
    arms = {"fitted": "ur10e", "seen": "ur5", "pushed": "ur5"}
    entries = [
        entry | {"robot": arms[entry["name"]], "role": "validate"}
        for entry in results.study["recordings"]
    ]
    return replace(results, study=results.study | {"recordings": entries})


def test_no_arm_hides_another() -> None:
    """A mean over arms of 0.8 would be usable."""
    rows = predicted(0.1) + predicted(1.5, recording="fitted")
    results = of_two_arms(
        current_rmse=[row | {"r2": 1 - row["rmse_lowpassed"] ** 2} for row in rows]
    )
    (card,) = [one for one in verdicts(results) if one.topic == "Friction and currents"]
    assert card.state == "do not use"
    assert percents(card.sentence) == [150, 10]
    assert card.sentence.startswith("ur10e: ")
    assert [number.place for number in card.numbers][:1] == ["ur10e, joint 1"]


def test_an_arm_of_which_nothing_is_determined_is_told_beside_others() -> None:
    rows = [constant(1, 10.0), constant(1, 10.0, **UNKNOWN) | {"robot": "ur10e"}]
    (card,) = [one for one in verdicts(of_two_arms(friction=rows)) if "constants" in one.topic]
    assert card.state == "usable"
    assert "ur10e: The recordings determine no torque constant; that of joint 1" in card.sentence


# What repetition alone leaves


def test_what_repetition_leaves_stands_beside_the_error_it_limits() -> None:
    left = {"current": 0.05, "torque": 0.001}
    rows = [
        {"robot": "ur5", "quantity": quantity, "joint": joint, "floor": joint * floor}
        for quantity, floor in left.items()
        for joint in range(1, 7)
    ] + [{"robot": "ur5", "quantity": "force", "component": "Fx", "floor": 1.5}]
    results = study(
        current_rmse=predicted(0.2), torque_mae=torques({"A": 0.1}), force_mae=touched(2.0),
        repetition=rows,
    )  # fmt: skip
    cards = [judge(results) for judge in (judge_currents, judge_links, judge_force)]
    assert [card.numbers[0].floor for card in cards] == [0.05, 0.001, 1.5]
    assert all("repeatability: " in card.evidence for card in cards)
    without = [judge(study(current_rmse=predicted(0.2))) for judge in (judge_currents,)]
    assert "repeatability" not in said(without[0])
    errors = shown_table("current_rmse.decided", results)
    at = errors.header.index("repeatability")
    assert [row[at].text for row in errors.rows][:2] == ["0.0500", "0.100"]


def test_whether_a_constant_may_be_used_is_said_by_joint() -> None:
    rows = [
        constant(1, 11.0),
        constant(2, 17.0),
        constant(3, 10.0, **UNKNOWN),
        constant(4, 10.0, **REFUSED),
        constant(5, 30.0),
    ]
    unlikely = {"robot": "ur5", "joint": 5, "code": "unlikely constant", "step": "friction"}
    results = study(friction=rows, remarks=[unlikely])
    used = [row[1].text for row in shown_table("friction.by_joint", results).rows]
    assert [text.split(":")[0].split(",")[0] for text in used] == [
        *("yes", "yes", "not determined", "the known one", "no"),
    ]
    assert "far from" in used[1]


def test_contacts_without_an_alarm_of_their_own_are_named() -> None:
    """One alarm over two contacts finds one of them, the longer."""
    about = {"recording": "pushed", "estimate": "Fmap"}
    spans = [(1.0, 2.0, 30.0), (3.0, 5.0, 20.0), (8.0, 9.0, 7.0)]
    sensed = [
        about | {"component": "norm", "start_s": start, "end_s": end, "peak": peak}
        for start, end, peak in spans
    ]
    alarm = {
        "start_s": 1.0,
        "end_s": 5.0,
        "peak_s": 4.0,
        "Fx_std": 1.0,
        "Fy_std": 5.0,
        "Fz_std": 2.0,
        "posture_deg": "0.2 -90.0 90.0",
    }
    results = study(
        detection=[about | {"alarms_per_min": 1.0}], contact_errors=sensed, contacts=[about | alarm]
    )
    (row,) = noticed(results).to_dict("records")
    assert (row["found"], row["contacts"]) == (1, 3)
    assert (row["merged"], row["missed"]) == ([1.0], [8.0])
    assert (row["weakest"], row["strongest"]) == (20.0, 7.0)
    assert (row["band"], row["axis"], row["band_s"]) == (9.8, "y", 4.0)
    cells = shown_table("detection.noticed", results)
    assert "± 10 along y at 4.0 s" in [cell.text for cell in cells.rows[0]]
    (told,) = widest_band(results)
    assert "pushed at 4.0 s, with the joints at 0, −90, 90°" in told.replace("\u00a0", " ")


def test_unknown_links_are_the_first_to_record() -> None:
    unknown = replace(study(), placeholders=frozenset({"ur5"}))
    assert next_steps(unknown)[0] == say("steps.unknown links", robot="ur5", why="")
    why = {"robot": "ur5", "step": "identification", "remark": "no bodies", "code": "no bodies"}
    told = unknown.tables | {"remarks": pd.DataFrame([why])}
    assert next_steps(replace(unknown, tables=told))[0].endswith("computed: no bodies.")
    found = {"parameters": pd.DataFrame([{"robot": "ur5"}])}
    assert "links are unknown" not in " ".join(
        next_steps(replace(unknown, tables=unknown.tables | found))
    )


def test_every_alarm_on_a_recording_without_contact_is_false() -> None:
    told = {"estimate": "Fmap", "alarms_per_min": 1.5}
    found = [told | {"recording": name} for name in ROLES]
    found[2] |= {"false_alarms_per_min": 0.5}
    rows = noticed(study(detection=found)).set_index("role")
    assert rows["false_alarms_per_min"].to_dict() == {"fit": 1.5, "validate": 1.5, "contact": 0.5}


def test_false_alarms_are_pooled_by_role_where_recordings_are_many() -> None:
    rates = {"estimate": "Fmap", "alarms_per_min": 2.0, "causal_alarms_per_min": 0.0}
    rates |= {"causal_unknown": 0.25}
    results = study(detection=[rates | {"recording": name} for name in ("fitted", "seen")])
    entries = [*results.study["recordings"]]
    entries += [{"name": f"fit {k}", "robot": "ur5", "role": "fit"} for k in range(100)]
    many = replace(results, study=results.study | {"recordings": entries})
    body = shown_table("detection.false", many)
    assert [cell.text for cell in body.rows[1]] == [
        *("validate", "1", "1.0", "2", "6.3", "0", "4", "25")
    ]
    numbers = {number.name: number for number in judge_force(results).numbers}
    assert numbers["false alarms without contact"].value == 2
    assert numbers["false alarms, upper limit"].value == pytest.approx(6.3, abs=0.01)


@pytest.mark.parametrize(
    ("speed", "shut", "gain", "cause"),
    [
        (0.0, 0.5, 0.4, "stiction"),
        (0.1, 0.5, 0.4, "friction"),
        (0.0, 0.5, 1.0, "mae_gain"),
        (0.1, 1.5, 0.4, "mae_shut"),
    ],
)
def test_each_contact_has_the_likely_cause_of_its_error(
    speed: float, shut: float, gain: float, cause: str
) -> None:
    """One is found, with an error of 2 N in the mean; one is merged, one missed."""
    about = {"recording": "pushed", "estimate": "Fmap"}
    spans = [(1.0, 2.0, 30.0), (3.0, 5.0, 20.0), (8.0, 9.0, 50.0)]
    sensed = [
        about
        | {"component": "norm", "start_s": start, "end_s": end, "peak": size, "peak_error": -2.0}
        | {"mae": 2.0, "mae_shut": shut, "mae_gain": gain}
        for start, end, size in spans
    ]
    force = {"Fx": 3.0, "Fy": 0.0, "Fz": 4.0, "Fx_std": 1.0, "Fy_std": 5.0, "Fz_std": 2.0}
    speeds = {"flange_speed": speed}
    results = study(
        moving={"pushed": None},
        contact_errors=sensed,
        contacts=[about | force | {"start_s": 1.0, "end_s": 5.0, "peak_s": 4.0} | speeds],
    )
    rows = explained(results, "pushed")
    assert [*rows["why"]] == ["merged", cause, "missed"]
    width = 1.96 * math.hypot(3.0 * 1.0, 4.0 * 2.0) / 5.0
    np.testing.assert_allclose(rows["band"], [math.nan, width, math.nan])


def test_the_arm_itself_is_judged_by_the_joints_that_bear_gravity() -> None:
    """Joint 2 agrees, joint 3 is far from the known constant, joint 4 contradicts, joint 1 bears
    nothing.
    """
    known = {"robot": "ur5", "parameter": "torque_constant", "known": 10.0, "known_std": 1.0}
    values = {1: (10.0, "no", None), 2: (10.5, "yes", None), 3: (13.0, "yes", None)}
    values[4] = (10.0, "no", 25.0)
    rows = [
        known | {"joint": joint, "value": value, "determined": told, "contradicted": other}
        for joint, (value, told, other) in values.items()
    ]
    loads = [
        {"recording": name, "low": -0.2, "high": high, "taken": "no"}
        for name, high in (("seen", 0.1), ("pushed", 0.05), ("fitted", 0.6))
    ]
    results = replace(
        study(friction=rows, payload=loads), bearing={"ur5": [2, 3, 4]}, loads={"ur5": 2.0}
    )
    with speaking_of(CURRENT):
        (told,) = arm_itself(results)
        assert (
            "agree with gravity in the currents of joint 2 (torque constants at most 5 % off"
            in told
        )
        assert "On joint 3, the torque constant is 30 % off" in told
        assert "joint 4 contradict" in told
        assert "Joint 1 does not tell" in told
        assert "kg" not in told  # an arm that contradicts its description weighs nothing
        resting = replace(results, bearing={})
        (told,) = arm_itself(resting)
        assert "no joint tells by gravity" in told
        assert "Of 2 recordings without contact" in told
        (told,) = arm_itself(replace(resting, loads={"ur5": 0.1}))
    assert "kg" not in told


def test_without_a_search_nothing_is_noticed() -> None:
    assert noticed(study()).empty
    assert [*widest_band(study())] == []
    assert felt_while_fitted(replace(study(), study={"recordings": []})) == []


# Drawings, first figure, next steps


def test_the_first_figure_shows_what_the_study_is_about() -> None:
    sensor = study(
        force_mae=touched(1.0), current_rmse=predicted(0.2), torque_mae=torques({"A": 1})
    )
    without = study(current_rmse=predicted(0.2), torque_mae=torques({"A": 1}))
    alone = study(torque_mae=torques({"A": 1}))
    kinds = ["forces", "currents", "torques"]
    assert [drawn(sensor, kind) for kind in kinds] == [["pushed"], [], []]
    assert [drawn(without, kind) for kind in kinds] == [[], ["seen"], []]
    assert [drawn(alone, kind) for kind in kinds] == [[], [], ["seen"]]
    assert [drawn(study(), kind) for kind in kinds] == [[], [], []]


def test_three_steps_are_named_and_the_most_urgent_first() -> None:
    load = {"recording": "seen", "mass": 2.0, "std_error": 0.1, "configured": 0.5, "taken": "yes"}
    remark = {"robot": "ur5", "step": "friction", "code": "one path"}
    results = study(
        quality=[finding("warning", count=500)],
        force_mae=touched(1.0, "fitted"),
        payload=[load],
        remarks=[remark | {"joint": joint} for joint in (1, 2, 3)],
    )
    first, second, third = next_steps(results)
    assert first.startswith("Check fitted: its role is fit")
    assert second.endswith("the currents show 2.50 ± 0.10 kg on seen.")
    assert third.startswith("Look at the logging of seen: 50 % of the frames")
    quiet = study(force_mae=touched(1.0))
    assert next_steps(quiet) == ["No finding asks for a correction or another recording."]
    asked = study(force_mae=touched(1.0), remarks=[remark | {"joint": i} for i in (1, 2, 3)])
    assert next_steps(asked) == [
        "On ur5, joints 1 to 3 move along one path only: record another path."
    ]
    bands = [{"robot": "ur5", "after": a, "force": f} for a, f in (("now", 8.0), ("more", 7.9))]
    asked.tables["next_recordings"] = pd.DataFrame(bands)
    (path, *_) = next_steps(asked)
    assert path.endswith("though it hardly narrows the band of a force.")


def test_the_cause_that_a_check_names_is_the_advice() -> None:
    """Instead of columns, units and name, which a spring of a Baxter does not ask to check."""
    told = {"robot": "ur5", "joint": 2, "code": EXPLAINED, "remark": "a spring is missing"}
    first, *others = next_steps(study(remarks=[told]))
    assert first == "A spring is missing."
    assert not any("columns" in one for one in others)


# Tables that used to contradict themselves


def test_only_joints_that_gravity_loads_are_blamed_for_a_wrong_constant() -> None:
    """A right UR3 was told to check columns and name for joint 1, whose axis is upright."""
    remark = {"robot": "ur5", "code": "current against constant", "remark": "…"}
    results = study(remarks=[remark | {"joint": joint} for joint in (1, 3)])
    blamed = replace(results, bearing={"ur5": [2, 3, 4]}, loads={"ur5": 2.0})
    first, *others = next_steps(blamed)
    assert "name of the arm ur5" in first
    assert "(joint 3)" in first
    assert any("faster motions of joint 1" in one and "with 2 kg" in one for one in others)
    assert "(joints 1, 3)" in next_steps(results)[0]  # where nothing is known of the arm


def test_the_recording_farthest_in_time_from_the_fits_is_named() -> None:
    dates = {"fit": "2020-01-17", "validate": "2019-10-30", "contact": "2020-01-20"}
    entries = [
        {"name": f"a {role}", "robot": "ur10e", "role": role, "date": day}
        for role, day in dates.items()
    ]
    dated = Results({"recordings": entries}, {}, Path())
    [told] = map(str, farthest_in_time(dated))
    assert "a validate" in told
    assert "79 days" in told
    assert not [*farthest_in_time(study())]


def test_a_joint_that_never_moved_has_no_friction() -> None:
    known = {"robot": "ur5", "joint": 6, "value": 0.0, "std_error": 59.792, "prior_share": 1.0}
    known |= {"low": -100.0, "high": 100.0, "determined": "no"}
    known |= {"known": 10.0, "known_std": 3.0}
    rows = pd.DataFrame([known | {"parameter": name} for name in ("torque_constant", "coulomb")])
    results = study({"fitted": "1 2 3"})
    results = Results(results.study, {**results.tables, "friction": rows}, Path())
    constant, coulomb = (
        [cell.text for cell in row] for row in shown_table("friction.constants", results).rows
    )
    assert constant[3] == "0 ± 60"
    assert coulomb[3:] == ["did not move", "–", "–", "–", "–"]


@pytest.mark.parametrize(
    ("more", "source"), [({}, "data"), (UNKNOWN, "prior"), ({"determined": "no"}, "undetermined")]
)
def test_a_constant_is_mainly_from_what_tells_most(more: dict[str, Any], source: str) -> None:
    rows = pd.DataFrame([constant(1, 10.0, **more)])
    results = study()
    results = Results(results.study, {**results.tables, "friction": rows}, Path())
    (row,) = shown_table("friction.constants", results).rows
    assert row[-1].text == source


def test_excited_is_not_called_determined() -> None:
    known = [{"robot": "ur5", "determined": told} for told in ("yes", "no")]
    told = [*identified(study(parameters=known))]
    assert "determine 1 of its 2 base parameters" in told[0]
    assert told[1] == say("models.undetermined")
    groups = ("combinations", "undetermined", "gravity", "inertia", "rotors", "all")
    table = pd.DataFrame([{"robot": "ur5"} | dict.fromkeys(groups, 1.0)])
    assert (
        "not excited"
        in shown_table("excitation", Results({}, {"excitation": table}, Path())).header
    )


# What recordings serve


def test_each_recording_says_what_it_serves_and_what_not() -> None:
    errors = [
        {"recording": name, "model": "fitted", "fitted": fitted, "joint": 1}
        for name, fitted in (("fitted", "yes"), ("seen", "no"), ("pushed", "no"))
    ]
    searched = [{"recording": "pushed", "estimate": "Fmap"}]
    load = {"recording": "seen", "taken": "yes"}
    found = uses(study(current_rmse=errors, detection=searched, payload=[load]))
    assert found["fitted"] == "for constants and friction"
    assert (
        found["seen"]
        == "for weighing its load; not for testing currents: it carries an undeclared load"
    )
    assert (
        found["pushed"]
        == "for finding contacts; not for the size of forces: it has no force sensor"
    )
    sensed = study(current_rmse=errors, detection=searched, force_mae=touched(2.0), sensed=[SENSED])
    assert uses(sensed)["pushed"] == "for the size of forces, finding contacts"
    assert uses(sensed)["seen"] == "for testing currents"
    doubt = finding("warning", "offset", device="force", recording="pushed")
    doubted = study(detection=searched, force_mae=touched(2.0), sensed=[SENSED], quality=[doubt])
    biased = "; not for the size of forces: the sensor's bias is uncertain"
    assert uses(doubted)["pushed"] == f"for finding contacts{biased}"
    stopped = study(quality=[finding("stop", "other arm", recording="seen")])
    assert uses(stopped)["seen"] == "not for anything: a stop sign stands"


def test_the_parts_of_an_error_add_up_beside_the_sensors_bias() -> None:
    parts = {"mae_missed": 1.0, "mae_shut": 0.5, "mae_gain": 0.25}
    bias = dict(zip(("bias_x", "bias_y", "bias_z"), (3.0, -1.0, 0.5), strict=True))
    doubt = dict(zip(("bias_std_x", "bias_std_y", "bias_std_z"), (0.2, 0.1, 0.1), strict=True))
    sensed = SENSED | bias | doubt
    results = study(force_mae=touched(2.0, **parts), sensed=[sensed])
    ((_, error, *shares, read, sure),) = shown_table("force_mae.split", results).rows
    assert [cell.text for cell in (error, *shares)] == ["2.0", "1.0", "0.5", "0.2", "0.2"]
    assert (read.text, sure.text) == ("3.0, −1.0, 0.5", "0.20")
