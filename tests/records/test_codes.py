"""Codes of findings: whoever looks one up does so by its code, and its name is free to change."""

import ast
import random
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

import pytest

from tests.conftest import PROJECT
from tests.made_study import ROLES, study, touched
from tests.typeset_page import text_of
from ur5lib.checks.files import name_copies, quality_row
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.judgement import Judgement
from ur5lib.records.quality import Finding, Severity
from ur5lib.report.page.findings import by_finding
from ur5lib.report.results import Results
from ur5lib.report.summary import page_data
from ur5lib.report.views import forces, recordings
from ur5lib.tables import read_record, write_json

DRAWN = [Found.LOST_FRAMES, *random.Random(106).sample([*Found], 10)]
SHIPPED = [*PROJECT.glob("ur5*/**/*.py")]
WITH_CAUSE = ("Remark", "RefusalError", "ContradictionError")
MIXED: dict[str, Severity] = {"fitted": "note", "seen": "error", "pushed": "warning"}


def found(codes: Sequence[Found], severities: Mapping[str, Severity] = MIXED) -> Results:
    """A judged study with findings of some kinds on each recording."""
    rows = [
        {"recording": name, **asdict(quality_row(Finding(device, code, severity, 200, "a: so")))}
        for name, severity in severities.items()
        for code in codes
        for device in ("robot", "force")
    ]
    return study(quality=rows, force_mae=touched(2.0))


def reactions(results: Results) -> str:
    """All that is judged, counted and shown of a study, as text."""
    rows = [by_finding(results.tables["quality"]), name_copies(results.tables["quality"], ROLES)]
    rows += [recordings.legend(results)]
    rows += [own for name, own in results.tables.items() if name != "quality"]
    named = recordings.accepted_signs(results), recordings.late(results)
    saturated = forces.saturated(results, [*ROLES])
    return str([page_data(results), *(own.to_csv() for own in rows), named, saturated])


@pytest.mark.parametrize("severities", [MIXED, dict.fromkeys(MIXED, "stop")])
@pytest.mark.parametrize("code", DRAWN)
def test_a_name_may_change(
    code: Found, severities: Mapping[str, Severity], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Verdicts, uses, advice, counts and what pages show stay, but for the name."""
    before, name = reactions(found([code], severities)), code.words
    monkeypatch.setattr(code, "words", "named anew")
    assert reactions(found([code], severities)).replace("named anew", name) == before


def test_pages_show_the_new_names(monkeypatch: pytest.MonkeyPatch) -> None:
    for k, code in enumerate(DRAWN):
        monkeypatch.setattr(code, "words", f"named anew {k}")
    text = text_of(found(DRAWN))
    assert [code for code in DRAWN if code.words not in text] == []


def test_files_keep_codes_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A name that changes makes no stored result stale; exports look codes up, too."""
    own = Judgement(findings=[Finding("force", code, "note", 1, "so") for code in Found])
    write_json(own, tmp_path / "judgement.json")
    for code in Found:
        monkeypatch.setattr(code, "words", "named anew")
    assert read_record(Judgement, tmp_path / "judgement.json") == own


def test_no_name_of_a_finding_and_no_cause_is_typed_twice() -> None:
    """In code that ships; names of one word are words of other things, too."""
    names = {*(code.words for code in Found), *CauseCode}
    typed = {name for name in names if " " in name} - {CauseCode.OTHER_REASON.value}
    places = {
        (node.value, path.name)
        for path in SHIPPED
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Constant) and node.value in typed
    }
    assert {place for _, place in places} == {"codes.py"}


def test_a_remark_and_a_refusal_have_a_cause_of_the_list() -> None:
    """Their records, on a floor below the list, hold texts."""
    own = [
        (path.name, ast.unparse(node))
        for path in SHIPPED
        for node in ast.walk(ast.parse(path.read_text()))
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") in WITH_CAUSE
        if node.args and isinstance(node.args[0], ast.Constant)
    ]
    assert {name for name, _ in own} == {"errors.py"}, own


def test_a_code_is_its_member_in_lower_case_and_each_has_a_name_of_its_own() -> None:
    assert [code.value for code in Found] == [code.name.lower() for code in Found]
    assert len({code.words for code in Found} - {""}) == len(Found)
