"""What commands say of verdicts, and what `ur5 export` refuses by them."""

import json
import sys
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import mujoco
import pinocchio
import pytest
import yaml

from tests.command import Command
from tests.conftest import Workflow
from ur5lib.commands import run
from ur5lib.commands.exported import exported
from ur5lib.commands.overruled import Overruled, overruled
from ur5lib.commands.verdicts import card_states, lines
from ur5lib.errors import InputError
from ur5lib.finished import StudyFiles
from ur5lib.records.verdicts import Verdict, reason_in_words
from ur5lib.robots.description import load_robot, robot_path, robot_yaml
from ur5lib.tables import write_rows, write_text

REASON = "for <a> lesson --> on\nrivals"  # that no format may stumble over
QUESTIONS = ("force", "constants")


def judged(folder: Path, *rows: Verdict) -> Path:
    """Write verdicts on a study."""
    write_rows(Verdict, rows, folder / "tables" / "verdicts.csv")
    return folder


def verdict(question: str, state: Any = "usable", arm: str = "ur5", **more: Any) -> Verdict:
    return Verdict(question=question, state=state, arm=arm, **more)


@pytest.fixture
def results(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A study whose results are made up: of a UR5, and of an arm that measures torques."""
    monkeypatch.chdir(tmp_path)
    recording = "{name: free, robot: ur5e, format: rtde-csv, folder: ., file: free.csv, role: fit}"
    study = f"study: mine\ntitle: My arm\nrecordings: [{recording}]\n"
    (tmp_path / "arm.yaml").write_text(study)
    folder = Path("results/mine")
    for name in ("ur5", "kuka-kr300"):
        own = robot_yaml(load_robot(robot_path(name)))
        write_text(own, folder / "parameters" / name / "arm.yaml")
    (folder / "tables").mkdir()
    write_text("", folder / "report.html")
    program = "print('Nothing to be done')"
    monkeypatch.setattr(run, "_command", lambda *_: [sys.executable, "-c", program])
    return folder


def test_states_of_cards_are_a_line_each(results: Path) -> None:
    """Without numbers that have no state, and further ones."""
    judged(
        results,
        verdict("force", "do not use", arm="", reason="blind"),
        verdict("constants", "good"),
        verdict("constants", None, rank=2, reason="far"),
        verdict("load", None),
    )
    assert [*lines(card_states(results), "mine")] == [
        f"force: do not use. {reason_in_words('blind')}",
        "constants: copy it",
    ]


def test_each_of_several_arms_has_its_line_and_its_words(results: Path) -> None:
    """And none of both together, where each is judged."""
    judged(
        results,
        verdict("constants", "do not use", reason="unlikely"),
        verdict("constants", "usable", "kuka-kr300", reason="far"),
        verdict("constants", "do not use", "", reason="unlikely"),
        verdict("force", "not determined", "", reason="no_sensor"),
    )
    constants, gains, force = lines(card_states(results), "mine")
    assert constants.startswith("constants of ur5: do not use. The torque constant contradicts")
    assert gains.startswith("constants of kuka-kr300: with this doubt. The gain is farther")
    assert force == f"force: not known. {reason_in_words('no_sensor')}"


def test_status_and_report_print_the_states(results: Path, run_ur5: Command) -> None:
    judged(results, verdict("force", "usable", "", reason="wide_interval"))
    line = f"force: with this doubt. {reason_in_words('wide_interval')}"
    report, states, rest = run_ur5("status", "mine").out.splitlines()
    assert report.startswith("report: results/mine/report.html, written ")
    assert (states, rest) == (line, "nothing to be done")
    printed = run_ur5("report", "mine").out.splitlines()
    assert printed == [line, "report: results/mine/report.html"]
    state = json.loads(run_ur5("status", "mine", "--json").out)
    [card] = state["verdicts"]
    assert (card["question"], card["state"], card["reason"]) == ("force", "usable", "wide_interval")


@pytest.mark.parametrize(("command", "study"), [("status", "arm.yaml"), ("report", "mine")])
def test_results_without_verdicts_say_so_in_one_line(
    results: Path, command: str, study: str, run_ur5: Command
) -> None:
    said = run_ur5(command, "mine").out.splitlines()
    assert f"no verdicts, as results of an earlier version; next: ur5 run {study}" in said
    assert json.loads(run_ur5("status", "mine", "--json").out)["verdicts"] is None


@pytest.mark.parametrize("state", ["good", "usable", "not determined"])
def test_only_do_not_use_is_refused(results: Path, state: str) -> None:
    judged(results, *(verdict(question, state) for question in QUESTIONS))
    assert overruled(StudyFiles(results), "ur5", QUESTIONS, "") == Overruled()
    assert overruled(StudyFiles(results), "ur5", QUESTIONS, REASON) == Overruled()


def test_each_verdict_against_it_is_named_with_its_reason_and_the_option(results: Path) -> None:
    judged(
        results,
        verdict("force", "do not use", "", reason="blind"),
        verdict("constants", "do not use", reason="unlikely"),
        verdict("links", "do not use", reason="worse_than_zero"),
    )
    with pytest.raises(InputError) as refused:
        overruled(StudyFiles(results), "ur5", QUESTIONS, " ")
    message = str(refused.value)
    for code, question in (("blind", "force"), ("unlikely", "constants")):
        assert f"{question}: do not use. {reason_in_words(code)}"[:-1] in message
    assert '--accept "<reason>"' in message
    assert "links" not in message


def test_an_arm_is_judged_by_itself_where_it_was(results: Path) -> None:
    judged(
        results,
        verdict("constants", "do not use", "kuka-kr300", reason="unknown_links"),
        verdict("constants", "usable"),
        verdict("constants", "do not use", "", reason="unknown_links"),
    )
    study = StudyFiles(results)
    assert overruled(study, "ur5", QUESTIONS, "") == Overruled()
    with pytest.raises(InputError, match="constants: do not use"):
        overruled(study, "kuka-kr300", QUESTIONS, "")


def test_results_without_verdicts_are_exported_for_a_reason_alone(results: Path) -> None:
    study = StudyFiles(results)
    with pytest.raises(InputError, match=r"no verdicts, .* `ur5 run mine` again; .*--accept"):
        overruled(study, "ur5", QUESTIONS, "")
    assert overruled(study, "ur5", QUESTIONS, "an old study").reason == "an old study"


def comments(text: str) -> list[str]:
    """The comments before the root element of an XML file, which are read as XML."""
    builder = ElementTree.XMLPullParser(["comment", "start"])
    builder.feed(text)
    read: list[tuple[str, Any]] = [*builder.read_events()]
    root = next(place for place, (event, _) in enumerate(read) if event == "start")
    return [str(element.text) for _, element in read[:root]]


def read_by_others(text: str, to: str) -> None:
    """Read an arm as the program reads it that it is for."""
    if to == "urdf":
        pinocchio.buildModelFromXML(text)
    elif to == "mjcf":
        mujoco.MjModel.from_xml_string(text)


@pytest.mark.parametrize("to", ["urdf", "mjcf", "sdf", "isaac", "json"])
@pytest.mark.parametrize("question", ["constants", "currents"])
def test_what_may_not_be_used_is_exported_with_the_reason_in_the_file(
    built_workflow: Workflow, tmp_path: Path, question: str, to: str
) -> None:
    results = tmp_path / "small"
    results.mkdir()
    for part in ("parameters", "recordings", "configuration.yaml"):
        (results / part).symlink_to(built_workflow.folder / "results" / "small" / part)
    judged(results, verdict(question, "do not use", reason="contradicted"))
    with pytest.raises(InputError, match=f"{question}: do not use"):
        exported("ur5", None, to, results, "")
    text = exported("ur5", None, to, results, "", accept=REASON)
    stated = " ".join(REASON.split())
    if to == "json":
        accepted = json.loads(text)["accepted"]
        assert accepted["reason"] == stated
        assert accepted["verdicts"] == [
            f"{question}: do not use. {reason_in_words('contradicted')}"
        ]
    elif to == "isaac":
        assert stated in text.splitlines()[0]
        assert {*yaml.safe_load(text)} == {"arm"}
    else:
        assert stated.replace("--", "- -") in comments(text)[0]
        read_by_others(text, to)
    judged(results, verdict(question))
    plain = exported("ur5", None, to, results, "")
    assert "lesson" not in plain + exported("ur5", None, to, results, "", accept=REASON)
