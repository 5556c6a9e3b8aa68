"""Findings, next steps and what is left out, of made-up tables."""

import re
import subprocess
import sys
from dataclasses import replace
from typing import Any

import pandas as pd
import pytest
import typer
import yaml

from tests.conftest import PROJECT
from tests.made_study import RESTING, finding, judged_anew, rates, study, touched
from ur5lib.channels import TORQUE
from ur5lib.checks.files import quality_row
from ur5lib.cli import app
from ur5lib.force.estimators import LEADING
from ur5lib.records.accepted import accepting
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.quality import Contradictions, Finding, contradiction
from ur5lib.records.verdicts import Advice, Asks
from ur5lib.report.found import MOST_FINDINGS, findings, left_out
from ur5lib.report.next_steps import next_steps
from ur5lib.report.results import Results
from ur5lib.report.stated import Step, claim, joints, line, listed, overruled, remedy, with_error
from ur5lib.tables import as_written

SENSED = {"recording": "pushed", "largest_force_n": 106.0, "at_s": 3.0}
SENSED |= {"share_in_contact": 0.4, "contacts": 5}
EXCHANGED = contradiction(
    CauseCode.EXCHANGED_JOINTS,
    "order",
    "joints 2 and 3 are exchanged: their motion explains the currents or torques far better with "
    "all their columns swapped; correct the columns",
)
OTHER_ARM = contradiction(
    CauseCode.OTHER_ARMS_CURRENTS,
    "robot",
    "the currents are not those of ur5: the motion of `robot: ur10` explains them far better; "
    "correct `robot`, or columns and units",
)
UNREAD = finding("stop", Found.UNREADABLE, detail="a.csv: it has no rows; record it again")
LOAD = {"recording": "seen", "mass": 2.0, "std_error": 0.1, "configured": 0.5, "taken": "yes"}
FEW = {"robot": "ur5", "step": "friction"}
MOST_WORDS = 26
COMMANDS = {*typer.main.get_command(app).commands}  # type: ignore[attr-defined]


def quality(*found: Finding) -> list[dict[str, Any]]:
    """Rows of quality.csv of findings about `pushed`."""
    return [{"recording": "pushed", **vars(quality_row(one))} for one in found]


def sentences(results: Results) -> list[str]:
    return [step.sentence for step in next_steps(results)]


def advised(results: Results, **row: Any) -> Results:
    """A study that a row of advice.csv alone advises."""
    table = as_written(pd.DataFrame([vars(Advice(**row))]))
    return replace(results, tables={**results.tables, "advice": table})


# Words


def test_parts_of_a_finding_are_what_is_wrong_its_remedy_and_a_line() -> None:
    told = OTHER_ARM.sentence()
    sign, accept = overruled(told)
    assert accept == "accept: {robot: the reason}"
    assert claim(sign) == "the currents are not those of ur5"
    assert remedy(sign) == "correct `robot`, or columns and units"
    assert line(sign) == "robot: ur10"
    assert claim("a.csv: it has no rows; record it again") == "a.csv: it has no rows"
    assert claim("the share is 61% of all") == "the share is 61 % of all"
    assert (remedy("no motion"), line("correct `robot`"), overruled("why")) == ("", "", ("why", ""))


def test_names_joints_and_errors_in_words() -> None:
    assert [listed([*names]) for names in ("a", "ab", "abc")] == ["a", "a and b", "a, b and c"]
    assert listed(["a"], 2) == "a and 1 other"
    assert listed([*"abcde"]) == "a, b, c and 2 others"
    assert [joints(some) for some in ([2], [1, 3], [2.0, 3.0, 4.0])] == [
        *("joint 2", "joints 1, 3", "joints 2 to 4"),
    ]
    assert [with_error(2.04, std) for std in (0.047, 3.0, float("nan"))] == [
        *("2.04 ± 0.09", "2 ± 6", "2.04"),
    ]


# Next steps


@pytest.mark.parametrize("effort", [None, TORQUE])
@pytest.mark.parametrize("code", Asks)
def test_each_step_is_one_short_sentence_with_what_does_it(code: str, effort: Any) -> None:
    made = study(quality=quality(EXCHANGED))
    made = replace(made, effort=effort or made.effort, study={**made.study, "study": "mine"})
    row = {"robot": "ur5", "recording": "seen", "recordings": 2, "joints": "1 2"}
    known = {"value": 2.0, "std_error": 0.1, "detail": str(quality(EXCHANGED)[0]["detail"])}
    if code in ("stop_recording", "stop_arm", "explained", "advised"):
        row |= {"detail": "Moving joint 1"}
    if code == "advised":
        del known["detail"]
    for values in (row, row | known, row | known | {"joints": "2"}):
        (step,) = next_steps(advised(made, code=code, kind="correction", **values))
        assert step.sentence[0].isupper()
        assert step.sentence.endswith(".")
        assert ". " not in step.sentence
        assert not {*step.sentence} & {*"{}"}
        assert len(step.sentence.split()) <= MOST_WORDS
        assert command_or_line(step.command), step.command


def command_or_line(command: str) -> bool:
    """Whether it is a command of ur5, a line of YAML, or nothing."""
    if command.startswith("ur5 "):
        return command.split()[1] in COMMANDS and " mine" in command.replace("/", " ")
    return not command or isinstance(yaml.safe_load(command), dict)


def test_a_summary_loads_neither_torch_nor_filters() -> None:
    """Each takes longer than the summary."""
    program = "import sys; from ur5lib.report import summary, topics"
    program += "; from ur5lib.workspace.topics import modules_of_topics as modules"
    program += "; modules('found')"
    program += "; sys.exit(bool({'torch', 'scipy.signal', 'matplotlib.pyplot'} & {*sys.modules}))"
    subprocess.run([sys.executable, "-c", program], cwd=PROJECT, check=True)


def test_three_steps_are_named_and_the_most_urgent_first() -> None:
    remark = FEW | {"code": "one path"}
    results = study(
        quality=[
            finding("warning", count=500),
            finding("error", Found.TOUCHED, device="force", recording="fitted"),
        ],
        force_mae=touched(1.0, "fitted"),
        payload=[LOAD],
        remarks=[remark | {"joint": joint} for joint in (1, 2, 3)],
    )
    first, second, third = next_steps(results)
    assert first.sentence.startswith("Give “fitted” the role contact")
    assert first.command == "role: contact"
    assert second.sentence.endswith("the currents show 2.5 kg.")
    assert second.command == "payload: {mass: 2.5, center_of_mass: [x, y, z]}"
    assert third.sentence.startswith("Record “seen” anew with a repaired logger")
    assert next_steps(study(force_mae=touched(1.0))) == []
    asked = study(force_mae=touched(1.0), remarks=[remark | {"joint": i} for i in (1, 2, 3)])
    assert [step.sentence for step in next_steps(asked)] == [
        "Record joints 1 to 3 of ur5 on another path: on one path, nothing tests the error bars."
    ]
    constants = [{"robot": "ur5", "joint": joint, "parameter": "coulomb"} for joint in (1, 2, 3)]
    every = study(
        force_mae=touched(1.0),
        friction=constants,
        remarks=[remark | {"joint": joint} for joint in (1, 2, 3)],
    )
    assert "Record all joints of ur5" in sentences(every)[0]


def test_spans_of_fits_that_seem_touched_are_asked_to_be_cut_off() -> None:
    """With what does it, and not among what is impossible."""
    about = {"robot": "ur5", "step": "contact forces", "code": CauseCode.HIDDEN_CONTACT}
    told = "has an alarm at 3.0 s, counted as false: its span is left out; cut it off by `from_s`"
    results = study(remarks=[about | {"remark": f"“{name}” {told}"} for name in ("one", "other")])
    assert sentences(results)[0] == (
        "If something touched the arm there, cut it off by `from_s` and `to_s`: “one” has an "
        "alarm at 3.0 s, counted as false; 1 more has alarms, too."
    )
    assert left_out(results) == []


def test_a_load_is_declared_where_the_currents_see_it() -> None:
    """Where another one is configured, theirs is the place of both together."""
    place = {f"center_of_mass_{axis}": 0.1 for axis in "xyz"}
    alone, more = (study(payload=[LOAD | place | {"configured": mass}]) for mass in (0.0, 0.5))
    assert next_steps(alone)[0].command.endswith("center_of_mass: [0.100, 0.100, 0.100]}")
    assert next_steps(more)[0].command.endswith("center_of_mass: [x, y, z]}")


def test_a_stop_sign_asks_for_its_remedy() -> None:
    first = next_steps(study(quality=quality(EXCHANGED)))[0]
    assert first.sentence == "On “pushed”, correct the columns: joints 2 and 3 are exchanged."
    assert first.command.startswith("ur5 check ")
    assert first.command.endswith(" pushed")
    assert next_steps(study(quality=quality(OTHER_ARM)))[0] == Step(
        "On “pushed”, correct `robot`, or columns and units: the currents are not those of ur5.",
        "robot: ur10",
    )
    unread = sentences(study(quality=[UNREAD]))[0]
    assert unread == "On “seen”, record it again: a.csv: it has no rows."
    told = finding("stop", Found.CONTRADICTION, detail="nothing is right")
    assert sentences(study(quality=[told]))[0] == ("Correct “seen” or its entry: nothing is right.")


def test_the_cause_that_a_check_names_is_the_advice() -> None:
    """Instead of columns, units and name, which a spring of a Baxter does not ask to check."""
    cause = "the torques of joint 2 of baxter show a spring"
    told = FEW | {"joint": 2, "code": "explained contradiction"}
    asked = "; write `balanced_joints: [2]` into its description (by itself, it would be 3)"
    first, *others = next_steps(study(remarks=[told | {"remark": cause + asked}]))
    assert first == Step(
        f"Write `balanced_joints: [2]` into its description: {cause}.", "balanced_joints: [2]"
    )
    assert not any("columns" in one.sentence for one in others)
    assert sentences(study(remarks=[told | {"remark": "a spring"}]))[0] == "A spring."


def test_only_joints_that_gravity_loads_are_blamed_for_a_wrong_constant() -> None:
    """A right UR3 was told to check columns and name for joint 1, whose axis is upright."""
    remark = {"robot": "ur5", "code": "current against constant", "remark": "…"}
    results = study(remarks=[remark | {"joint": joint} for joint in (1, 3)])
    bearing = judged_anew(results, bearing={"ur5": [2, 3, 4]}, loads={"ur5": 2.0})
    first, *others = sentences(bearing)
    assert first.startswith("Check columns, units, payload and `robot` of ur5")
    assert "of joint 3 contradicts" in first
    assert any("joint 1 of ur5 faster, or with 2 kg" in one for one in others)
    assert any("--payload 2 " in step.command for step in next_steps(bearing))
    assert "joints 1, 3" in sentences(results)[0]  # where nothing is known of the arm


def test_a_command_is_named_once() -> None:
    remarks = [
        FEW | {"code": code, "joint": joint} for joint, code in ((5, "no motion"), (1, "one path"))
    ]
    first, *others = next_steps(study(remarks=remarks))
    assert first.sentence.startswith("Record a motion of joint 5")
    assert first.command not in [one.command for one in others]


def test_unknown_links_are_the_first_to_record() -> None:
    unknown = judged_anew(study(), placeholders=frozenset({"ur5"}))
    assert sentences(unknown)[0].startswith("Record actual_torque of ur5 on several paths")
    why = {"robot": "ur5", "step": "identification", "remark": "no bodies", "code": "no bodies"}
    refused = judged_anew(study(remarks=[why]), placeholders=frozenset({"ur5"}))
    assert sentences(refused)[0].endswith("which its recordings do not determine: no bodies.")
    found = judged_anew(study(parameters=[{"robot": "ur5"}]), placeholders=frozenset({"ur5"}))
    assert "links" not in " ".join(sentences(found))


def test_the_command_that_designs_a_recording_knows_the_table() -> None:
    results = study(remarks=[FEW | {"code": "no motion", "joint": 5}])
    on_pedestal = {**results.study, "study": "mine", "devices": {"table_m": -0.8}}
    (first, *_) = next_steps(replace(results, study=on_pedestal))
    assert first.command == (
        "ur5 excite --robot ur5 --results results/mine --table -0.8 --output raw/mine/next"
    )


# Findings


@pytest.mark.parametrize(
    ("code", "remark", "said"),
    [
        (
            "unlikely constant",
            "it contradicts the known one: check",
            "it contradicts the known one",
        ),
        ("current against constant", "it contradicts", "it contradicts"),
        ("torque against gain", "it contradicts", "it contradicts"),
        (
            "explained contradiction",
            "a spring; write it (by itself, it is 3)",
            "by itself, it is 3",
        ),
    ],
)
def test_a_contradiction_is_a_finding(code: str, remark: str, said: str) -> None:
    """No fault is denied next to a card and a step that name one."""
    doubt = FEW | {"remark": remark, "code": code}
    both = study(remarks=[doubt | {"joint": joint} for joint in (2, 3)])
    assert findings(both) == [f"Joints 2, 3 of ur5: {said}."]


def test_a_stop_sign_is_the_first_finding_with_what_overrules_it() -> None:
    first, *_ = findings(study(quality=quality(EXCHANGED), payload=[LOAD]))
    assert first.startswith("Stop sign on “pushed”: joints 2 and 3 are exchanged: their motion")
    assert first.endswith(
        "No forces are stated. If the study is right: `accept: {order: the reason}`."
    )
    assert findings(study(quality=[UNREAD]))[0].startswith("“seen” is left out: a.csv")
    run = finding(
        "stop", Found.SAME_RUN, detail="a and b are one run; keep one of them in the study"
    )
    assert "No forces" not in findings(study(quality=[run]))[0]
    arm = {"robot": "ur5", "step": "stop sign", "code": "x", "remark": "constants contradict"}
    assert findings(study(remarks=[arm])) == [
        "Stop sign on ur5: constants contradict. No forces are stated."
    ]


def test_an_accepted_stop_sign_is_a_finding_with_its_reason() -> None:
    """Numbers rest on it."""
    found = accepting(Contradictions([EXCHANGED]), {"order": "our drives"})
    assert findings(study(quality=quality(*found.findings))) == [
        "On “pushed”, the study accepts a stop sign (our drives): joints 2 and 3 are exchanged."
    ]


def test_an_error_is_a_finding() -> None:
    """A sensor is ignored, or a role is wrong."""
    told = "the sensor reads up to 33 N in 2 contacts, although the role fit denies it; correct it"
    results = study(quality=[finding("error", Found.TOUCHED, device="force", detail=told)])
    assert findings(results) == [f"On “seen”, {told.partition(';')[0]}."]


def test_a_contact_at_a_sensor_is_not_denied() -> None:
    """Neither that there is a contact, nor that there is a sensor, nor is either asked for."""
    results = study(RESTING, sensed=[SENSED])
    (told,) = findings(results)
    assert re.findall(r"\d[\d.]*", told) == ["106.0", "40"]
    assert not [text for text in left_out(results) if "force sensor" in text]
    assert not [text for text in sentences(results) if "force sensor" in text]


def test_contacts_in_a_recording_to_fit_are_told() -> None:
    """Fitted as friction, they widen bands and raise the threshold of alarms."""
    contact = {"estimate": LEADING, "kind": "false", "recording": "fitted", "peak_s": 20.21}
    results = study(
        contacts=[contact],
        current_rmse=[{"recording": "fitted", "model": "fitted", "fitted": "yes"}],
    )
    (told,) = findings(results)
    assert told.startswith("“fitted”, role fit: 1 alarm at 20.2 s, more than the other fit")
    assert [text for text in sentences(results) if "(1 alarm at 20.2 s)" in text]
    elsewhere = study(contacts=[contact | {"recording": "pushed", "kind": "contact"}])
    assert not [text for text in sentences(elsewhere) if "pushes for noise" in text]


def test_contacts_without_a_sensor_are_counted_and_those_off_the_flange_named() -> None:
    contact = {"recording": "pushed", "estimate": LEADING, "kind": "contact", "peak_s": 1.0}
    off = contact | {"kind": "off_flange", "peak_s": 12.84}
    known: dict[str, Any] = {"detection": [rates("pushed", estimate=LEADING)]}
    assert findings(study(contacts=[contact, off], **known)) == [
        "1 of 2 contacts on “pushed”, at 12.8 s, seems to be off the flange, where its force would "
        "be wrong.",
        "Contacts found without a force sensor: 2 on “pushed”.",
    ]
    moving = [off | {"link": link, "peak_s": float(link)} for link in (3, 2)]
    assert findings(study(contacts=[contact, off, *moving], **known))[:2] == [
        "2 of 4 contacts on “pushed”, at 3.0, 2.0 s, seem to be off the flange, most likely on "
        "links 2, 3.",
        "1 of 4 contacts on “pushed”, at 12.8 s, seems to be off the flange, where its force would "
        "be wrong.",
    ]
    assert findings(study(**known)) == ["Contacts found without a force sensor: none on “pushed”."]


def test_loads_are_findings() -> None:
    load = LOAD | {"low": 1.8, "high": 2.2}
    assert findings(study(payload=[load])) == [
        "The currents show an undeclared load of 2 kg on “seen” (95 %: 1.8 to 2.2), taken off the "
        "force."
    ]
    both = study(payload=[load, load | {"recording": "pushed", "mass": 2.5}])
    assert findings(replace(both, effort=TORQUE)) == [
        "The torques show undeclared loads of 2 to 2.5 kg on 2 recordings: “seen” and “pushed”."
    ]
    taken = {"recording": "pushed", "estimate": LEADING, "kind": "load", "load_mass": 2.04}
    assert findings(study(contacts=[taken | {"load_mass_std": 0.047}])) == [
        "The arm takes up a load of 2.04 ± 0.09 kg on “pushed”."
    ]


def test_without_a_search_no_contact_is_denied() -> None:
    (told,) = findings(study(RESTING))
    assert told.startswith("No contact was searched for: no friction was fitted")
    (told,) = findings(study(RESTING, friction=[{"robot": "ur5", "joint": 1}]))
    assert "no friction" not in told
    quiet = SENSED | {"largest_force_n": 2.0, "contacts": 0, "share_in_contact": 0.0}
    assert [text for text in sentences(study(sensed=[quiet])) if "force sensor" in text]
    searched = [rates("seen", estimate=LEADING)]
    assert findings(study(RESTING, detection=searched)) == []


def test_a_force_that_is_not_stated_is_named() -> None:
    told = "the currents show 61% of the friction of such a motion; since nothing was fitted, …"
    results = study(quality=[finding("warning", Found.UNUSUAL_FRICTION, detail=told)])
    assert findings(results)[0] == (
        "No force is stated on “seen”: the currents show 61 % of the friction of such a motion."
    )
    unused = {"recording": "pushed", "taken_for": "nothing", "reason": "no effort tells its frame"}
    for subject, named in (("/wrench/force/x … /wrench/force/z", True), ("tool_mode", False)):
        told = " ".join(findings(study(account=[unused | {"subject": subject}])))
        assert ("wrench in the files of “pushed”" in told) == named


def test_moments_no_better_than_zero_are_not_to_be_used() -> None:
    known = touched(1.0)[0] | {"determined": "no"}
    rows = [*touched(1.0), *(known | {"component": name} for name in ("nx", "ny", "nz"))]
    assert findings(study(force_mae=rows)) == [
        "Do not use the moments nx, ny and nz of F̂ᵐᵃᵖ: on no recording are they reliably better "
        "than zero."
    ]
    rows[-1] |= {"determined": "yes"}
    assert "moments nx and ny" in findings(study(force_mae=rows))[0]


def test_of_many_findings_the_gravest_are_named_and_the_others_counted() -> None:
    stops = quality(*[EXCHANGED] * 30)
    doubt = FEW | {"code": "unlikely constant"}
    doubts = [doubt | {"joint": joint, "remark": f"{joint} is off"} for joint in range(1, 7)]
    first, *others, last = findings(study(quality=stops, remarks=doubts, payload=[LOAD]))
    assert len(others) + 2 <= MOST_FINDINGS
    assert first.startswith("Stop sign on")
    assert [one for one in others if one.startswith("The currents show")]
    assert last == "30 more in quality.csv and remarks.csv."


def test_text_of_files_is_made_printable() -> None:
    hostile = finding("error", detail="{x}\x1b[31m is `a: b`", recording="seen")
    assert "\\x1b" in findings(study(quality=[hostile]))[0]


# What is left out


def test_fits_predictions_and_comparisons_that_data_do_not_allow_have_reasons() -> None:
    remark = {"robot": "ur5", "step": "contact forces", "code": "little rest"}
    told = "all follow one path, which does not show more; record another path"
    results = study(
        remarks=[remark | {"remark": told}],
        friction=[{"robot": "ur5", "joint": 1, "parameter": "coulomb"}],
        detection=[rates("pushed", estimate=LEADING)],
    )
    assert left_out(results) == [
        "Contact forces of ur5: all follow one path.",
        "Errors of the force: no recording has a working force sensor.",
    ]
    entries = [one | {"role": "fit"} for one in results.study["recordings"]]
    unseen = replace(results, study={**results.study, "recordings": entries}, effort=TORQUE)
    assert "Prediction of torques: no recording has the role validate." in left_out(unseen)
    assert left_out(study()) == []
