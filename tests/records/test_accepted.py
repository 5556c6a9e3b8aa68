"""A stop sign that the study accepts is a warning with its reason, and nothing waits for it."""

import ast
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.command import Command
from tests.conftest import PROJECT, said
from tests.current_study import CONSTANT, noisy, prior, smooth
from tests.made_records import motion_of
from tests.made_study import study as results_of
from tests.synthetic import poor_log
from tests.typeset_page import page_of, plain
from ur5lib.channels import columns
from ur5lib.checks import files
from ur5lib.errors import InputError
from ur5lib.force.residual_model import Residuals
from ur5lib.identification.prior import Prior
from ur5lib.identification.regression import Normal
from ur5lib.records.accepted import accepting, up_to_first_standing
from ur5lib.records.aligned_recording import AlignedRecording
from ur5lib.records.codes import CauseCode, Found
from ur5lib.records.models import Identification
from ur5lib.records.quality import Contradictions, contradiction
from ur5lib.records.signals import Signals
from ur5lib.report.found import findings
from ur5lib.report.results import Results
from ur5lib.robots.description import Robot
from ur5lib.steps.compute_torques import compute_torques
from ur5lib.steps.fit_friction import ContradictionError, fitted_friction, require_no_stop_sign
from ur5lib.steps.make_tables import remarks
from ur5lib.study.accept import Accept
from ur5lib.study.reading import parse_study
from ur5lib.tables import write_table

REASON = "as in the maker's manual"
STUDY = """
study: mine
title: Mine
recordings:
- {name: run, robot: ur5, format: table-csv, folder: ., file: run.csv, role: validate,
   columns: [time, actual_q, actual_qd, actual_current]%s}
"""


# Kinds


def test_each_stop_sign_has_one_kind_that_a_study_may_name() -> None:
    modules = (ast.parse(path.read_text()) for path in (PROJECT / "ur5lib/checks").glob("*.py"))
    nodes = (node for module in modules for node in ast.walk(module) if isinstance(node, ast.Call))
    signs = [node for node in nodes if getattr(node.func, "id", "") == "contradiction"]
    kinds = [ast.literal_eval(sign.args[1]) for sign in signs]
    assert len(kinds) > 20
    assert kinds.count("") == 1  # an unknown unit, which no study may overrule
    assert {*kinds} - {""} | {"side"} == Accept.model_fields.keys()  # that of an arm, by its fit


def parsed(**accept: object) -> dict[str, str]:
    entry = {"name": "a", "robot": "ur5", "format": "thesis-csv", "role": "contact"}
    entry |= {"simulate": {"trajectory": {"kind": "standstill"}}, "accept": accept}
    raw = {"study": "s", "title": "t", "accept": {"order": "all", "sign": "all"}}
    return parse_study(raw | {"recordings": [entry]}, "s.yaml").recordings[0].accepted()


def test_a_recording_has_the_reasons_of_the_study_and_its_own() -> None:
    assert parsed(order="own", unit="own") == {"order": "own", "sign": "all", "unit": "own"}


@pytest.mark.parametrize(
    ("accept", "told"), [({"ordr": REASON}, "did you mean `order`"), ({"order": " "}, "reason")]
)
def test_other_kinds_and_empty_reasons_are_errors(accept: dict[str, str], told: str) -> None:
    with pytest.raises(InputError, match=told):
        parsed(**accept)


# Recordings


ORDER, LATE = (
    contradiction(CauseCode.EXCHANGED_JOINTS, "order", "joints 1 and 3 are exchanged"),
    contradiction(CauseCode.LATE_CURRENT, "delay", "actual_current comes later"),
)


def test_an_accepted_stop_sign_is_a_warning_and_others_stand() -> None:
    found = accepting(Contradictions([ORDER, LATE]), {"order": REASON})
    assert found.stop_signs == [LATE]
    (warning,) = found.findings
    assert (warning.code, warning.severity) == (Found.ACCEPTED_STOP_SIGN, "warning")
    rows = pd.DataFrame(map(files.quality_row, files.findings(files.Quality(), found)))
    told = rows.loc[rows["code"] == Found.ACCEPTED_STOP_SIGN, "detail"].item()
    assert told.startswith(f"accepted by the study: {REASON}")
    assert "joints 1 and 3" in told
    assert "`accept: {delay:" in rows.loc[rows["severity"] == "stop", "detail"].item()
    require_no_stop_sign({"run": accepting(Contradictions([ORDER]), {"order": REASON})})


def test_a_reason_that_nothing_needs_is_a_note() -> None:
    found = accepting(Contradictions([]), {"order": REASON})
    (note,) = found.findings
    assert note.severity == "note"
    assert "order" in said(note)


def test_behind_an_accepted_stop_sign_others_are_looked_for() -> None:
    signs = [ORDER, LATE, contradiction(CauseCode.UNDECLARED_LOAD, "payload", "2 kg more")]
    assert [*up_to_first_standing(signs, [])] == signs[:1]
    assert [*up_to_first_standing(signs, ["order"])] == signs[:2]


@pytest.fixture(scope="module")
def exchanged(ur5: Robot) -> pd.DataFrame:
    """A right log whose columns of joints 1 and 3 are exchanged."""
    log, names = poor_log(ur5, 32.0, seed=1), ("actual_q", "actual_qd", "actual_current")
    pairs = [[f"{name}_0", f"{name}_2"] for name in names]
    return log.assign(**{one: log[other] for pair in pairs for one, other in (pair, pair[::-1])})


@pytest.mark.parametrize(
    ("accept", "status", "told"),
    [
        ("", 1, "`accept: {order: the reason}` overrules this"),
        (f", accept: {{order: {REASON}}}", 1, "`accept: {constants: the reason}` overrules this"),
        (f", accept: {{order: {REASON}, constants: well}}", 0, f"accepted by the study: {REASON}"),
        (f", accept: {{delay: {REASON}}}", 1, "`accept` names delay"),
    ],
)
def test_a_check_prints_it_and_goes_on(
    exchanged: pd.DataFrame,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    run_ur5: Command,
    accept: str,
    status: int,
    told: str,
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "500")
    exchanged.to_csv("run.csv", index=False)
    Path("study.yaml").write_text(STUDY % accept)
    answer = run_ur5("check", "study.yaml")
    assert (answer.status, answer.line.count(told)) == (status, 1)


def test_the_torques_of_an_accepted_recording_rest_on_no_stop_sign(
    exchanged: pd.DataFrame, ur5: Robot, tmp_path: Path
) -> None:
    file, time = tmp_path / "signals.parquet", exchanged["time"].to_numpy()
    write_table(exchanged.assign(segment=0, interpolated=False), file)
    q, qd = (exchanged[columns(name)].to_numpy() for name in ("actual_q", "actual_qd"))
    motion, signals = motion_of(time, q, qd), Signals.read(file)
    recording = AlignedRecording(
        role="validate", signals=signals, motion=motion, gravity=None, untouched=None
    )
    stopped, passed = (
        compute_torques(recording, ur5, {"currents": 2.0}, accepted=accept).premises
        for accept in (None, {"order": REASON, "constants": REASON})
    )
    assert [sign.cause for sign in stopped.contradictions.stop_signs] == [
        CauseCode.EXCHANGED_JOINTS
    ]
    assert passed.contradictions.stop_signs == []
    assert [one.code for one in passed.contradictions.findings][:2] == [
        Found.ACCEPTED_STOP_SIGN
    ] * 2


# Arms


def test_accepted_torque_constants_are_fitted_and_remarked() -> None:
    records, inverse = noisy((1, 2), seconds=12.0), 1 / (0.4 * CONSTANT)
    other = Prior(Normal(inverse, np.diag((0.1 * inverse) ** -2.0)), np.full(6, 150.0))
    with pytest.raises(ContradictionError):
        fitted_friction(records, other, smooth)
    fitted = fitted_friction(records, other, smooth, "", {"constants": REASON})
    assert len(fitted.fit.joints) == 6
    assert fitted.stopped is None
    told = remarks(Identification(), fitted, Residuals())
    (row,) = (row for row in told if row.code == CauseCode.ACCEPTED_STOP_SIGN)
    assert REASON in row.remark
    assert fitted_friction(records, prior(), smooth, "", {"constants": REASON}).remarks == []


# The report


def accepted_on(*names: str, detail: str) -> Results:
    warning = asdict(accepting(Contradictions([ORDER]), {"order": REASON}).findings[0])
    row = {key: warning[key] for key in ("device", "code", "severity", "count")}
    return results_of(quality=[row | {"recording": name, "detail": detail} for name in names])


def test_first_screen_and_section_name_the_reason() -> None:
    detail = f"accepted by the study: {REASON}; found: joints 1 and 3"
    results = accepted_on("pushed", detail=detail)
    page = page_of(results)
    said = plain(page.get_element_by_id("recordings").text_content())
    assert f"The study overrules a stop sign on R3 pushed: {detail}." in said
    (card,) = page.xpath("//article[@data-question='recordings']")
    assert "The study overrules a stop sign." in plain(card.text_content())
    assert any(REASON in told and "“pushed”" in told for told in findings(results))
    assert "overrules" not in plain(page_of(results_of()).text_content())


def test_of_many_reasons_the_first_are_told() -> None:
    quality = [
        {
            "recording": "seen",
            "code": Found.ACCEPTED_STOP_SIGN,
            "severity": "warning",
            "device": "robot",
        }
        | {"detail": f"accepted by the study: reason {k}; found: it", "count": 0}
        for k in range(9)
    ]
    page = page_of(results_of(quality=quality))
    said = plain(page.get_element_by_id("recordings").text_content())
    assert said.count("The study overrules a stop sign on") == 4
    assert "It overrules 5 more" in said
