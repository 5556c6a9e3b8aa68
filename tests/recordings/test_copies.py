"""One run in two recordings is found by its contents, and a repeated motion is another run."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from tests.command import Command
from tests.made_study import study as results_of
from tests.made_tables import record, table
from tests.synthetic import poor_log
from ur5lib.channels import columns
from ur5lib.checks.files import name_copies
from ur5lib.recordings.copies import (
    MAX_ROWS_KEPT,
    MIN_ROWS_COMPARED,
    efforts_in,
    fingerprint,
)
from ur5lib.recordings.less_gravity import TORQUE_LESS_GRAVITY
from ur5lib.records.codes import Found
from ur5lib.records.force_errors import Compared
from ur5lib.records.judgement import Judgement
from ur5lib.records.quality import Finding
from ur5lib.report.page.findings import by_finding
from ur5lib.robots.description import Robot
from ur5lib.steps.make_tables import (
    OF_RECORDINGS,
    found_of_recordings,
    rows_of_recordings,
    without_copies,
)

STUDY = """
study: mine
title: Mine
recordings:
- {name: run, robot: ur5, format: table-csv, folder: ., file: run.csv, role: fit,
   columns: [time, actual_q, actual_qd, actual_current]}
- {name: other, robot: ur5, format: parquet, folder: ., file: other.parquet, role: validate,
   channels: {time: time, actual_q: q, actual_qd: qd, actual_current: current}}
"""
SHORT = {"q": "actual_q", "qd": "actual_qd", "current": "actual_current"}


def repeated(log: pd.DataFrame) -> pd.DataFrame:
    """The same motion to the last digit, with other noise of the currents."""
    names = columns("actual_current")
    noise = np.random.default_rng(1).normal(scale=0.03, size=(len(log), len(names)))
    return log.assign(**dict(zip(names, (log[names] + noise).to_numpy().T, strict=True)))


COPIES: dict[str, Callable[[pd.DataFrame], pd.DataFrame]] = {
    "whole": lambda log: log,
    "with another clock": lambda log: log.assign(time=log["time"] + 1.7e9),
    "cut": lambda log: log[1003:2500],
    "slower": lambda log: log[::4],
    "with gaps and without order": lambda log: log.sample(frac=0.6, random_state=1),
}


@pytest.fixture(scope="module")
def log(ur5: Robot) -> pd.DataFrame:
    return poor_log(ur5, 32.0, seed=1)


@pytest.fixture
def check(log: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, run_ur5: Command):
    """Check a study of the log and of another one, in another format; digits are lost."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "500")
    log.to_csv("run.csv", index=False, float_format="%.5f")
    Path("study.yaml").write_text(STUDY)

    def check(other: pd.DataFrame, *named: str) -> tuple[int, str]:
        arrays = {short: [*other[columns(name)].to_numpy()] for short, name in SHORT.items()}
        pd.DataFrame({"time": other["time"].to_numpy()} | arrays).to_parquet("other.parquet")
        answer = run_ur5("check", "study.yaml", *named)
        return answer.status, answer.line

    return check


@pytest.mark.parametrize("copy", COPIES)
def test_a_copy_is_said_of_both(log: pd.DataFrame, check: Callable, copy: str) -> None:
    """The one that is fitted stays, whatever their order."""
    status, printed = check(COPIES[copy](log))
    assert status == 0
    assert printed.count("run, other are one run: their rows are equal, and other would count") == 1


def test_a_command_that_is_sent_again_is_no_measurement(log: pd.DataFrame, check: Callable) -> None:
    """The arm follows it otherwise; a copy of the whole run is said to be one alone."""
    sent, again = log.round(5), "run and other have the same efforts"
    moved = sent.assign(**{name: 1.01 * sent[name] for name in columns("actual_q")})
    status, printed = check(moved)
    assert (status, printed.count(again)) == (0, 1)
    assert again not in check(sent)[1]
    assert again not in check(repeated(sent))[1]


def test_a_command_is_known_as_it_was_read(log: pd.DataFrame) -> None:
    """Gravity, which is added to torques without it, differs with the motion."""
    torques = dict(zip(columns("actual_current"), columns(TORQUE_LESS_GRAVITY), strict=True))
    less = log.rename(columns=torques)
    assert efforts_in(less) == efforts_in(less.assign(actual_q_1=0.0)) != ""
    assert efforts_in(less[columns("actual_q")]) == ""


def test_a_copy_is_said_of_a_recording_that_is_named(log: pd.DataFrame, check: Callable) -> None:
    status, printed = check(log, "run")
    assert status == 0
    assert "run, other are one run" in printed


@pytest.mark.parametrize("roles", [("fit", "fit"), ("validate", "contact"), ("contact", "fit")])
def test_copies_of_which_neither_is_to_spare_are_a_stop_sign(
    log: pd.DataFrame, check: Callable, roles: tuple[str, str]
) -> None:
    text = Path("study.yaml").read_text()
    for before, role in zip(("fit", "validate"), roles, strict=True):
        text = text.replace(f"role: {before},", f"role: {role} ,")
    Path("study.yaml").write_text(text)
    status, printed = check(log)
    assert status == 1
    assert "run, other are one run" in printed


def findings(**runs: int) -> pd.DataFrame:
    """The rows of recordings of which those of one number are one run."""
    rows = [
        {"recording": name, "device": "robot", "code": Found.SAME_RUN, "severity": "note"}
        | {"count": 0, "detail": " ".join(str(100 * run + k) for k in range(MIN_ROWS_COMPARED))}
        | {"place": "", "finding": Found.SAME_RUN.words}
        for name, run in runs.items()
    ]
    return pd.DataFrame(rows)


def test_a_spare_copy_is_left_out_and_costs_nothing_else(ur5: Robot) -> None:
    """Before, a doubled validate recording made the force of a study not to be used."""
    quality = findings(fit=1, seen=2, again=2, third=2, pushed=3, seen_fit=1)
    roles = {"fit": "fit", "pushed": "contact"}
    roles |= dict.fromkeys(("seen", "again", "third", "seen_fit"), "validate")
    judgements = {
        row.recording: Judgement(findings=[Finding("robot", Found.SAME_RUN, "note", 0, row.detail)])
        for row in quality.itertuples()
    }
    sensed = dict.fromkeys(judgements, record(Compared, {"sensed": {"contacts": 1}}))
    rows = rows_of_recordings(judgements, sensed, {}, {})
    rows["quality"] = found_of_recordings(judgements, {}, {}, {}, roles)
    tables = {name: table(OF_RECORDINGS[name], own) for name, own in rows.items()}
    tables = without_copies(tables, roles)
    assert [*tables["sensed"]["recording"]] == ["fit", "seen", "pushed"]
    found = tables["quality"].set_index("recording")["severity"]
    assert found.to_dict() == dict.fromkeys(roles.keys() - {"pushed"}, "warning")
    assert not results_of(quality=tables["quality"].to_dict("records")).stopped()


def test_each_run_that_recordings_repeat_is_said_once() -> None:
    """Whatever the numbers in their names are."""
    runs = {f"log_{k}{copy}": k for k in (10, 20) for copy in "ab"}
    stated = by_finding(name_copies(findings(**runs)))
    assert [*stated["recordings"]] == [["log_10a", "log_10b"], ["log_20a", "log_20b"]]


def test_a_repeated_motion_is_another_run(log: pd.DataFrame, check: Callable) -> None:
    status, printed = check(repeated(log))
    assert status == 0
    assert "one run" not in printed


def test_a_fingerprint_is_small_and_needs_currents(log: pd.DataFrame) -> None:
    assert len(fingerprint(log)) == MAX_ROWS_KEPT
    assert fingerprint(log.drop(columns=columns("actual_current"))) == []
    damaged = log.assign(actual_q_0=1e300, actual_current_0=np.nan)
    assert fingerprint(damaged) == []
