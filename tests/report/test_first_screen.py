"""The first screen of made-up tables: cards, one sentence, the next steps, findings."""

import math
import re
from dataclasses import replace
from typing import Any

import pandas as pd
import pytest

from tests.made_study import (
    FAR,
    REFUSED,
    RESTING,
    ROLES,
    UNKNOWN,
    constant,
    finding,
    judged_anew,
    predicted,
    rates,
    sensed,
    study,
    torques,
    touched,
)
from ur5lib.force.estimators import LEADING, UNGATED
from ur5lib.report.page.compose import shown_table
from ur5lib.report.page.sentences import say
from ur5lib.report.results import Results
from ur5lib.report.views.cards import cards
from ur5lib.report.views.contacts import explained, widest_band
from ur5lib.report.views.first_screen import (
    drawn,
    findings,
    left_out,
    next_steps,
    result,
)
from ur5lib.report.views.models import identified
from ur5lib.report.views.recordings import trust, uses

SENSED = {"recording": "pushed", "largest_force_n": 106.0, "at_s": 3.0}
SENSED |= {"share_in_contact": 0.4, "contacts": 5}


# Cards


def test_a_card_is_the_rows_of_its_question_and_a_sentence_for_each_reason() -> None:
    plain = [row | {"estimate": UNGATED, "mae": 4.0} for row in touched(4.0)]
    results = study(force_mae=touched(2.9) + plain, contact_errors=sensed((20.0, "found")))
    (card, *_) = cards(results)
    assert (card.topic, card.state, card.sentence) == ("Force in contact", "good", "")
    first, *others = card.numbers
    assert first.text == "2.90 N"
    for told in ("95 %", "along x", "pushed", "zero: 10.0 N", "detector at its worst: 4.00 N"):
        assert told in first.place
    assert [one.text for one in others if one.name == "contacts found"] == ["1 of 1"]
    assert "no contact missed from" in [one.name for one in card.further]
    (worse, *_) = cards(study(force_mae=touched(4.9)))
    assert worse.sentence == (
        "Along x: the 95 % interval of the error is unknown, or reaches half of the force."
    )


def test_each_state_of_a_card_is_a_cell_of_the_table() -> None:
    results = study(
        force_mae=touched(2.0),
        current_rmse=predicted(0.2),
        torque_mae=torques({"A": 0.1}),
        friction=[constant(1, 10.0), constant(2, 10.0, **FAR)],
    )
    rows = results.rows("verdicts", rank=1).dropna(subset="state")
    assert [card.state for card in cards(results)] == [
        rows.set_index("question")["state"][one]
        for one in ("force", "recordings", "constants", "currents", "links")
    ]


def test_results_without_verdicts_have_no_cards() -> None:
    made = study(force_mae=touched(2.0))
    empty = {"verdicts": made.tables["verdicts"][:0]}
    assert cards(replace(made, tables=made.tables | empty)) == []


# The first sentence


def test_the_sentence_states_contacts_force_and_constants() -> None:
    rows = [constant(1, 10.0), constant(2, 20.0), constant(3, 5.0, **UNKNOWN)]
    contacts = sensed((30.0, "found"), (20.0, "missed"))
    (told,) = result(study(friction=rows, contact_errors=contacts, force_mae=touched(4.0)))
    assert told.replace("\u00a0", " ") == (
        "1 of 2 contacts at the force sensor are found, none from 30.0 N on is missed; the mean "
        "error of the force in contact is 4.00 N at worst (95 %: 3.2 to 4.8); zero errs by 10.0 N "
        "there; 2 of 3 torque constants may be used (± 10 % or less at 95 %)."
    )


def test_a_study_that_is_stopped_or_says_nothing_has_no_sentence() -> None:
    stopped = study(force_mae=touched(1.0), quality=[finding("stop", "contradiction")])
    assert [*result(stopped)] == []
    assert [*result(study())] == []


# Next steps


def test_three_steps_are_named_and_the_most_urgent_first() -> None:
    load = {"recording": "seen", "mass": 2.0, "std_error": 0.1, "configured": 0.5, "taken": "yes"}
    remark = {"robot": "ur5", "step": "friction", "code": "one path"}
    results = study(
        quality=[
            finding("warning", count=500),
            finding("error", "touched", device="force", recording="fitted"),
        ],
        force_mae=touched(1.0, "fitted"),
        payload=[load],
        remarks=[remark | {"joint": joint} for joint in (1, 2, 3)],
    )
    first, second, third = next_steps(results)
    assert first.startswith("Give fitted the role contact")
    assert second.endswith("the currents show 2.50 ± 0.10 kg on seen (± one standard error).")
    assert third.startswith("Mend the logging, as of seen: 50 % of the frames")
    quiet = study(force_mae=touched(1.0))
    assert next_steps(quiet) == ["No finding asks for a correction or another recording."]
    asked = study(force_mae=touched(1.0), remarks=[remark | {"joint": i} for i in (1, 2, 3)])
    assert next_steps(asked) == [
        "On ur5, joints 1 to 3 move along one path only: record another path, or give a validate "
        "recording of another path the role fit, which tests the error bars."
    ]


def test_the_cause_that_a_check_names_is_the_advice() -> None:
    """Instead of columns, units and name, which a spring of a Baxter does not ask to check."""
    told = {"robot": "ur5", "joint": 2, "code": "explained contradiction", "remark": "a spring"}
    first, *others = next_steps(study(remarks=[told]))
    assert first == "A spring."
    assert not any("columns" in one for one in others)


def test_only_joints_that_gravity_loads_are_blamed_for_a_wrong_constant() -> None:
    """A right UR3 was told to check columns and name for joint 1, whose axis is upright."""
    remark = {"robot": "ur5", "code": "current against constant", "remark": "…"}
    results = study(remarks=[remark | {"joint": joint} for joint in (1, 3)])
    first, *others = next_steps(
        judged_anew(results, bearing={"ur5": [2, 3, 4]}, loads={"ur5": 2.0})
    )
    assert "name of the arm ur5" in first
    assert "(joint 3)" in first
    assert any("faster motions of joint 1" in one and "with 2 kg" in one for one in others)
    assert "(joints 1, 3)" in next_steps(results)[0]  # where nothing is known of the arm


def test_unknown_links_are_the_first_to_record() -> None:
    unknown = judged_anew(study(), placeholders=frozenset({"ur5"}))
    assert next_steps(unknown)[0].startswith("The links of ur5 are unknown")
    why = {"robot": "ur5", "step": "identification", "remark": "no bodies", "code": "no bodies"}
    told = study(remarks=[why])
    refused = judged_anew(told, placeholders=frozenset({"ur5"}))
    assert next_steps(refused)[0].endswith("computed: no bodies.")
    found = judged_anew(study(parameters=[{"robot": "ur5"}]), placeholders=frozenset({"ur5"}))
    assert "links are unknown" not in " ".join(next_steps(found))


# Findings


@pytest.mark.parametrize(
    "code",
    ["unlikely constant", "current against constant", "torque against gain", "explained"],
)
def test_a_contradiction_is_a_finding(code: str) -> None:
    """No fault is denied next to a card and a step that name one."""
    code = "explained contradiction" if code == "explained" else code
    doubt = {"robot": "ur5", "step": "friction", "joint": 2, "remark": "contradicts", "code": code}
    stated = "Contradicts." if code.startswith("explained") else "ur5, joint 2: contradicts."
    assert findings(study(remarks=[doubt])) == [stated]


def test_what_could_not_be_checked_is_nobodys_gravest_finding() -> None:
    results = study(quality=[finding("note", "order not checked")])
    assert trust(results)["finding"].isna().all()


def test_a_contact_at_a_sensor_is_not_denied() -> None:
    """Neither that there is a contact, nor that there is a sensor, nor is either asked for."""
    results = study(RESTING, sensed=[SENSED])
    (told,) = findings(results)
    assert re.findall(r"\d[\d.]*", told) == ["106.0", "40"]
    assert not [text for text in left_out(results) if "force sensor" in text]
    assert not [text for text in next_steps(results) if "force sensor" in text]
    assert drawn(results, "forces") == ["pushed"]


def test_contacts_in_a_recording_to_fit_are_told() -> None:
    """Fitted as friction, they widen bands and raise the threshold of alarms."""
    contact = {"estimate": "Fmap", "kind": "false", "recording": "fitted"}
    results = study(
        contacts=[contact],
        current_rmse=[{"recording": "fitted", "model": "fitted", "fitted": "yes"}],
    )
    (told,) = findings(results)
    assert told.startswith("On fitted, whose role is fit,")
    assert [text for text in next_steps(results) if "role is fit" in text]
    elsewhere = study(contacts=[contact | {"recording": "pushed", "kind": "contact"}])
    assert not [text for text in next_steps(elsewhere) if "role is fit" in text]


def test_without_a_search_no_contact_is_denied() -> None:
    assert findings(study(RESTING)) == [say("findings.unsearched")]
    quiet = SENSED | {"largest_force_n": 2.0, "contacts": 0, "share_in_contact": 0.0}
    assert [text for text in next_steps(study(sensed=[quiet])) if "force sensor" in text]


def test_a_search_of_the_estimates_alone_denies_contacts() -> None:
    searched = [rates("seen", estimate=LEADING)]
    assert findings(study(RESTING, detection=searched)) == [say("findings.none")]


def test_a_wrench_that_is_not_used_is_named() -> None:
    unused = {"recording": "pushed", "taken_for": "nothing", "reason": "no effort tells its frame"}
    told = [
        " ".join(findings(study(account=[unused | {"subject": subject}])))
        for subject in ("/wrench/force/x … /wrench/force/z", "tool_mode")
    ]
    assert ["wrench in the files of pushed" in one for one in told] == [True, False]


# Tables and figures of the sections


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


def test_contacts_without_an_alarm_of_their_own_are_named() -> None:
    contacts = sensed((20.0, "found"), (30.0, "merged"), (7.0, "missed"))
    alarm = {"recording": "pushed", "estimate": "Fmap", "kind": "contact", "peak_s": 4.0}
    alarm |= {"Fx_std": 1.0, "Fy_std": 5.0, "Fz_std": 2.0, "posture_deg": "0.2 -90.0 90.0"}
    results = study(detection=[rates("pushed", 1.0)], contact_errors=contacts, contacts=[alarm])
    body = shown_table("noticed", results)
    line = dict(zip(body.header, [cell.text for cell in body.rows[0]], strict=True))
    assert (line["found"], line["missed at [s]"], line["strongest missed [N]"]) == (
        *("1 of 3", "20.0", "7.0"),
    )
    assert "± 10 along y at 4.0 s" in line["widest band [N]"]
    (told,) = widest_band(results)
    assert "pushed at 4.0 s, with the joints at 0, −90, 90°" in told.replace("\u00a0", " ")


@pytest.mark.parametrize(("fate", "cause"), [("found", "stiction"), ("missed", None)])
def test_each_contact_has_its_fate_or_the_cause_of_its_error(fate: str, cause: str | None) -> None:
    rows = [row | {"cause": cause, "band": math.nan} for row in sensed((20.0, fate))]
    assert [*explained(study(contact_errors=rows), "pushed")["why"]] == [cause or fate]


def test_whether_a_constant_may_be_used_is_said_by_joint() -> None:
    rows = [
        constant(1, 11.0),
        constant(2, 17.0, **FAR),
        constant(3, 10.0, **UNKNOWN),
        constant(4, 10.0, **REFUSED),
        constant(5, 30.0, use="no", reason="unlikely"),
    ]
    used = [row[1].text for row in shown_table("friction.by_joint", study(friction=rows)).rows]
    assert [text.split(":")[0].split(",")[0] for text in used] == [
        *("yes", "yes", "not determined", "the known one", "no"),
    ]
    assert "far from" in used[1]


def test_a_joint_that_never_moved_has_no_friction() -> None:
    known = {"robot": "ur5", "joint": 6, "value": 0.0, "std_error": 59.792, "prior_share": 1.0}
    known |= {"low": -100.0, "high": 100.0, "determined": "no", "use": "no"}
    known |= {"known": 10.0, "known_std": 3.0}
    rows = [known | {"parameter": "torque_constant", "reason": "prior_only"}]
    rows += [known | {"parameter": "coulomb", "reason": "no_motion"}]
    of_constant, coulomb = (
        [cell.text for cell in row]
        for row in shown_table("friction.constants", study(friction=rows)).rows
    )
    assert of_constant[3] == "0 ± 60"
    assert {*coulomb[3:]} <= {"did not move", "–", "no_motion"}


def test_the_model_that_comes_next_is_shown_with_the_best() -> None:
    rows = torques({"A": 0.3, "B": 0.1, "C": 0.2})
    body = shown_table("judged_errors.links", study(torque_mae=rows))
    line = dict(zip(body.header, [cell.text for cell in body.rows[0]], strict=True))
    names = ("model", "error", "next model", "its error")
    assert [line[name] for name in names] == ["B", "0.100", "C", "0.200"]


def test_excited_is_not_called_determined() -> None:
    known = [{"robot": "ur5", "determined": told} for told in ("yes", "no")]
    told = [*identified(study(parameters=known))]
    assert "determine 1 of its 2 base parameters" in told[0]
    assert told[1] == say("models.undetermined")
    groups = ("combinations", "undetermined", "gravity", "inertia", "rotors", "all")
    table = pd.DataFrame([{"robot": "ur5"} | dict.fromkeys(groups, 1.0)])
    assert "not excited" in shown_table("excitation", Results({}, {"excitation": table})).header


def test_each_recording_says_what_it_serves_and_what_not() -> None:
    errors = [
        {"recording": name, "model": "fitted", "fitted": fitted, "joint": 1}
        for name, fitted in (("fitted", "yes"), ("seen", "no"), ("pushed", "no"))
    ]
    searched = [rates("pushed")]
    load = {"recording": "seen", "taken": "yes"}
    found = uses(study(current_rmse=errors, detection=searched, payload=[load]))
    assert found["fitted"] == "for constants and friction"
    assert found["seen"] == (
        "for weighing its load; not for testing currents: it carries an undeclared load"
    )
    assert found["pushed"] == (
        "for finding contacts; not for the size of forces: it has no force sensor"
    )
    known: dict[str, Any] = {"current_rmse": errors, "detection": searched, "sensed": [SENSED]}
    assert uses(study(**known, force_mae=touched(2.0)))["pushed"] == (
        "for the size of forces, finding contacts"
    )
    doubt = finding("warning", "offset", device="force", recording="pushed")
    doubted = touched(2.0, use="no", reason="sensor_bias")
    assert uses(study(**known, force_mae=doubted, quality=[doubt]))["pushed"] == (
        "for finding contacts; not for the size of forces: the sensor's bias is uncertain"
    )
    stopped = study(quality=[finding("stop", "other arm", recording="seen")])
    assert uses(stopped)["seen"] == "not for anything: a stop sign stands"
    assert {*ROLES} == {*uses(stopped)}
